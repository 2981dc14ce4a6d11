"""Scores over the kept fraction as text: a line for each gamma, mean and spread over seeds."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING

from asap import _units

if TYPE_CHECKING:
    from asap_laboratory.scoring.result import KeepCurve, KeepRow

TRACKER_COLUMNS = {
    "mota": ("MOTA", "1 - (misses + false clusters + id switches) / objects; may be negative"),
    "id_switches": ("switches", "matched objects whose id is another than before, per run"),
    "idf1": ("IDF1", "one assignment of ids to objects for the whole scene"),
    "hota": ("HOTA", "detection and association over all strictnesses of the match"),
    "position_rms": ("rms px", "rms error of the position"),
    "velocity_rms": ("velocity", "rms error of the velocity, of the rms speed"),
    "v_measure": ("V", "events as a partition, noise as a class"),
}
CORNER_COLUMNS = {
    "precision": ("precision", "share of the events called corners that are corners"),
    "recall": ("recall", "share of the corner events that are called so"),
    "false_positive_rate": ("false", "share of the other events that are called corners"),
    "f_measure": ("F", "harmonic mean of precision and recall"),
    "corner_events": ("corners", "events called corners"),
}
"""Every column: heading, and what it is in words."""


def format_keep_curve(curve: KeepCurve) -> str:
    """Write the scores of an algorithm over gamma as a text table of at most 100 columns."""
    (head, *lines), rule = _units.aligned(cells(curve), left=2)
    return "\n".join([title(curve), "", head, rule, *lines])


def title(curve: KeepCurve) -> str:
    """Name a curve by its algorithm and its scene."""
    behind = f" behind {curve.before}" if curve.before else ""
    count = curve.rows[0].seeds
    seeds = "1 seed" if count == 1 else f"{count} seeds: mean ± standard deviation"
    return f"{curve.algorithm}{behind} on {curve.scene}, {seeds}"


def cells(curve: KeepCurve) -> list[tuple[str, ...]]:
    """Write every row, the headings first."""
    rows = curve.rows
    columns = columns_of(rows[0])
    return [
        ("gamma", "", *(heading for heading, _ in columns.values())),
        *((f"{row.gamma:g}", told(row), *(cell(row, c) for c in columns)) for row in rows),
    ]


def columns_of(row: KeepRow) -> dict[str, tuple[str, str]]:
    """Return the columns of a tracker, or those of a corner detector."""
    return TRACKER_COLUMNS if "mota" in row.mean else CORNER_COLUMNS


def told(row: KeepRow) -> str:
    """Say whether the algorithm knew gamma."""
    return {None: "", True: "told", False: "not told"}[row.told]


def cell(row: KeepRow, column: str) -> str:
    """Write mean and spread; nothing where the figure does not exist."""
    mean, spread = row.mean[column], row.spread[column]
    if math.isnan(mean):
        return "-"
    text = _number(mean, column)
    if not math.isnan(spread):
        text += f"±{_number(spread, column)}"
    return f"{text} %" if column == "velocity_rms" else text


def _number(value: float, column: str) -> str:
    if column == "velocity_rms":
        return f"{100 * value:.0f}"
    if column == "corner_events":
        return f"{value:,.0f}"
    if column == "id_switches":
        return f"{value:.1f}" if value < 100 else f"{value:.0f}"
    if column == "position_rms":
        return f"{value:.2f}"
    return re.sub(r"^(-?)0\.", r"\1.", f"{value:.3f}")
