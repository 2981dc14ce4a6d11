"""Figures of a comparison: what every scheme did over time, one row for each on one time axis.

Needs matplotlib: ``asap-events[report]``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from asap import _units, plots  # first: it says which extra is missing
from asap.results import comparison_table

import matplotlib  # isort: skip
from matplotlib.ticker import LogLocator, NullLocator  # isort: skip

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from asap.results.comparison import Comparison, Row

_PANEL_INCHES = 0.92
_FRAME_INCHES = 0.95
_SPAN = 100  # latencies from L / 100 to 100 L are told apart


def figure(
    comparison: Comparison, *, width_inches: float = 9.0, columns: int = 2, points: int = 500
) -> Figure:
    """Draw latency and kept share over time for each scheme, best score first.

    The first row shows the events that came in. For each scheme the largest latency of the events
    of each moment with the latency bound, and beside it (in one column: below it) the share of the
    events that was finished.

    Parameters
    ----------
    comparison : Comparison
        What `asap.compare` returns.
    width_inches : float
        Of the page; its height follows from the number of schemes.
    columns : {1, 2}
        1: for narrow screens.
    points : int
        The most moments of a curve; each shows the worst latency and the mean share in it.

    Returns
    -------
    matplotlib.figure.Figure
        Shown by a notebook as it is; ``.savefig(path)`` writes it.
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
            _name(latency, kept, row)
        _draw_legend(page, *grid[1:].flat[:2])
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


def _name(latency: Axes, kept: Axes, row: Row) -> None:
    plain: Any = {"loc": "right", "fontweight": "normal", "fontsize": 8}
    latency.set_title(row.label, parse_math=False)
    latency.set_title(
        f"p99 {_units.duration(row.p99_us)}, max {_units.duration(row.max_us)}", **plain
    )
    kept.set_title(f"score {row.score:.3f}")
    kept.set_title(f"kept {_units.share(row.kept)}", **plain)


def _draw_legend(page: Figure, *panels: Axes) -> None:
    handles = [handle for axes in panels for handle in axes.get_legend_handles_labels()[0]]
    page.legend(handles=handles, loc="outside upper right", ncols=3, handlelength=1.6)
