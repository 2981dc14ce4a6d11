"""The page about a comparison."""

from __future__ import annotations

import os
from collections.abc import Iterator
from functools import partial
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from asap import _checks, _units, plots  # first: it says which extra is missing
from asap.report import page
from asap.results import comparison_table, notebook, run_table

import matplotlib  # isort: skip
from matplotlib.ticker import LogLocator, NullLocator  # isort: skip


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from asap.results.comparison import Comparison, Row

_STYLE = """
.contest th,.contest td{padding-right:9px}
.contest tr>:last-child{padding-right:0}
.contest td,.contest th+th{text-align:right;white-space:nowrap}
.contest tbody th{white-space:normal;overflow-wrap:anywhere;min-width:7.5em}
.contest td.score{min-width:5em}
.contest td.score i{display:block;height:5px;border-radius:3px;background:var(--line);
margin-top:5px;overflow:hidden}
.contest td.score u{display:block;height:100%;background:var(--green)}
.contest .late{color:var(--vermilion);font-weight:600}
.contest .oracle>*{border-top:2px solid var(--line);color:var(--soft)}
.contest .oracle+.oracle>*{border-top:0}
"""

# On a narrow screen a scheme is a block: its name and score, below them the rest, each with its
# column's name.
_NARROW = """
@media (max-width:640px){
.contest{display:block}
.contest tbody{display:block}
.contest thead{display:none}
.contest tr{display:grid;grid-template-columns:repeat(5,1fr);gap:6px 8px;padding:10px 0;
border-bottom:1px solid var(--line)}
.contest tr>*{border:0!important;padding:0}
.contest tbody th{grid-column:1/4;min-width:0}
.contest td.score,.contest .oracle td:nth-child(2){grid-column:4/6}
.contest td{font-size:.8rem;line-height:1.3}
.contest td:empty{display:none}
.contest td::before{display:block;color:var(--soft);font-weight:400;font-size:.7rem}
%s}
"""

_CURVES = "Curves of every scheme: latency and kept share over time"
_CAPTION = (
    "Every scheme over time: the largest latency of the events of each moment, and the share of "
    "the events that was finished. Latencies beyond 100 L are drawn at 100 L."
)


def write(
    comparison: Comparison, path: str | os.PathLike[str], title: str = "ASAP comparison"
) -> Path:
    """Write one HTML file about a comparison, of at most 10^6 bytes.

    The numbers stand in ``<template data-comparison>`` as JSON: what ``comparison.summary()`` says.
    """
    path = _checks.page_file("path", path)
    return page.write(
        path,
        title,
        _article(comparison),
        style=_STYLE + _NARROW % "".join(_names()),
        intro=page.INTRO_OF_RUNS,
        words=page.WORDS_OF_RUNS,
    )


def _article(comparison: Comparison) -> str:
    headline, dot, rest = comparison_table.verdict(comparison).partition(". ")
    few = 9 / max(len(comparison.rows), 9)
    draw, most = partial(figure, comparison), page.MOST_BYTES
    narrow_by: Any = {"width_inches": page.NARROW_INCHES, "columns": 1}
    wide = page.fitted(draw, int(500 * few), 0.56 * most, "w", "wide", _CURVES, width_inches=8.6)
    narrow = page.fitted(draw, int(300 * few), 0.34 * most, "n", "narrow", _CURVES, **narrow_by)
    return f"""
<article>
<h2>{escape(comparison_table.title(comparison))}</h2>
<p class="sub">{page.text(comparison_table.subtitle(comparison))}</p>
<div class="scroll">{_table(comparison)}</div>
{page.verdict(headline + dot, rest)}
{page.curves(wide, narrow, _CAPTION)}
<details><summary>What the columns say</summary>
{page.definitions(comparison_table.COLUMNS.items())}</details>
<details><summary>The schemes and their parameters</summary>
<div class="scroll">{notebook.table((), _parameters(comparison), "plain")}</div></details>
{page.embedded("data-comparison", comparison.summary())}
</article>"""


def _table(comparison: Comparison) -> str:
    head = "".join(f'<th scope="col">{escape(name)}</th>' for name in comparison_table.COLUMNS)
    rows = [_row(row, comparison.latency_ms) for row in comparison.rows]
    for name, *cells in comparison_table.oracle_rows(comparison):
        oracle = "".join(f"<td>{escape(cell)}</td>" for cell in cells)
        rows.append(f'<tr class="oracle"><th scope="row">{escape(name)}</th>{oracle}</tr>')
    return (
        f'<table class="contest"><thead><tr>{head}</tr></thead>'
        f"<tbody>{''.join(rows)}</tbody></table>"
    )


def _names() -> Iterator[str]:
    for number, name in enumerate(comparison_table.COLUMNS, start=1):
        if number > 1:  # the scheme's own name needs none
            yield f'.contest td:nth-child({number})::before{{content:"{name}"}}\n'


def _row(row: Row, latency_ms: float) -> str:
    texts = dict(
        zip(comparison_table.COLUMNS, comparison_table.cells(row, latency_ms), strict=True)
    )
    name = texts.pop("scheme")
    percent = 100 * min(row.score, 1.0)
    bar = f'<i aria-hidden="true"><u style="width:{percent:.1f}%"></u></i>'
    late = {"p99/L": row.p99_us, "max": row.max_us}
    cells = [
        f'<td class="score">{escape(text)}{bar}</td>'
        if column == "score"
        else f'<td class="late">{escape(text)}</td>'
        if comparison_table.exceeds(late.get(column, 0.0), latency_ms)
        else f"<td>{escape(text)}</td>"
        for column, text in texts.items()
    ]
    return f'<tr><th scope="row">{escape(name)}</th>{"".join(cells)}</tr>'


def _parameters(comparison: Comparison) -> Iterator[tuple[str, str, str]]:
    for row in comparison.rows:
        parameters = comparison.runs[row.label].scheme.parameters
        words = ", ".join(
            f"{name} {run_table.parameter_value(value)}" for name, value in parameters.items()
        )
        yield row.label, row.scheme, words or "none"


_PANEL_INCHES = 0.92
_FRAME_INCHES = 0.95
_SPAN = 100  # latencies from L / 100 to 100 L are told apart


def figure(
    comparison: Comparison, *, width_inches: float = 9.0, columns: int = 2, points: int = 500
) -> Figure:
    """Draw latency and kept share over time for each scheme, best score first.

    The first row shows the events that came in. For each scheme the largest latency of the events
    of each moment with the latency bound, and beside it (in one column, for narrow screens: below
    it) the share of the events that was finished. A curve has at most so many points, each with the
    worst latency and the mean share of what lies between.
    """
    rows = comparison.rows
    lines = 1 + len(rows) * 2 // columns
    # Fixed titles: to look for a place for each takes longer than to draw the page.
    with matplotlib.rc_context({**plots.STYLE, "axes.titley": 1.0}):
        page = plots.NotebookFigure(
            figsize=(width_inches, _FRAME_INCHES + _PANEL_INCHES * lines), layout="constrained"
        )
        grid = page.subplots(lines, columns, sharex=True, squeeze=False)
        panels = iter(grid[1:].flat)
        curves = {row.label: _Curves.of(comparison, row.label, points) for row in rows}
        for axes in grid[0]:
            _draw_rate(axes, next(iter(curves.values())))
        for row in rows:
            latency, kept = next(panels), next(panels)
            _draw_latency(latency, curves[row.label], comparison.latency_ms)
            _draw_kept(kept, curves[row.label])
            _name(latency, kept, row, is_narrow=columns == 1)
        _draw_legend(page, *grid[1:].flat[:2], columns=columns + 1)
        for axes in grid[-1]:
            axes.set_xlabel("time from the first event [s]")
        for axes in grid.flat:
            axes.margins(x=0.01)
    return page


class _Curves(NamedTuple):
    """A run over time, in windows of equal length."""

    time_s: NDArray[np.float64]
    rate_hz: NDArray[np.float64]
    latency_ms: NDArray[np.float64]  # the largest, NaN where nothing was finished
    kept: NDArray[np.float64]  # NaN where nothing came in
    on_time: NDArray[np.bool_]

    @classmethod
    def of(cls, comparison: Comparison, label: str, points: int) -> _Curves:
        slots = comparison.runs[label].slots
        if slots is None or slots.size == 0:
            empty = np.empty(0)
            return cls(empty, empty, empty, empty, np.empty(0, bool))
        elapsed_ms = slots["slot"] - slots["slot"][0]
        window_ms = -(-int(elapsed_ms[-1] + 1) // points)
        window = elapsed_ms // window_ms
        count = int(window[-1]) + 1
        received = np.bincount(window, slots["received"], count)
        delivered = np.bincount(window, slots["delivered"], count)
        latency_ms = np.full(count, np.nan)
        np.fmax.at(latency_ms, window[slots["delivered"] > 0], _delivered_ms(slots))
        return cls(
            time_s=(np.arange(count, dtype=np.float64) + 0.5) * (window_ms / 1e3),
            rate_hz=np.asarray(received * (1e3 / window_ms), np.float64),
            latency_ms=latency_ms,
            kept=np.divide(delivered, received, out=np.full(count, np.nan), where=received > 0),
            on_time=latency_ms <= comparison_table.KEEPS * comparison.latency_ms,
        )


def _delivered_ms(slots: NDArray[np.void]) -> NDArray[np.float64]:
    return np.asarray(slots["latency_max_us"][slots["delivered"] > 0] / 1e3)


def _draw_rate(axes: Axes, curves: _Curves) -> None:
    unit, scale = _units.rate_axis(curves.rate_hz.max(initial=0))
    axes.fill_between(
        curves.time_s, curves.rate_hz * scale, color=plots.FAINT, alpha=0.55, linewidth=0
    )
    axes.set(title="events that come in", ylabel=unit)
    axes.set_ylim(bottom=0)


def _draw_latency(axes: Axes, curves: _Curves, bound_ms: float) -> None:
    low, high = bound_ms / _SPAN, bound_ms * _SPAN
    axes.plot(curves.time_s, np.clip(curves.latency_ms, low, high), color=plots.BLUE)
    axes.axhline(
        bound_ms, color=plots.VERMILION, linestyle=(0, (5, 3)), linewidth=1.2, label="bound L"
    )
    axes.set(ylabel="latency\n[ms]", yscale="log", ylim=(low / 1.4, high * 1.4))
    axes.yaxis.set_major_locator(LogLocator(numticks=4))
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:,g}")
    axes.yaxis.set_minor_locator(NullLocator())


def _draw_kept(axes: Axes, curves: _Curves) -> None:
    kept = np.nan_to_num(curves.kept)
    for chosen, colour, label in (
        (curves.on_time, plots.GREEN, "kept, all in time"),
        (~curves.on_time, plots.VERMILION, "kept, some too late"),
    ):
        axes.fill_between(
            curves.time_s,
            np.where(chosen, kept, 0.0),
            color=colour,
            alpha=0.75,
            linewidth=0,
            step="mid",
            label=label,
        )
    axes.set(ylabel="kept", ylim=(0, 1.05), yticks=(0, 0.5, 1))


def _name(latency: Axes, kept: Axes, row: Row, *, is_narrow: bool) -> None:
    plain: Any = {"loc": "right", "fontweight": "normal", "fontsize": 8}
    latency.set_title(row.label, parse_math=False)
    longest = "" if is_narrow else f", max {_units.duration(row.max_us)}"
    latency.set_title(f"p99 {_units.duration(row.p99_us)}{longest}", **plain)
    kept.set_title(f"score {row.score:.3f}")
    kept.set_title(f"kept {_units.share(row.kept)}", **plain)


def _draw_legend(page: Figure, *panels: Axes, columns: int) -> None:
    handles = [handle for axes in panels for handle in axes.get_legend_handles_labels()[0]]
    page.legend(handles=handles, loc="outside upper right", ncols=columns, handlelength=1.6)
