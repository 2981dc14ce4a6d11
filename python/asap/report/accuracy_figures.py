"""Figures of accuracy: scores over the kept fraction.

Needs matplotlib: ``asap-events[report]``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from asap import plots  # first: it says which extra is missing
from asap.results import accuracy_table

import matplotlib  # isort: skip
from matplotlib.ticker import FixedLocator, NullLocator  # isort: skip

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from asap.results.keep_curve import KeepCurve, KeepRow

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
    curves: Sequence[KeepCurve],
    *,
    title: str | None = None,
    width_inches: float = 9.0,
    columns: int = 4,
) -> Figure:
    """Draw scores over gamma, a colour for each curve: told as a line, not told dashed.

    Parameters
    ----------
    curves : sequence of KeepCurve
        All of trackers, or all of corner detectors.
    title : str, optional
        Of the page.
    width_inches : float
        Of the page.
    columns : {1, 2, 4}
        Scores side by side; 1 or 2: for narrow screens.

    Returns
    -------
    matplotlib.figure.Figure
        Shown by a notebook as it is; ``.savefig(path)`` writes it. Bars are standard deviations
        over the seeds.
    """
    is_tracker = accuracy_table.columns_of(curves[0].rows[0]) is accuracy_table.TRACKER_COLUMNS
    shown = _TRACKER if is_tracker else _CORNERS
    rows = len(shown) // columns
    with matplotlib.rc_context({**plots.STYLE, "axes.titley": 1.0}):
        page = plots.NotebookFigure(layout="constrained")
        panels = page.subplots(rows, columns, squeeze=False).ravel()
        for axes, (column, words) in zip(panels, shown.items(), strict=True):
            for curve, colour in zip(curves, _cycle(curves), strict=True):
                draw(axes, curve, column, colour=colour)
            axes.set_title(words)
        if title:
            page.suptitle(title, x=0.01, ha="left", fontsize=10)
        handles, labels = panels[0].get_legend_handles_labels()
        page.legend(handles, labels, loc="outside lower center", ncols=columns)
        lines = -(-len(labels) // columns)
        page.set_size_inches(width_inches, 2.2 * rows + 0.2 * lines)
    return page


def draw(axes: Axes, curve: KeepCurve, column: str, *, colour: str = plots.BLUE) -> None:
    """Draw one score of one algorithm over gamma, from all events on the left to few.

    Parameters
    ----------
    axes : Axes
        Where to draw.
    curve : KeepCurve
        What `asap.keep_curve` returns.
    column : str
        A figure of `asap.score`.
    colour : str
        Of its lines.
    """
    rows = curve.rows
    name = f"{curve.before} + {curve.algorithm}" if curve.before else curve.algorithm
    name = name.lstrip("_") or name  # a legend leaves out what begins with one
    known: set[bool | None] = {row.told for row in rows}
    ways: list[bool | None] = [way for way in (True, False) if way in known]
    for way in ways or [None]:
        some = [row for row in rows if row.told in (None, way)]
        both = {True, False} <= known
        words = f"{name}, {'told' if way else 'not told'}" if both else name
        dashes: Any = (0, (3, 2)) if both and not way else "-"
        _line(axes, some, column, linestyle=dashes, color=colour, label=words)
    gammas = sorted({row.gamma for row in rows})
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


def _line(axes: Axes, rows: Sequence[KeepRow], column: str, **style: Any) -> None:
    gamma = [row.gamma for row in rows]
    mean = [row.mean[column] for row in rows]
    spread = np.nan_to_num([row.spread[column] for row in rows])
    axes.errorbar(gamma, mean, spread, marker="o", markersize=2.5, elinewidth=0.8, **style)


def _cycle(curves: Sequence[KeepCurve]) -> list[str]:
    return [_COLOURS[number % len(_COLOURS)] for number in range(len(curves))]
