"""Figures of an inspection: the rate over time, the times between events, the map of the pixels.

Needs matplotlib: ``asap-events[report]``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from asap import _units, analysis, plots  # first: it says which extra is missing
from asap.results.inspection import BINS_FROM_US

import matplotlib  # isort: skip
from matplotlib.colors import LogNorm  # isort: skip

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from asap.results.inspection import Inspection

_MARKED = 50  # hot pixels with a circle
_LABELS_PER_INCH = 1.5  # of the page: more would run into each other


def figure(
    inspection: Inspection, *, size_inches: tuple[float, float] = (7.5, 8.6), points: int = 2000
) -> Figure:
    """Draw rate over time, times between events, and the pixels with circles around hot ones.

    Parameters
    ----------
    inspection : Inspection
        What `asap.check` returns.
    size_inches : (float, float)
        Width and height of the page.
    points : int
        The most points of a curve; the smallest and the largest of what lies between stay.

    Returns
    -------
    matplotlib.figure.Figure
        Shown by a notebook as it is; ``.savefig(path)`` writes it.
    """
    with matplotlib.rc_context(plots.STYLE):
        page = plots.NotebookFigure(figsize=size_inches, layout="constrained")
        rate, intervals, pixels = page.subplots(3, 1, height_ratios=(1, 0.9, 2.6))
        _draw_rate(rate, inspection, points)
        _draw_intervals(intervals, inspection, max(2, int(_LABELS_PER_INCH * size_inches[0])))
        _draw_pixels(pixels, inspection)
    return page


def _draw_rate(axes: Axes, inspection: Inspection, points: int) -> None:
    time_s, mean_hz, peak_hz = inspection.rate_curve.T
    unit, scale = _units.rate_axis(peak_hz.max(initial=0))
    window_ms = 1e3 * (time_s[1] - time_s[0]) if time_s.size > 1 else 1.0
    if window_ms > 1.5:
        axes.plot(
            *analysis.decimate(time_s, peak_hz * scale, points),
            color=plots.FAINT,
            label="largest in 1 ms",
        )
    axes.plot(
        *analysis.decimate(time_s, mean_hz * scale, points),
        color=plots.BLUE,
        drawstyle="steps-post",
        label=f"in {window_ms:.0f} ms",
    )
    axes.set(title="event rate", xlabel="time from the first event [s]", ylabel=unit)
    axes.set_ylim(bottom=0)
    axes.margins(x=0.01)
    plots._legend(axes)


def _draw_intervals(axes: Axes, inspection: Inspection, most_labels: int) -> None:
    counts = inspection.interval_counts
    total = max(int(counts.sum()), 1)
    last = int(np.flatnonzero(counts)[-1]) if counts.any() else 0
    axes.bar(np.arange(last + 1), 100 / total * counts[: last + 1], color=plots.BLUE, width=0.92)
    ticks = range(0, last + 1, -(-(last + 1) // most_labels))
    axes.set_xticks(ticks, [_units.duration(int(BINS_FROM_US[tick])) for tick in ticks])
    axes.set(title="time since the event before", ylabel="% of events", xlabel="from, by octaves")
    axes.grid(False, axis="x")


def _draw_pixels(axes: Axes, inspection: Inspection) -> None:
    counts = inspection.pixel_counts
    largest = max(int(counts.max(initial=1)), 2)
    picture = axes.imshow(
        np.ma.masked_equal(counts, 0),
        norm=LogNorm(1, largest),
        cmap="cividis",
        interpolation="nearest",
        aspect="equal",
    )
    axes.grid(False)
    axes.figure.colorbar(picture, ax=axes, label="events of a pixel", shrink=0.8, pad=0.02)
    hot = inspection.hot_pixels[:_MARKED]
    if hot.size:
        axes.scatter(
            hot["x"],
            hot["y"],
            s=70,
            facecolors="none",
            edgecolors=plots.VERMILION,
            linewidths=1.3,
        )
    rows, columns = counts.shape
    axes.set(xlim=(-0.5, columns - 0.5), ylim=(rows - 0.5, -0.5), xlabel="x [px]", ylabel="y [px]")
    total = inspection.hot_pixels.size
    share = int(inspection.hot_pixels["events"].sum()) / max(inspection.events, 1)
    words = f"{_units.count(total)}, with {_units.share(share)} of the events" if total else "none"
    axes.set_title(f"hot pixels: {words}")
