"""Numbers from events and from runs, in plain NumPy.

Times are seconds from the first event; rates are events per second; windows are half-open.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from asap import _checks
from asap.events import events_of_argument
from asap.results.cost import Cost, Floats
from asap.results.diagnosis import Diagnosis, Pauses, diagnose, fit_cost, time_s
from asap.results.run import Run, check_run

__all__ = ["Cost", "Description", "Diagnosis", "Pauses", "PeakCount"]
__all__ += ["decimate", "describe", "diagnose", "fit_cost", "median_in_windows", "rate", "time_s"]

_MAX_BINS = 10_000_000
_POSITIVE = "must be positive and finite"


def rate(events: NDArray[np.void], bin_us: float) -> tuple[Floats, Floats]:
    """Event rate in windows of equal length, the first of which begins with the first event.

    Parameters
    ----------
    events : ndarray, shape (n,), EVENT_DTYPE
        Events in time order.
    bin_us : float
        Length of a window in us.

    Returns
    -------
    time_s : ndarray, shape (m,)
        Begin of each window, s from the first event.
    rate_hz : ndarray, shape (m,)
        Events per second in it.

    Raises
    ------
    ValueError
        `bin_us` is not positive, or so short that there would be more than ten million windows.
    """
    events = events_of_argument("events", events)
    _checks.number("bin_us", bin_us, sys.float_info.min, sys.float_info.max, _POSITIVE)
    if events.size == 0:
        return np.empty(0), np.empty(0)
    elapsed_us = events["t"] - events["t"][0]
    fits = int(elapsed_us[-1]) / float(bin_us) < _MAX_BINS
    _checks.require(fits, "bin_us", bin_us, "too short for this duration")
    bin_us = float(bin_us)
    counts = np.bincount((elapsed_us // bin_us).astype(np.int64))
    time_s = np.arange(counts.size, dtype=np.float64) * (bin_us / 1e6)
    return time_s, counts.astype(np.float64) * (1e6 / bin_us)


@dataclass(frozen=True)
class Description:
    """What a recording holds: counts, duration, rates in ev/s and the largest coordinates in px.

    Peaks are of aligned windows, of the whole duration where it is shorter than one.
    """

    events: int
    duration_s: float
    on_share: float
    rate_mean_hz: float
    rate_peak_1ms_hz: float
    rate_peak_10ms_hz: float
    x_max: int
    y_max: int


def _blocks(blocks: Iterable[NDArray[np.void]]) -> Iterator[NDArray[np.void]]:
    if not isinstance(blocks, Iterable) or isinstance(blocks, (str, np.ndarray)):
        raise TypeError(_checks.named("blocks", blocks, "give a recording, or a list of arrays"))
    return (events_of_argument("blocks", block) for block in blocks)


def describe(blocks: Iterable[NDArray[np.void]]) -> Description:
    """Count, duration, rates, share of ON events and reach of a recording, block by block.

    Parameters
    ----------
    blocks : iterable of ndarray, EVENT_DTYPE
        The recording in time order; it is read once and never held as a whole.

    Returns
    -------
    Description
        Mean rate = events / (last time - first time); a recording without duration has rate 0.
    """
    events = on = x_max = y_max = 0
    t_first = t_last = 0
    fine, coarse = PeakCount(1_000), PeakCount(10_000)
    for block in _blocks(blocks):
        if block.size == 0:
            continue
        t = block["t"]
        if events == 0:
            t_first = int(t[0])
        events += block.size
        on += int(np.count_nonzero(block["p"] > 0))
        t_last = int(t[-1])
        x_max, y_max = max(x_max, int(block["x"].max())), max(y_max, int(block["y"].max()))
        fine.add(t - t_first)
        coarse.add(t - t_first)
    duration_s = (t_last - t_first) / 1e6
    return Description(
        events=events,
        duration_s=duration_s,
        on_share=on / events if events else 0.0,
        rate_mean_hz=events / duration_s if duration_s > 0 else 0.0,
        rate_peak_1ms_hz=fine.rate_hz,
        rate_peak_10ms_hz=coarse.rate_hz,
        x_max=x_max,
        y_max=y_max,
    )


class PeakCount:
    """Largest number of events in one aligned window, over blocks that may cut a window."""

    def __init__(self, window_us: int) -> None:
        """Count in windows of this length, the first of which begins at 0."""
        _checks.whole("window_us", window_us, 1, 2**62, "give at least 1 us")
        self.peak = 0
        self._window_us = window_us
        self._open_window = -1
        self._open_count = 0
        self._last_us = 0

    @property
    def rate_hz(self) -> float:
        """Events per second in that window, of which no more counts than the duration."""
        return self.peak * 1e6 / (min(self._window_us, self._last_us) or self._window_us)

    def add(self, elapsed_us: NDArray[np.int64]) -> None:
        """Count the times of one block, at least one, none before those of the last block."""
        elapsed_us = _checks.column("elapsed_us", elapsed_us)
        _checks.require(elapsed_us.size > 0, "elapsed_us", elapsed_us, "give at least one time")
        windows, counts = np.unique(elapsed_us // self._window_us, return_counts=True)
        if windows[0] == self._open_window:
            counts[0] += self._open_count
        self.peak = max(self.peak, int(counts.max()))
        self._open_window, self._open_count = int(windows[-1]), int(counts[-1])
        self._last_us = int(elapsed_us[-1])


def decimate(x: Floats, y: Floats, points: int) -> tuple[Floats, Floats]:
    """Thin a curve for drawing: smallest and largest y of every column of pixels stay.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Not decreasing.
    y : ndarray, shape (n,)
        One value for each x.
    points : int
        The most points to keep, at least 4.

    Returns
    -------
    x, y : ndarray, shape (m,)
        At most `points` of the given points in their order, the first and the last among them.

    Raises
    ------
    ValueError
        `points` is below 4.
    """
    x, y = _checks.column("x", x), _checks.column("y", y)
    _checks.require(x.size == y.size, "y", y, f"give one value for each of the {x.size} x")
    _checks.whole("points", points, 4, 2**62, "must be at least 4")
    if x.size <= points:
        return x, y
    columns = (points - 2) // 2
    column = np.minimum((x - x[0]) / max(x[-1] - x[0], 1e-300) * columns, columns - 1)
    column = column.astype(np.int64)
    by_height = np.lexsort((y, column))
    begins = np.flatnonzero(np.diff(column, prepend=-1))
    ends = np.append(begins[1:], x.size) - 1
    keep = np.unique(np.concatenate(([0, x.size - 1], by_height[begins], by_height[ends])))
    return x[keep], y[keep]


def median_in_windows(run: Run, column: str, window_ms: float) -> tuple[Floats, Floats]:
    """Median of a column of ``run.packages`` over the packages that start in each window.

    Parameters
    ----------
    run : Run
        A finished run.
    column : str
        Name of the column, for example ``"margin_us"``.
    window_ms : float
        Length of a window in ms.

    Returns
    -------
    time_s : ndarray, shape (m,)
        Begin of each window in which a package started, s from the first event.
    median : ndarray, shape (m,)
        In the unit of the column.

    Raises
    ------
    ValueError
        `window_ms` is not positive, or there is no such column.
    """
    check_run(run)
    _checks.number("window_ms", window_ms, sys.float_info.min, sys.float_info.max, _POSITIVE)
    _checks.choice("column", column, run.packages.dtype.names or ())
    window_s = float(window_ms) / 1e3
    windows, begins = np.unique(np.floor(time_s(run) / window_s), return_index=True)
    parts = np.split(run.packages[column], begins[1:]) if windows.size else []
    return windows * window_s, np.array([np.median(part) for part in parts], np.float64)
