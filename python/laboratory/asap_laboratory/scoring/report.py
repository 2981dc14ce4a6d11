"""The page about scores over gamma."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from asap import plots  # first: it says which extra is missing
from asap.results import page as pages
from asap.results import text
from asap_laboratory.scoring import table as accuracy_table

import matplotlib  # isort: skip
from matplotlib.ticker import FixedLocator, NullLocator  # isort: skip


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from asap_laboratory.scoring.result import KeepCurve, KeepRow


def write(curve: KeepCurve, path: str | os.PathLike[str], title: str = "ASAP accuracy") -> Path:
    """Write one HTML file about the scores of an algorithm over gamma."""
    return pages.write(path, title, _articles(curve))


def _articles(curve: KeepCurve) -> Iterator[pages.Article]:
    head, *rows = accuracy_table.cells(curve)
    columns = accuracy_table.columns_of(curve.rows[0]).values()
    yield pages.Article(
        "keep-curve",
        curve.summary(),
        text.heading(accuracy_table.title(curve)) + text.table(head, rows),
        figure([curve], width_inches=8.6),
        "Scores over the fraction of the events that is kept. Told: the algorithm knew it. Bars "
        "are standard deviations over the seeds.",
        {"What the columns say": text.table((), columns)},
    )


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
) -> Figure:
    """Draw scores over gamma, a colour for each curve: told as a line, not told dashed.

    All curves are of trackers, or all of corner detectors; bars are standard deviations over the
    seeds.
    """
    is_tracker = accuracy_table.columns_of(curves[0].rows[0]) is accuracy_table.TRACKER_COLUMNS
    shown = _TRACKER if is_tracker else _CORNERS
    with matplotlib.rc_context({**plots.STYLE, "axes.titley": 1.0}):
        page = plots.NotebookFigure(layout="constrained")
        panels = page.subplots(1, len(shown))
        for axes, (column, words) in zip(panels, shown.items(), strict=True):
            for curve, colour in zip(curves, _cycle(curves), strict=True):
                draw(axes, curve, column, colour=colour)
            axes.set_title(words)
        if title:
            page.suptitle(title, x=0.01, ha="left", fontsize=10)
        handles, labels = panels[0].get_legend_handles_labels()
        page.legend(handles, labels, loc="outside lower center", ncols=len(shown))
        lines = -(-len(labels) // len(shown))
        page.set_size_inches(width_inches, 2.2 + 0.2 * lines)
    return page


def draw(axes: Axes, curve: KeepCurve, column: str, *, colour: str = plots.BLUE) -> None:
    """Draw one score of one algorithm over gamma, from all events on the left to few."""
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
