"""The figure of scores over gamma. Needs matplotlib: ``asap-events[report]``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from asap import plots  # first: it says which extra is missing
from asap_laboratory.page import Rows
from asap_laboratory.scoring.columns import TRACKER, columns_of

import matplotlib  # isort: skip
from matplotlib.ticker import FixedLocator, NullLocator  # isort: skip

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_TRACKER = {
    "mota": "MOTA",
    "hota": "HOTA",
    "position_rms": "position error [px]",
    "id_switches": "id switches",
}
_CORNERS = {
    "precision": "precision",
    "recall": "recall",
    "f_measure": "F",
    "false_positive_rate": "false-positive rate",
}
_COLOURS = (plots.BLUE, plots.VERMILION, plots.GREEN, plots.PURPLE, plots.INK, plots.FAINT)
_SHARES = {"mota", "hota", "idf1", "precision", "recall", "f_measure", "v_measure"}


def figure(
    curves: Mapping[str, Rows], *, title: str | None = None, width_inches: float = 4.6
) -> Figure:
    """Draw scores over gamma, a colour for each curve: told as a line, not told dashed.

    `curves`: means over the seeds by the label of the algorithm, all of trackers or all of corner
    detectors; bars are standard deviations over the seeds.
    """
    first = next(iter(curves.values()))[0]
    shown = _TRACKER if columns_of(first) is TRACKER else _CORNERS
    with matplotlib.rc_context({**plots.STYLE, "axes.titley": 1.0}):
        page = plots.NotebookFigure(layout="constrained")
        panels = page.subplots(2, 2).ravel()
        for axes, (column, words) in zip(panels, shown.items(), strict=True):
            for number, (label, rows) in enumerate(curves.items()):
                draw(axes, label, rows, column, colour=_COLOURS[number % len(_COLOURS)])
            axes.set_title(words)
        if title:
            page.suptitle(title, x=0.01, ha="left", fontsize=10)
        handles, labels = panels[0].get_legend_handles_labels()
        page.legend(handles, labels, loc="outside lower center", ncols=2)
        page.set_size_inches(width_inches, 4.2 + 0.2 * -(-len(labels) // 2))
    return page


def draw(axes: Axes, label: str, rows: Rows, column: str, *, colour: str = plots.BLUE) -> None:
    """Draw one score of one algorithm over gamma, from all events on the left to few."""
    name = label.lstrip("_") or label  # a legend leaves out what begins with one
    known: set[bool | None] = {row["told"] for row in rows}
    ways: list[bool | None] = [way for way in (True, False) if way in known]
    for way in ways or [None]:
        some = [row for row in rows if row["told"] in (None, way)]
        both = {True, False} <= known
        words = f"{name}, {'told' if way else 'not told'}" if both else name
        dashes: Any = (0, (3, 2)) if both and not way else "-"
        _line(axes, some, column, linestyle=dashes, color=colour, label=words)
    gammas = sorted({row["gamma"] for row in rows})
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(FixedLocator(gammas))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}".removeprefix("0"))
    axes.set_xlim(gammas[-1] * 1.15, gammas[0] / 1.15)
    axes.set_xlabel("gamma")
    if column in _SHARES:
        axes.set_ylim(max(-0.5, min(-0.03, axes.get_ylim()[0])), 1.04, auto=True)
    else:
        axes.set_ylim(bottom=0, auto=True)  # the next curve may be higher


def _line(axes: Axes, rows: Rows, column: str, **style: Any) -> None:
    gamma = [row["gamma"] for row in rows]
    mean, spread = (
        np.array([row[name] for row in rows], np.float64) for name in (column, f"{column}_sd")
    )
    bars = np.nan_to_num(spread)
    axes.errorbar(gamma, mean, bars, marker="o", markersize=2.5, elinewidth=0.8, **style)
