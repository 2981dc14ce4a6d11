"""The figure of README: what each scheme does with one stream that grows, then bursts.

Needs matplotlib: ``asap-events[report]``. It is narrow, since half of its readers hold a phone.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.layout_engine import ConstrainedLayoutEngine

from asap import _core, plots
from asap.experiment import compare
from asap.results.cost import Floats
from asap_laboratory import profiles

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from asap.experiment import Comparison, Run

LATENCY_MS = 10.0
ALPHA_US, BETA_NS = 100.0, 150.0
_BIN_MS = 10
_LABELS = {
    "Deadline": ("Deadline, the default", plots.BLUE),
    "Asap2020": ("scheme of the paper", plots.PURPLE),
    "FixedTime": ("fixed time, 1 ms", plots.AMBER),
    "Greedy": ("greedy: all that waits", plots.GREEN),
    "FixedSize": ("fixed size, 1000", plots.VERMILION),
}


def stream() -> profiles.Profile:
    """Return 2 s of events: the rate grows from 0.1 to 6 Mev/s, then bursts of 12 Mev/s come."""

    def rate(t: Any) -> Any:
        bursts = np.where((t - 1.0) % 0.25 < 0.125, 2e6, 12e6)
        return np.where(t < 1.0, 0.1e6 * 60.0**t, bursts)

    return profiles.Profile(rate, duration_s=2.0, name="grows and bursts")


def simulated() -> Comparison:
    """Compare the schemes of the figure, each with its default parameters, on `stream`."""
    cost = _core.LinearCost(alpha_us=ALPHA_US, beta_ns=BETA_NS)
    schemes = {label: getattr(_core, label)() for label in _LABELS}
    return compare(stream(), cost=cost, schemes=schemes, latency_ms=LATENCY_MS)


def draw(comparison: Comparison) -> plots.NotebookFigure:
    """Draw event rate and latency over time, and the events in time, of `simulated`."""
    with matplotlib.rc_context({**plots.STYLE, "font.size": 10, "axes.titlesize": 10}):
        room = ConstrainedLayoutEngine(w_pad=0.12, h_pad=0.1)
        figure = plots.NotebookFigure(figsize=(4.4, 5.7), layout=room)
        parts: Any = figure.subfigures(2, 1, height_ratios=(2.4, 1.0))
        over_time, shares = parts
        rate, latency = over_time.subplots(2, 1, height_ratios=(1.0, 2.2), sharex=True)
        _draw_rate(comparison, rate)
        _draw_latency(comparison, latency)
        shares.suptitle(
            f"events processed within {LATENCY_MS:g} ms", x=0.03, ha="left", weight="bold", size=10
        )
        _draw_in_time(comparison, shares.subplots())
    return figure


def _draw_rate(comparison: Comparison, axes: Axes) -> None:
    time_s, received = _in_bins(comparison.runs["Deadline"], "received", np.add)
    axes.fill_between(
        time_s, received / _BIN_MS / 1e3, color=plots.FAINT, step="post", alpha=0.5, linewidth=0
    )
    axes.axhline(1e3 / BETA_NS, color=plots.INK, linewidth=0.9)
    axes.text(0.02, 1e3 / BETA_NS, "most that the algorithm can do", va="bottom", fontsize=9)
    axes.set(title="event rate, Mev/s", ylim=(0, 16))


def _draw_latency(comparison: Comparison, axes: Axes) -> None:
    for label, (_, colour) in reversed(_LABELS.items()):
        time_s, latest_us = _in_bins(comparison.runs[label], "latency_max_us", np.maximum)
        latest_us[latest_us == 0] = np.nan  # nothing was processed
        width = 2.2 if label == "Deadline" else 1.3
        axes.plot(time_s, latest_us / 1e3, color=colour, linewidth=width)
    axes.axhline(LATENCY_MS, color=plots.INK, linestyle=(0, (5, 3)), linewidth=0.9)
    axes.text(0.02, 1.12 * LATENCY_MS, f"bound, {LATENCY_MS:g} ms", va="bottom", fontsize=9)
    axes.set(title="largest latency, ms", yscale="log", xlim=(0, 2.0), xlabel="time, s")
    axes.set_xticks((0, 0.5, 1.0, 1.5, 2.0))
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.yaxis.set_minor_formatter(lambda value, _: "")


def _draw_in_time(comparison: Comparison, axes: Axes) -> None:
    possible = comparison.oracle / comparison.received
    last = len(_LABELS) - 0.5
    axes.plot([possible] * 2, [-0.6, last], color=plots.INK, linewidth=0.9)
    axes.text(possible + 0.015, last, f"possible: {possible:.0%}", fontsize=9)
    for place, (label, (words, colour)) in enumerate(_LABELS.items()):
        share = comparison.runs[label].in_time
        axes.barh(place, share, color=colour, height=0.6)
        axes.text(-0.02, place, words, va="center", ha="right", fontsize=9)
        apart = max(share, possible) if possible - share < 0.1 else share
        axes.text(apart + 0.015, place, f"{share:.0%}", va="center", fontsize=9)
    axes.set(xlim=(0, 1), ylim=(last, -0.6))
    axes.set_axis_off()


def _in_bins(run: Run, column: str, reduce: np.ufunc) -> tuple[Floats, Floats]:
    """Reduce a column of the slots of 1 ms to bins of 10 ms: times in s, values."""
    slots = run.slots
    assert slots is not None, "a run in virtual time has slots"
    bins, begins = np.unique((slots["slot"] - slots["slot"][0]) // _BIN_MS, return_index=True)
    return bins * (_BIN_MS / 1e3), reduce.reduceat(slots[column].astype(np.float64), begins)


def write(folder: Path) -> Path:
    """Write the figure, and return its path."""
    path = folder / "schemes.svg"
    path.write_text(plots.svg(draw(simulated())), encoding="utf-8")
    return path
