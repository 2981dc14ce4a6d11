"""The figure of the ladder: what comes through in time, and the accuracy left, over cost.

Needs matplotlib: ``asap-events[report]``.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from asap import plots  # first: it says which extra is missing
from asap_laboratory.ladder.settings import BASELINES, OURS
from asap_laboratory.page import Row, Rows, only

import matplotlib  # isort: skip
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator  # isort: skip

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_NAME_HEIGHT = 15.0  # pixels of a page that is not printed yet

_COLOURS = {
    OURS: plots.BLUE,
    "FixedSize": plots.VERMILION,
    "FixedTime": plots.GREEN,
    "Asap2020": plots.PURPLE,
}
_SHOWN = {  # label: words
    **{f"{name}, one for all": f"{name}, one setting" for name in BASELINES},
    **{name: f"{name}, tuned to each" for name in BASELINES},
    OURS: f"{OURS}, told L",
}


def figure(rows: Rows, *, width_inches: float = 4.6) -> Figure:
    """Draw three panels over the cost per event, a line for each scheme.

    `rows`: each consumer under each scheme in virtual time, the cheapest first. In time, of what
    the computer can do; MOTA and F at the moment of use, of that with all events and without
    latency, 0 where it is below. Bars are standard deviations over the seeds.
    """
    with matplotlib.rc_context({**plots.STYLE, "axes.titley": 1.0}):
        page = plots.NotebookFigure(layout="constrained", figsize=(width_inches, 10.0))
        panels = page.subplots(3, 1, height_ratios=(1.1, 1, 1))
        whole, trackers, corners = panels
        _lines(whole, rows, _of_possible)
        whole.set_title("finished within L, of what is possible")
        for axes, kind, words in (
            (trackers, "tracker", "trackers: MOTA left in use"),
            (corners, "corners", "corner detectors: F left in use"),
        ):
            if some := only(rows, score=kind):
                _lines(axes, some, _left_in_use)
                _name_rungs(axes, some)
            axes.set_title(words)
        _name_rungs(whole, rows)
        for axes in panels:
            _dress(axes)
            axes.set_ylim(-1.35, 1.08)
            axes.set_yticks(np.linspace(0, 1, 6))
        handles, labels = whole.get_legend_handles_labels()
        order = [len(labels) - 1, *range(len(labels) - 1)]
        page.legend(
            [handles[i] for i in order],
            [labels[i] for i in order],
            loc="outside lower center",
            ncols=2,
        )
    return page


def _of_possible(row: Row) -> tuple[float, float | None]:
    return row["of_possible"], row["of_possible_sd"]


def _left_in_use(row: Row) -> tuple[float, float | None]:
    if row["in_use"] <= 0:
        return 0.0, None
    sd = row["in_use_sd"]
    return row["in_use"] / row["alone"], None if sd is None else sd / row["alone"]


def _lines(axes: Axes, rows: Rows, value: Callable[[Row], tuple[float, float | None]]) -> None:
    for label, words in _SHOWN.items():
        name = label.partition(",")[0]
        style: dict[str, Any] = {"color": _COLOURS[name], "linewidth": 1.0, "markersize": 2.5}
        if label == OURS:
            style |= {"linewidth": 2.2, "markersize": 4.5}
        elif label != name:
            style |= {"linestyle": (0, (3, 2))}
        some = only(rows, scheme=label)
        means, spreads = zip(*(value(row) for row in some), strict=True)
        axes.errorbar(
            [row["beta_ns"] for row in some],
            means,
            [spread or 0.0 for spread in spreads],
            marker="o",
            elinewidth=0.8,
            label=words,
            **style,
        )


def _name_rungs(axes: Axes, rows: Rows) -> None:
    """Write the consumers under the curves, with a line to the cost where they are crowded."""
    by_rung = {row["rung"]: row["beta_ns"] for row in rows}
    costs = np.log10(list(by_rung.values()))
    margin = 0.09 * (costs[-1] - costs[0]) + 0.05
    axes.set_xlim(10 ** (costs[0] - margin), 10 ** (costs[-1] + margin))
    least = _NAME_HEIGHT / axes.bbox.width * (costs[-1] - costs[0] + 2 * margin)
    for rung, cost, place in zip(
        by_rung, costs, _apart(costs, least, costs[0] - margin / 2), strict=True
    ):
        axes.plot([10**cost, 10**place], [-0.02, -0.06], color=plots.FAINT, linewidth=0.6, zorder=0)
        axes.text(10**place, -0.07, rung, rotation=90, ha="center", va="top", fontsize=8)


def _apart(places: NDArray[np.float64], least: float, low: float) -> NDArray[np.float64]:
    """Move places in ascending order until neighbours are so far apart, and none below `low`."""
    places = places.copy()
    for _ in range(500):
        short = np.maximum(least - np.diff(places), 0) / 2
        if not short.max(initial=0) > 1e-6:
            break
        places[:-1] -= short
        places[1:] += short
        places = np.maximum(places, low)
    return places


def _dress(axes: Axes) -> None:
    axes.set_xscale("log")
    low, high = np.log10(axes.get_xlim())
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high - low < 1.5 else (1.0,)))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(
        FuncFormatter(lambda ns, _: f"{ns:g} ns" if ns < 1000 else f"{ns / 1e3:g} us")
    )
    axes.set_xlabel("cost per event")
