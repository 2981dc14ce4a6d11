"""Figures of runs and events.

Pixels with y down, time in s from the first event, ON red, OFF blue. Every function draws into the
axes (or figure) that it is given, makes its own otherwise, and returns them; pyplot and the global
style stay untouched. Needs matplotlib: ``asap-events[report]``.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from asap import _checks, _core, _units, analysis
from asap.events import events_of_argument
from asap.results import diagnosis
from asap.results.comparison import Comparison, Row
from asap.results.cost import BOUND_KEPT, Floats
from asap.results.run import Run

try:
    import matplotlib
    from matplotlib.figure import Figure, SubFigure
    from matplotlib.patches import Ellipse, Patch, Rectangle
    from matplotlib.ticker import LogLocator, NullLocator
except ImportError as error:
    raise ImportError("a figure needs matplotlib: install asap-events[report]") from error

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["AMBER", "BLUE", "FAINT", "GREEN", "INK", "PURPLE", "STYLE", "VERMILION"]
__all__ += ["NotebookFigure", "clusters", "control", "figure", "frame", "rate", "svg", "tracks"]

# Okabe and Ito's colours: told apart by every kind of colour vision.
BLUE, VERMILION, GREEN, PURPLE = "#0072b2", "#d55e00", "#009e73", "#a14f7c"
AMBER = "#c98a00"
INK, FAINT = "#33383d", "#9aa1a8"


def _where_dark() -> str:
    """Rules of a style sheet: ink light, the background dark, two colours lighter."""
    lighter = {INK: "#dfe3e7", BLUE: "#4fa8e0", PURPLE: "#c98bb0"}
    rules = ['path[style*="fill: #ffffff"]{fill:#16181b!important}'] + [
        f'[style*="{way}: {light}"]{{{way}:{dark}!important}}'
        for light, dark in lighter.items()
        for way in ("fill", "stroke")
    ]
    return "@media(prefers-color-scheme:dark){" + "".join(rules) + "}"


_WHERE_DARK = _where_dark()
_ON, _OFF = (214, 39, 40), (31, 90, 180)

STYLE: Any = {
    "font.size": 9,
    "axes.edgecolor": FAINT,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.titlesize": 9,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": True,
    "axes.facecolor": "none",
    "grid.color": FAINT,
    "grid.alpha": 0.3,
    "grid.linewidth": 0.6,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
    "legend.fontsize": 9,
    "legend.frameon": False,
    "lines.linewidth": 1.1,
    "figure.facecolor": "white",
}


class NotebookFigure(Figure):
    """A figure that a notebook shows without pyplot."""

    def _repr_png_(self) -> bytes:
        png = io.BytesIO()
        self.savefig(png, format="png", dpi=110)
        return png.getvalue()


def figure(
    run: Run, *, size_inches: tuple[float, float] = (5.0, 9.8), points: int = 2000
) -> Figure:
    """Draw the paper's figure of a run on a page of its own; see `control`.

    Parameters
    ----------
    run : Run
        A finished run.
    size_inches : (float, float)
        Width and height of the page.
    points : int
        The most points of one curve.

    Returns
    -------
    matplotlib.figure.Figure
        Shown by a notebook as it is; ``.savefig(path)`` writes it.
    """
    with matplotlib.rc_context(STYLE):
        page = NotebookFigure(figsize=size_inches, layout="constrained")
    control(run, figure=page, points=points)
    return page


def control(
    run: Run, *, figure: Figure | SubFigure | None = None, points: int = 2000
) -> Figure | SubFigure:
    """Draw what the closed loop did, over time: the figures of the 2020 paper, and the latency.

    Six rows share the time axis: package size; event rate, thinned rate R and the rate bound a in
    windows of time; where the events of each window went; gamma; margin (processing time - span,
    below zero is real time); largest latency of each package with the latency bound.

    Parameters
    ----------
    run : Run
        A finished run.
    figure : Figure or SubFigure, optional
        An empty one to draw into.
    points : int
        The most points of one curve; the smallest and the largest of what lies between stay.

    Notes
    -----
    The curves of Tapia, Gomez Eguiluz, Martinez-de Dios, Ollero: ASAP: Adaptive Scheme for
    Asynchronous Processing of Event-based Vision Algorithms, ICRA 2020 workshop; latency is ours.
    """
    with matplotlib.rc_context(STYLE):
        figure = figure or NotebookFigure(figsize=(5.0, 9.8), layout="constrained")
        rows = figure.subplots(len(_ROWS), 1, sharex=True)
        curves = _Curves(run, points)
        for axes, draw in zip(rows, _ROWS, strict=True):
            draw(curves, axes)
            axes.margins(x=0.01)
        rows[-1].set_xlabel("time from the first event [s]")
        figure.align_ylabels()
    return figure


def svg(figure: Figure) -> str:
    """Write a figure as SVG text: letters as letters, and the same bytes every time.

    On a system whose colours are dark it shows itself dark.

    Parameters
    ----------
    figure : Figure
        Any figure of this module.
    """
    text = io.StringIO()
    with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": "asap"}):
        figure.savefig(text, format="svg", metadata={"Date": None})
    return text.getvalue().replace("</style>", f"{_WHERE_DARK}</style>", 1)


class _Curves:
    """The columns of a run as curves of few points."""

    def __init__(self, run: Run, points: int) -> None:
        self.run = run
        self._points = points
        self._time_s = diagnosis.time_s(run)
        self.windows = diagnosis.windows(run)

    def values(self, column: str, scale: float = 1.0) -> Floats:
        return np.asarray(self.run.packages[column] * scale, np.float64)

    def draw(self, axes: Axes, values: Floats, **style: Any) -> None:
        time_s, thinned = analysis.decimate(self._time_s, values, self._points)
        axes.plot(time_s, thinned, **style)


def _draw_size(curves: _Curves, axes: Axes) -> None:
    size = curves.values("size")
    curves.draw(axes, size, color=BLUE)
    _log_if_decades(axes, size)
    axes.set(title="package size", ylabel="events")


def _draw_rates(curves: _Curves, axes: Axes) -> None:
    run, found = curves.run, curves.windows
    event_rate = found.rate_hz(found.received, run.speed)
    thinned = found.rate_hz(found.delivered, run.speed)
    top_hz = 1.15 * max(event_rate.max(initial=0), 1.0)
    unit, scale = _units.rate_axis(top_hz)
    edges_s = found.edges_s
    axes.stairs(event_rate * scale, edges_s, fill=True, color=FAINT, alpha=0.55, label="event rate")
    axes.stairs(thinned * scale, edges_s, color=GREEN, linewidth=1.1, label="thinned, R")
    rate_bound = run.scheme.parameters.get("rate_bound")
    if rate_bound:
        hidden = "" if rate_bound <= top_hz else f" = {_units.rate(rate_bound)}, off scale"
        _line(axes, rate_bound * scale, f"bound, a{hidden}")
    width = _units.duration(1e6 * float(np.diff(found.edges_s[:2]).sum()))
    axes.set(title=f"rates per {width}", ylabel=unit, ylim=(0, top_hz * scale))
    _legend(axes)


_WENT = {
    "delivered": (GREEN, "processed"),
    "filtered": (FAINT, "filtered"),
    "discarded": (PURPLE, "thinned"),
    "stale": (VERMILION, "stale"),
    "overflow": (INK, "overflow"),
}


def _draw_kept_and_lost(curves: _Curves, axes: Axes) -> None:
    found = curves.windows
    below = np.zeros(found.received.size)
    for name, (colour, label) in _WENT.items():
        part = getattr(found, name)
        if part.any():
            share = np.divide(part, found.received, out=np.zeros(part.size), where=part > 0)
            top = below + share
            axes.stairs(top, found.edges_s, baseline=below, fill=True, color=colour, label=label)
            below = top
    axes.set(title="events", ylabel="share", ylim=(0, 1.05), yticks=(0, 0.5, 1))
    _legend(axes)


def _draw_gamma(curves: _Curves, axes: Axes) -> None:
    curves.draw(axes, curves.values("gamma"), color=PURPLE)
    axes.set(title="gamma", ylabel="kept", ylim=(-0.03, 1.06))


def _draw_margin(curves: _Curves, axes: Axes) -> None:
    margin_ms = curves.values("margin_us", 1e-3)
    bottom, top, off_scale = _limits(margin_ms)
    hidden = f"; {off_scale} off scale" if off_scale else ""
    curves.draw(axes, margin_ms, color=BLUE, label=f"below 0: real time{hidden}")
    axes.axhline(0, color=INK, linewidth=0.8)
    axes.set(title="margin", ylabel="ms", ylim=(bottom, top))
    _legend(axes)


def _limits(values: Floats) -> tuple[float, float, int]:
    """Limits that hold zero and nearly all values, and the number of those outside.

    One package at the start, large for want of a measurement, would flatten all others.
    """
    if values.size == 0:
        return -1.0, 1.0, 0
    low, high = (float(q) for q in np.quantile(values, (0.005, 0.995)))
    low, high = min(low, 0.0), max(high, 0.0)
    room = 0.25 * (high - low) or 1.0
    bottom, top = low - room, high + room
    return bottom, top, int(np.count_nonzero((values < bottom) | (values > top)))


def _draw_latency(curves: _Curves, axes: Axes) -> None:
    latency_ms = curves.values("latency_max_us", 1e-3)
    curves.draw(axes, latency_ms, color=BLUE, label="oldest event of a package")
    _line(axes, curves.run.latency_bound_us / 1e3, "bound")
    _log_if_decades(axes, latency_ms)
    axes.set(title="latency", ylabel="ms")
    _legend(axes)


_ROWS: tuple[Callable[[_Curves, Axes], None], ...] = (
    _draw_size,
    _draw_rates,
    _draw_kept_and_lost,
    _draw_gamma,
    _draw_margin,
    _draw_latency,
)


def frame(events: NDArray[np.void], width: int, height: int, *, ax: Axes | None = None) -> Axes:
    """Draw events as an image: a pixel is red where ON prevails, blue where OFF does.

    Parameters
    ----------
    events : ndarray, shape (n,), EVENT_DTYPE
        For example those of 5 ms. Events outside the sensor are not drawn.
    width, height : int
        Size of the sensor, px.
    ax : Axes, optional
        Where to draw.
    """
    events = events_of_argument("events", events)
    for name, side in (("width", width), ("height", height)):
        _checks.whole(name, side, 1, 65536, "give the sensor's side in px, 1 to 65536")
    axes = ax or _own_axes((5.0, 5.0 * height / width))
    inside = (events["x"] < width) & (events["y"] < height)
    pixel = events["y"][inside].astype(np.int64) * width + events["x"][inside]
    sign = np.where(events["p"][inside] > 0, 1, -1)
    balance = np.bincount(pixel, sign, minlength=width * height)
    image = np.full((width * height, 3), 255, np.uint8)
    # A tie is the last event's.
    image[pixel] = np.where(sign[:, None] > 0, _ON, _OFF)
    image[balance > 0] = _ON
    image[balance < 0] = _OFF
    axes.imshow(image.reshape(height, width, 3), interpolation="nearest")
    axes.set(xlabel="x [px]", ylabel="y [px]")
    axes.grid(False)
    return axes


def clusters(
    events: NDArray[np.void],
    clusters: NDArray[np.void],
    width: int,
    height: int,
    *,
    ax: Axes | None = None,
    lookahead_ms: float = 0.0,
) -> Axes:
    """Draw objects, as their boxes, or clusters, as ellipses of two standard deviations.

    The frame of their events is below.

    Parameters
    ----------
    events : ndarray, shape (n,), EVENT_DTYPE
        The events below, for example the last 5 ms.
    clusters : ndarray, shape (m,)
        ``ClusterTracker.objects``: fields id, x, y, vx, vy, left, top, width, height. Or
        ``ClusterTracker.clusters``: cxx, cxy, cyy in place of the box.
    width, height : int
        Size of the sensor, px.
    ax : Axes, optional
        Where to draw.
    lookahead_ms : float
        A line from each centre shows its way in this time; 0 draws none.
    """
    axes = frame(events, width, height, ax=ax)
    for cluster in clusters:
        axes.add_patch(_outline(cluster))
        x, y = float(cluster["x"]), float(cluster["y"])
        if lookahead_ms > 0:
            dx, dy = (float(cluster[v]) * lookahead_ms / 1e3 for v in ("vx", "vy"))
            axes.plot([x, x + dx], [y, y + dy], color=INK, linewidth=1.2)
        label = {"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none"}
        axes.text(
            x,
            y,
            str(cluster["id"]),
            color=INK,
            fontsize=9,
            ha="center",
            va="center",
            bbox=label,
            clip_on=True,
        )
    axes.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5))
    return axes


_LONG = 40  # tracks that are drawn in colour and named; the others are thin and grey


def tracks(
    tracks: NDArray[np.void],
    *,
    events: NDArray[np.void] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw where clusters went: a line for each, the 40 longest in colour, named at their ends.

    Parameters
    ----------
    tracks : ndarray, shape (n,)
        ``Tracks.tracks``: fields id, x, y, in time order.
    events : ndarray, optional
        Drawn below as grey pixels.
    ax : Axes, optional
        Where to draw.
    """
    axes = ax or _own_axes((5.0, 3.9))
    if events is not None and len(events):
        events = events_of_argument("events", events)
        axes.plot(events["x"], events["y"], ",", color=FAINT, alpha=0.35, rasterized=True)
    order = np.argsort(tracks["id"], kind="stable")
    parts = np.split(order, np.flatnonzero(np.diff(tracks["id"][order])) + 1)
    parts.sort(key=len)
    for rank, part in enumerate(reversed(parts)):
        is_long = rank < _LONG and part.size > 1
        colour = (BLUE, VERMILION, GREEN, PURPLE, AMBER)[rank % 5] if is_long else FAINT
        x, y = tracks["x"][part], tracks["y"][part]
        axes.plot(x, y, color=colour, linewidth=1.3 if is_long else 0.6, zorder=3 if is_long else 2)
        if is_long:
            axes.text(x[-1], y[-1], str(tracks["id"][part[0]]), color=colour, fontsize=9, zorder=4)
    axes.set(aspect="equal", xlabel="x [px]", ylabel="y [px]")
    axes.invert_yaxis()
    axes.grid(False)
    return axes


def _outline(one: np.void) -> Patch:
    style: dict[str, Any] = {"fill": False, "edgecolor": INK, "linewidth": 1.4}
    if "left" in (one.dtype.names or ()):
        left, top, width, height = (float(one[f]) for f in ("left", "top", "width", "height"))
        return Rectangle((left, top), width, height, **style)
    outline = _core.outline_of(*(one[field] for field in ("x", "y", "cxx", "cxy", "cyy")))
    return Ellipse(
        (float(outline["x"]), float(outline["y"])),
        2 * float(outline["major"]),
        2 * float(outline["minor"]),
        angle=float(np.degrees(outline["angle"])),
        **style,
    )


def rate(events: NDArray[np.void], bin_us: float = 10_000, *, ax: Axes | None = None) -> Axes:
    """Draw the event rate in windows of `bin_us`; see `analysis.rate`.

    Parameters
    ----------
    events : ndarray, shape (n,), EVENT_DTYPE
        In time order.
    bin_us : float
        Length of a window in us.
    ax : Axes, optional
        Where to draw.
    """
    time_s, rate_hz = analysis.rate(events, bin_us)
    axes = ax or _own_axes((5.0, 2.2))
    unit, scale = _units.rate_axis(rate_hz.max(initial=0))
    time_s, thinned = analysis.decimate(time_s, rate_hz * scale, 2000)
    axes.plot(time_s, thinned, color=BLUE, drawstyle="steps-post")
    axes.set(xlabel="time from the first event [s]", ylabel=f"event rate [{unit}]")
    axes.set_ylim(bottom=0)
    return axes


def _own_axes(size_inches: tuple[float, float]) -> Axes:
    with matplotlib.rc_context(STYLE):
        return NotebookFigure(figsize=size_inches, layout="constrained").add_subplot()


def _legend(axes: Axes) -> None:
    if not axes.get_legend_handles_labels()[0]:  # of nothing
        return
    # Beside the title, where no curve can be.
    axes.legend(
        loc="lower right",
        bbox_to_anchor=(1.0, 1.0),
        borderaxespad=0.2,
        ncols=5,
        handlelength=1.5,
        handletextpad=0.5,
        columnspacing=1.0,
    )


def _line(axes: Axes, at: float, label: str) -> None:
    axes.axhline(at, color=VERMILION, linestyle=(0, (5, 3)), linewidth=1.2, label=label)


def _log_if_decades(axes: Axes, values: Floats) -> None:
    positive = values[values > 0]
    if positive.size and positive.max() >= 10 * positive.min():
        axes.set_yscale("log")
        axes.yaxis.set_major_formatter(lambda value, _: f"{value:,g}")
        axes.yaxis.set_minor_formatter(lambda value, _: "")


# ---- a comparison ------------------------------------------------------------------------------

_PANEL_INCHES = 0.92
_FRAME_INCHES = 0.95
_SPAN = 100  # latencies from L / 100 to 100 L are told apart


def comparison_figure(comparison: Comparison, *, points: int = 500) -> Figure:
    """Draw latency and kept share over time for each scheme, best score first.

    The first row shows the events that came in. For each scheme the largest latency of the events
    of each moment with the latency bound, and beside it the share of the events that was finished.
    A curve has at most so many points, each with the worst latency and the mean share of what lies
    between.
    """
    rows = comparison.rows
    lines = 1 + len(rows)
    # Fixed titles: to look for a place for each takes longer than to draw the page.
    with matplotlib.rc_context({**STYLE, "axes.titley": 1.0}):
        page = NotebookFigure(
            figsize=(9.0, _FRAME_INCHES + _PANEL_INCHES * lines), layout="constrained"
        )
        grid = page.subplots(lines, 2, sharex=True, squeeze=False)
        windows = {row.label: _Windows.of(comparison, row.label, points) for row in rows}
        for axes in grid[0]:
            _draw_incoming(axes, next(iter(windows.values())))
        for row, (latency, kept) in zip(rows, grid[1:], strict=True):
            _draw_worst_latency(latency, windows[row.label], comparison.latency_ms)
            _draw_kept(kept, windows[row.label])
            _name(latency, kept, row)
        handles = [handle for axes in grid[1] for handle in axes.get_legend_handles_labels()[0]]
        page.legend(handles=handles, loc="outside upper right", ncols=3, handlelength=1.6)
        for axes in grid[-1]:
            axes.set_xlabel("time from the first event [s]")
        for axes in grid.flat:
            axes.margins(x=0.01)
    return page


class _Windows(NamedTuple):
    """A run over time, in windows of equal length."""

    time_s: NDArray[np.float64]
    rate_hz: NDArray[np.float64]
    latency_ms: NDArray[np.float64]  # the largest, NaN where nothing was finished
    kept: NDArray[np.float64]  # NaN where nothing came in
    on_time: NDArray[np.bool_]

    @classmethod
    def of(cls, comparison: Comparison, label: str, points: int) -> _Windows:
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
            on_time=latency_ms <= BOUND_KEPT * comparison.latency_ms,
        )


def _delivered_ms(slots: NDArray[np.void]) -> NDArray[np.float64]:
    return np.asarray(slots["latency_max_us"][slots["delivered"] > 0] / 1e3)


def _draw_incoming(axes: Axes, windows: _Windows) -> None:
    unit, scale = _units.rate_axis(windows.rate_hz.max(initial=0))
    axes.fill_between(windows.time_s, windows.rate_hz * scale, color=FAINT, alpha=0.55, linewidth=0)
    axes.set(title="events that come in", ylabel=unit)
    axes.set_ylim(bottom=0)


def _draw_worst_latency(axes: Axes, windows: _Windows, bound_ms: float) -> None:
    low, high = bound_ms / _SPAN, bound_ms * _SPAN
    axes.plot(windows.time_s, np.clip(windows.latency_ms, low, high), color=BLUE)
    _line(axes, bound_ms, "bound L")
    axes.set(ylabel="latency\n[ms]", ylim=(low / 1.4, high * 1.4), yscale="log")
    axes.yaxis.set_major_locator(LogLocator(numticks=4))
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:,g}")
    axes.yaxis.set_minor_locator(NullLocator())


def _draw_kept(axes: Axes, windows: _Windows) -> None:
    kept = np.nan_to_num(windows.kept)
    for chosen, colour, label in (
        (windows.on_time, GREEN, "kept, all in time"),
        (~windows.on_time, VERMILION, "kept, some too late"),
    ):
        axes.fill_between(
            windows.time_s,
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
    kept.set_title(f"score {_units.score(row.score)}")
    kept.set_title(f"kept {_units.share(row.kept)}", **plain)
