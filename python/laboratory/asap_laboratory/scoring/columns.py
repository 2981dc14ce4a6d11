"""The main figures of `score` in tables: their headings, meaning and cells."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from asap_laboratory.page import Cell, Row, fixed, spread

TRACKER = {
    "mota": ("MOTA", "1 - (misses + false ones + id switches) / objects; may be negative"),
    "id_switches": ("switches", "matched objects whose id is another than before, per run"),
    "idf1": ("IDF1", "one assignment of ids to objects for the whole scene"),
    "hota": ("HOTA", "detection and association over all strictnesses of the match"),
    "position_rms": ("rms px", "rms error of the position"),
    "velocity_rms": ("velocity", "rms error of the velocity, of the rms speed"),
    "v_measure": ("V", "events as a partition, noise as a class"),
}
CORNERS = {
    "precision": ("precision", "share of the events called corners that are corners"),
    "recall": ("recall", "share of the corner events that are called so"),
    "false_positive_rate": ("false", "share of the other events that are called corners"),
    "f_measure": ("F", "harmonic mean of precision and recall"),
    "corner_events": ("corners", "events called corners"),
}

_WRITTEN: dict[str, tuple[Callable[[float], str], str]] = {
    "id_switches": (lambda value: f"{value:.1f}" if value < 100 else f"{value:.0f}", ""),
    "position_rms": (lambda value: f"{value:.2f}", ""),
    "velocity_rms": (lambda value: f"{100 * value:.0f}", " %"),
    "corner_events": (lambda value: f"{value:,.0f}", ""),
}

CELLS: Mapping[str, Cell] = {
    **{name: spread(name, *_WRITTEN.get(name, (fixed, ""))) for name in (*TRACKER, *CORNERS)},
    "told": lambda row: {None: "", True: "told", False: "not told"}[row["told"]],
}
"""Mean and deviation of each figure over the seeds, and whether the algorithm knew gamma."""


def columns_of(row: Row) -> dict[str, tuple[str, str]]:
    """Return the columns of a tracker, or those of a corner detector."""
    return TRACKER if row.get("corner_events") is None else CORNERS
