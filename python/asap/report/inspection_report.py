"""The page about an inspection."""

from __future__ import annotations

import os
from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from asap import _checks, _units, analysis, plots  # first: it says which extra is missing
from asap.report import page
from asap.results import inspection_table, notebook
from asap.results.inspection import BINS_FROM_US

import matplotlib  # isort: skip
from matplotlib.colors import LogNorm  # isort: skip


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from asap.results.inspection import Inspection

_STYLE = """
.checks td:nth-child(2){text-align:right;white-space:nowrap}
.checks td:last-child{color:var(--soft);width:60%;overflow-wrap:anywhere}
.checks .wrong td:nth-child(3){color:var(--vermilion);font-weight:600}
.checks .note td:nth-child(3){color:var(--blue);font-weight:600}
.checks .ok td:nth-child(3){color:var(--green)}
"""

_CURVES = (
    "Event rate over time, a histogram of the times between events, and a map of how many events "
    "every pixel had"
)
_CAPTION = (
    "The good events: how many in each moment, how long after the one before, and how many of each "
    "pixel."
)


def write(
    inspection: Inspection, path: str | os.PathLike[str], title: str = "ASAP inspection"
) -> Path:
    """Write one HTML file about an inspection.

    The numbers stand in ``<template data-inspection>`` as JSON: ``inspection.summary()``.
    """
    path = _checks.page_file("path", path)
    return page.write(path, title, _article(inspection), style=_STYLE)


def _article(inspection: Inspection) -> str:
    facts = inspection_table.facts(inspection)
    _, _, sentences = inspection_table.verdict(inspection).partition(": ")
    sentences = sentences[:1].upper() + sentences[1:]
    wide = figure(inspection, size_inches=(8.6, 10.0))
    narrow = figure(inspection, size_inches=(page.NARROW_INCHES, 6.6), points=700)
    return f"""
<article>
<h2>{escape(inspection_table.title(inspection))}</h2>
{notebook.table((), facts.items(), "plain")}
{page.verdict(sentences, more=page.definitions(inspection_table.remedies(inspection).items()))}
<div class="scroll"><table class="checks">{"".join(_rows(inspection))}</table></div>
{page.curves(*page.drawn(wide, narrow, _CURVES), _CAPTION)}
<details><summary>The ten busiest pixels</summary>
<div class="scroll">{notebook.table((), _pixels(inspection), "plain")}</div></details>
<details><summary>What is checked</summary>{page.definitions(_words())}</details>
{page.embedded("data-inspection", inspection.summary())}
</article>"""


def _rows(inspection: Inspection) -> Iterator[str]:
    for finding in inspection.findings.values():
        yield (
            f'<tr class="{finding.verdict}">'
            f'<th scope="row">{escape(inspection_table.named(finding))}</th>'
            f"<td>{_units.count(finding.count)}</td><td>{finding.verdict}</td>"
            f"<td>{page.text(inspection_table.detail(finding))}</td></tr>"
        )


def _pixels(inspection: Inspection) -> Iterator[tuple[str, ...]]:
    hot = {(x, y) for x, y, _ in inspection.hot_pixels.tolist()}
    for x, y, events in inspection.busiest_pixels.tolist():
        share = _units.share(events / inspection.events)
        is_hot = "hot" if (x, y) in hot else ""
        yield f"x = {x}, y = {y}", _units.count(events), share, is_hot


def _words() -> Iterator[tuple[str, str]]:
    for name, words in inspection_table.CHECKS.items():
        yield name.replace("_", " "), words


_MARKED = 50  # hot pixels with a circle
_LABELS_PER_INCH = 1.5  # of the page: more would run into each other


def figure(
    inspection: Inspection, *, size_inches: tuple[float, float] = (7.5, 8.6), points: int = 2000
) -> Figure:
    """Draw rate over time, times between events, and the pixels with circles around hot ones.

    A curve has at most so many points; the smallest and the largest of what lies between stay.
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
    words = "events of a pixel"
    beside = axes.inset_axes((1.03, 0, 0.035, 1))  # as high as the map
    bar = axes.figure.colorbar(picture, cax=beside, label=words, format="%g")
    bar.ax.yaxis.set_minor_formatter(lambda value, _: "")
    if largest < 10:  # no other power of ten
        bar.set_ticks([1, largest])
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
