"""Figures of the study: the three that a reader remembers. Needs matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from asap import plots
from asap.experiment.comparing import side_by_side
from asap.io.source import CheckedStream
from asap_laboratory.page import Rows, fixed, only
from asap_laboratory.profiles import LATENCY_MS
from asap_laboratory.schemes.cases import NAMED, Case
from asap_laboratory.schemes.contenders import contender

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_IN_HEAT_MAP = (
    "FixedSize 1000",
    "FixedTime 1 ms",
    "Greedy",
    "Asap2022",
    "Asap2020",
    "Spark PID",
    "greedy+clear",
    "jAER timer",
    "DeadBeat",
    "Deadline",
)
_OURS = ("DeadBeat", "Deadline", "whole Deadline")
_IN_SCATTER = (
    "FixedSize 1000",
    "Greedy",
    "Asap2022",
    "Asap2020",
    "Spark PID",
    "greedy+clear",
    "jAER timer",
    "DeadBeat",
    "whole Deadline",
    "Deadline",
)
_IN_STEP = {
    "Greedy": plots.FAINT,
    "Asap2020": plots.PURPLE,
    "DeadBeat": plots.GREEN,
    "Deadline": plots.BLUE,
}
_P99_LIMITS = (0.3, 700.0)  # in L
_LOST_LIMITS = (1.8, 1.2e-3)  # 1 - score
_LABEL_HEIGHT = 0.05

# Dark is good; near 1 a hundredth has to be seen.
_SCORES = LinearSegmentedColormap.from_list(
    "scores", ["#f6e5da", "#f3f4f4", "#cfe0ec", "#6aa5cc", plots.BLUE]
)


def heat_map(rows: Rows) -> Figure:
    """Draw the scores: schemes by the nine profiles, one panel per cost model."""
    with matplotlib.rc_context(plots.STYLE):
        figure = Figure(figsize=(9.6, 6.4), layout="constrained")
        panels = figure.subplots(2, 2, sharey=True)
        for axes, model in zip(panels.flat, LATENCY_MS, strict=True):
            _draw_scores(axes, only(rows, cost_model=model, profile=NAMED), model)
        figure.suptitle(
            "Events finished in time, of the most that is possible (OB)",
            x=0.005,
            ha="left",
            fontsize=11,
            fontweight="bold",
        )
    return figure


def _draw_scores(axes: Axes, rows: Rows, model: str) -> None:
    found = {(row["contender"], row["profile"]): row["score"] for row in rows}
    profiles = [name for name in NAMED if ("Deadline", name) in found]
    scores = np.array(
        [[found.get((label, name), np.nan) for name in profiles] for label in _IN_HEAT_MAP]
    ).reshape(len(_IN_HEAT_MAP), len(profiles))
    axes.imshow(_even(scores), cmap=_SCORES, vmin=0.0, vmax=1.0, aspect="auto")
    for (row, column), score in np.ndenumerate(scores):
        if np.isfinite(score):
            dark = _even(score) > 0.72
            axes.text(
                column,
                row,
                _cell(score),
                ha="center",
                va="center",
                fontsize=7,
                color="white" if dark else plots.INK,
            )
    axes.set_title(f"{model}, L = {LATENCY_MS[model]:g} ms")
    axes.set_xticks(range(len(profiles)), profiles, fontsize=7.5)
    axes.set_yticks(range(len(_IN_HEAT_MAP)), _IN_HEAT_MAP, fontsize=7.5)
    for label in axes.get_yticklabels():
        if label.get_text() in _OURS:
            label.set_fontweight("bold")
    axes.grid(False)
    axes.tick_params(length=0)
    for spine in axes.spines.values():
        spine.set_visible(False)
    edges = np.arange(-0.5, max(scores.shape), 1.0)
    axes.set_xticks(edges[: scores.shape[1] + 1], minor=True)
    axes.set_yticks(edges[: scores.shape[0] + 1], minor=True)
    axes.grid(which="minor", color="white", linewidth=1.6, alpha=1.0)
    axes.tick_params(which="minor", length=0)


def _cell(score: float) -> str:
    if score >= 0.9995:
        return "1"
    return fixed(score, 3 if score >= 0.9 else 2)


def _even(score: Any) -> Any:
    """Spread the scores near 1: a third of the scale is above 0.9."""
    return np.clip(score, 0.0, 1.0) ** 4.5


def score_and_latency(aggregates: Rows) -> Figure:
    """Draw the share of the oracle that each scheme misses against its p99, one panel per model."""
    with matplotlib.rc_context(plots.STYLE):
        figure = Figure(figsize=(4.6, 11.5), layout="constrained")
        panels = figure.subplots(4, 1, sharex=True)
        for axes, model in zip(panels, LATENCY_MS, strict=True):
            _draw_scatter(axes, only(aggregates, cost_model=model, further=False), model)
            axes.set_ylabel("mean score")
        panels[0].text(
            _P99_LIMITS[0] * 1.07, 1.5, "bound kept", color=plots.GREEN, fontsize=8, va="bottom"
        )
        panels[-1].set_xlabel("worst p99 latency of all profiles, in L")
        figure.suptitle(
            "Score and latency: up and left is better",
            x=0.005,
            ha="left",
            fontsize=11,
            fontweight="bold",
        )
    return figure


def _draw_scatter(axes: Axes, rows: Rows, model: str) -> None:
    points = [
        (row["p99_of_bound"], max(1.0 - row["mean"], 1.4e-3), row["contender"])
        for label in _IN_SCATTER
        for row in only(rows, contender=label)
    ]
    axes.axvspan(_P99_LIMITS[0], 1.0, color=plots.GREEN, alpha=0.08, linewidth=0)
    axes.axvline(1.0, color=plots.GREEN, linewidth=1.0)
    for p99, lost, label in points:
        ours = label in _OURS
        axes.plot(
            p99,
            lost,
            "o",
            color=plots.BLUE if ours else plots.FAINT,
            markersize=6 if label == "Deadline" else 4.5,
        )
    axes.set(xscale="log", yscale="log", xlim=_P99_LIMITS, ylim=_LOST_LIMITS)
    ticks = (0.0, 0.5, 0.8, 0.9, 0.95, 0.98, 0.99, 0.998)
    axes.set_yticks([1.0 - tick for tick in ticks], [f"{tick:g}" for tick in ticks])
    axes.set_yticks([], minor=True)
    axes.set_xticks([1, 10, 100], ["L", "10 L", "100 L"])
    axes.set_xticks([], minor=True)
    axes.set_title(f"{model}, L = {LATENCY_MS[model]:g} ms")
    _label(axes, points)


def _label(axes: Axes, points: list[tuple[float, float, str]]) -> None:
    """Write each label where it lies on no point and no other label, as near as that can be."""
    places = [(_share(p99, _P99_LIMITS), _share(lost, _LOST_LIMITS)) for p99, lost, _ in points]
    taken = [(x - 0.012, x + 0.012, y - 0.015, y + 0.015) for x, y in places]
    for index in sorted(range(len(points)), key=lambda i: -places[i][1]):
        (x, y), label = places[index], points[index][2]
        ours = label in _OURS
        width = (0.0195 if ours else 0.017) * len(label)
        left, right, low = _free_place(x, y, width, taken)
        taken.append((left, right, low, low + _LABEL_HEIGHT))
        middle = low + _LABEL_HEIGHT / 2
        line = {"arrowstyle": "-", "color": plots.FAINT, "linewidth": 0.6, "shrinkB": 3}
        axes.annotate(
            label,
            (x, y),
            (left, middle),
            xycoords="axes fraction",
            textcoords="axes fraction",
            fontsize=8,
            va="center",
            fontweight="bold" if ours else "normal",
            color=plots.BLUE if ours else plots.INK,
            arrowprops=line if abs(middle - y) > 0.035 else None,
        )


def _free_place(
    x: float, y: float, width: float, taken: list[tuple[float, float, float, float]]
) -> tuple[float, float, float]:
    """Left, right and lower edge of a box of that width near a point."""
    for shift in sorted(np.arange(-0.4, 0.41, 0.01), key=abs):
        low = y + shift - _LABEL_HEIGHT / 2
        for left in (x + 0.02, x - 0.02 - width):
            box = (left, left + width, low, low + _LABEL_HEIGHT)
            inside = left > 0.0 and box[1] < 1.0 and low > 0.0 and box[3] < 1.0
            if inside and not any(_overlap(box, other) for other in taken):
                return box[0], box[1], low
    return x + 0.02, x + 0.02 + width, y - _LABEL_HEIGHT / 2


def _overlap(
    one: tuple[float, float, float, float], other: tuple[float, float, float, float]
) -> bool:
    return one[0] < other[1] and other[0] < one[1] and one[2] < other[3] and other[2] < one[3]


def _share(value: float, limits: tuple[float, float]) -> float:
    """Where a value lies on a logarithmic axis, 0 to 1."""
    return float(np.log(value / limits[0]) / np.log(limits[1] / limits[0]))


def step_response() -> Figure:
    """Draw what four schemes make of a step from a load of 0.09 to 1.8, and of the step down."""
    case = Case("steps", "slow", duration_s=1.3, contenders=tuple(_IN_STEP))
    scenario = case.scenario()
    found = side_by_side(
        CheckedStream(scenario.source),
        [contender(label) for label in _IN_STEP],
        cost=scenario.cost,
        latency_ms=scenario.latency_ms,
        seed=case.seed,
        threads=1,
    )
    with matplotlib.rc_context(plots.STYLE):
        figure = Figure(figsize=(4.6, 6.6), layout="constrained")
        panels = figure.subplots(len(_IN_STEP), 2, sharex=True, sharey="col")
        for (latency, kept), (label, run) in zip(
            panels, zip(_IN_STEP, found.runs, strict=True), strict=True
        ):
            _draw_step(latency, kept, run.slots, _IN_STEP[label], scenario.latency_ms)
            latency.axhline(scenario.latency_ms, color=plots.VERMILION, linewidth=1.1)
            latency.set_title(f"{label}: latency [ms]")
            kept.set_title("kept (pale: late)")
        for axes in panels[-1]:
            axes.set_xlabel("time [s]")
        panels[0, 0].text(
            0.36, scenario.latency_ms * 1.2, "L", color=plots.VERMILION, fontsize=9, va="bottom"
        )
        figure.suptitle(
            "20 times the rate from 0.5 to 1 s: a load of 1.8",
            x=0.005,
            ha="left",
            fontsize=11,
            fontweight="bold",
        )
    return figure


def _draw_step(latency: Axes, kept: Axes, slots: Any, colour: str, bound_ms: float) -> None:
    slots = slots[(slots["slot"] >= 350) & (slots["slot"] < 1300)]
    time_s = slots["slot"] / 1e3
    for axes in (latency, kept):
        axes.axvspan(0.5, 1.0, color=plots.FAINT, alpha=0.16, linewidth=0)
        axes.set_xticks([0.5, 1.0], ["0.5", "1.0"])
    delivered = slots["delivered"] > 0
    latency_ms = np.where(delivered, slots["latency_max_us"] / 1e3, np.nan)
    latency.plot(time_s, latency_ms, color=colour, linewidth=1.2)
    latency.set(yscale="log", ylim=(0.1, 900.0))
    latency.set_yticks([0.1, 1, 10, 100], ["0.1", "1", "10", "100"])
    latency.set_yticks([], minor=True)
    bins = slots["slot"] // 5
    in_time = slots["latency_max_us"] <= 1.01e3 * bound_ms
    arrived = np.maximum(np.bincount(bins - bins[0], weights=slots["received"]), 1.0)
    for delivered, pale in ((slots["delivered"], 0.35), (slots["delivered"] * in_time, 1.0)):
        share = np.bincount(bins - bins[0], weights=delivered) / arrived
        bins_s = (np.arange(share.size) + bins[0]) * 5e-3
        kept.fill_between(bins_s, share, step="post", color=colour, alpha=pale, linewidth=0)
    kept.set(ylim=(0.0, 1.05))
    kept.set_yticks([0, 0.5, 1.0], ["0", "0.5", "1"])
