"""Numbers from events and from runs, in plain NumPy: what tables, figures and pages have in common.

Times are seconds from the first event; rates are events per second; windows are half-open.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from asap import _checks
from asap.events import events_of_argument
from asap.results.cost import Cost, Floats, bound_needed_us, fit
from asap.results.run import Run, check_run

_MAX_BINS = 10_000_000
_FAR = 3.5  # sigma of the noise of a cost
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


def time_s(run: Run) -> Floats:
    """Start of each package in s from the first event, shape (packages,)."""
    check_run(run)
    rows = run.packages
    if rows.size == 0:
        return np.empty(0)
    return np.asarray((rows["start_us"] - _begin_us(run)) / 1e6, np.float64)


def _begin_us(run: Run) -> float:
    """Return the stamp of the first event, which may have been lost before the first package."""
    rows = run.packages
    is_lost = rows["stale"][0] + rows["overflow"][0] > 0
    lasted_us = float(run.source["duration_s"]) * 1e6 * bool(is_lost)
    return min(float(rows["t_first"][0]), float(rows["t_last"][-1]) + 1 - lasted_us)


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


def fit_cost(run: Run) -> Cost:
    """Fit the cost that explains the packages of a run; a run without packages costs nothing."""
    check_run(run)
    return fit(run.packages, run.learned, run.execution)


@dataclass(frozen=True)
class Diagnosis:
    """What limited a run, and what would lift the limit; everything but the first is estimated.

    Attributes
    ----------
    limit : str
        ``"data"``: bad events were most of the loss, and too many for the wanted share.
        ``"camera"``: nearly all good events were in time. ``"bound"``: a longer one would do.
        ``"algorithm"``: only a cheaper one would. ``"fixed cost"``: the bound was not kept and
        could not be, whatever the events (`Cost.least_bound_us`). These three only where the cost
        explains at least half of what was lost or late. ``"first call"``, ``"pauses"``: a few
        packages took far longer than the others (`pauses`), so long that this can explain at least
        half of what was lost. ``"machine"``: the thread waited for a processor for half of such
        pauses or longer (`Run.held_s`); or the replay itself was late for so long, however little
        was lost.
        ``"scheme"``: the algorithm could have done it. ``"unknown"``: the packages do not tell the
        cost of an event (`Cost.one_size`, `Cost.beta_error_ns`), or there was no event.
    cost : Cost
        As the packages of the run explain it (`fit_cost`).
    offered_hz : float
        Mean event rate.
    needed_hz : float
        Throughput that keeps the wanted share of the events.
    bound_us : float or None
        Latency bound that gives it; None where none does that the run can tell of.
    longest_us : float
        The longest bound that the run can tell of, a quarter of its duration at most; infinite
        where the mean load is so large that no bound does.
    speedup : float
        How many times faster the algorithm would have to be, at the bound of the run; like the
        bound without its pauses.
    late_share : float
        Share of the time in which the replay itself was late by more than half the bound.
    pauses : Pauses
        The packages that took far longer than the cost explains.
    """

    limit: str
    cost: Cost
    offered_hz: float
    needed_hz: float
    bound_us: float | None
    longest_us: float
    speedup: float
    late_share: float
    pauses: Pauses


class Pauses(NamedTuple):
    """Packages that took far longer than their cost explains: a collector, a first call."""

    times: float  #: from so many times the estimate on, at least twice
    slow: int  #: such packages
    share: float  #: of the time of the run that they took
    excess_share: float  #: the same, beyond the estimate
    first: int  #: how many of them the run began with, if these are most of the excess
    first_us: float  #: the time that these took
    held: bool  #: whether the thread waited for a processor for half of the excess or longer
    away_share: float  #: of the time: the excess, or longer the wait for a processor


def diagnose(run: Run, *, wanted: float = 0.95) -> Diagnosis:
    """Find what kept a run from delivering the wanted share of its events in time.

    The events that came in each window of one latency bound are compared with what the estimated
    cost lets through (T6): a longer load cannot be buffered within the bound.
    """
    cost = fit_cost(run)
    wanted = _checks.number("wanted", wanted, 0, 1, "give a share from 0 to 1")
    bound_us = run.latency_bound_us
    found = windows(run, bound_us * run.speed)
    rates_hz = found.rate_hz(found.received, run.speed)
    needed_hz = _throughput_to_keep(rates_hz, wanted)
    late_share, pauses = _late_share(run), _pauses(run, cost)
    # T6 solved for a factor on alpha and beta together; noise takes room as a fixed cost does.
    planned = replace(cost, alpha_us=cost.alpha_us * (1 + cost.noise))
    speedup = cost.beta_ns * needed_hz / 1e9 + 2 * planned.alpha_us / bound_us
    needed_bound_us, longest_us = _bound_to_keep(run, found, planned, wanted)
    in_time = _good_in_time(run)
    if run.ledger.received == 0:
        limit = "unknown"
    elif _bad_data_limit(run, wanted):
        limit = "data"
    elif (
        run.packages.size > 2  # fewer may be first calls
        and bound_needed_us(cost, bound_us, run.latency.max)
        and _explains(run, cost, rates_hz)
    ):
        limit = "fixed cost"
    elif (
        in_time < wanted
        and speedup > 1
        and cost.one_size is None
        and _explains(run, cost, rates_hz)
    ):
        limit = "algorithm" if needed_bound_us is None else "bound"
    elif in_time < wanted and 1 - in_time <= 2 * _most_in(rates_hz, pauses.away_share):
        limit = "first call" if pauses.first else "machine" if pauses.held else "pauses"
    elif 0 < 1 - in_time <= 2 * _most_in(rates_hz, late_share):
        limit = "machine"
    elif in_time >= wanted:
        limit = "camera"
    else:
        keeps_up = cost.dearest.throughput_hz(bound_us) >= needed_hz
        is_told = cost.one_size is None and (cost.beta_ns > 0 or keeps_up)
        limit = "scheme" if is_told else "unknown"
    mean_hz = float(rates_hz.mean()) if rates_hz.size else 0.0
    needed = needed_hz, needed_bound_us, longest_us, speedup
    return Diagnosis(limit, cost, mean_hz, *needed, late_share, pauses)


def _bound_to_keep(
    run: Run, found: Windows, cost: Cost, wanted: float
) -> tuple[float | None, float]:
    """Find the shortest bound whose own windows let the wanted share through (T6), us.

    Each is 2 % longer than the one before, and the longest a quarter of the run, which is returned
    too: infinite where more comes than the algorithm can do at any bound, the bound of the run
    where that is not sure.
    """
    edges_us, came = found.edges_s * 1e6 / run.speed, np.append(0.0, np.cumsum(found.received))
    tried_us = run.latency_bound_us
    longest_us = max(float(edges_us[-1]) / 4, tried_us)
    wanted_thousands = wanted * came[-1] / 1e3
    if wanted_thousands * cost.beta_ns >= edges_us[-1]:
        is_sure = wanted_thousands * (cost.beta_ns - cost.beta_error_ns) >= edges_us[-1]
        return None, np.inf if is_sure else tried_us
    while tried_us <= longest_us:
        at_us = np.append(np.arange(0.0, edges_us[-1], tried_us), edges_us[-1])
        passes = cost.throughput_hz(tried_us) * np.diff(at_us) / 1e6
        events = np.diff(np.interp(at_us, edges_us, came))
        if np.minimum(events, passes).sum() >= wanted * came[-1]:
            return tried_us, longest_us
        tried_us *= 1.02
    return None, longest_us


def _pauses(run: Run, cost: Cost) -> Pauses:
    """Find the packages that took far longer than the cost and its noise explain."""
    rows = run.packages
    took_us, most = rows["processing_us"], cost.dearest
    estimate_us = most.alpha_us + most.beta_ns * rows["size"] / 1e3
    times = max(2.0, float(np.exp(_FAR * min(cost.noise, 10.0))))
    is_slow = took_us > times * estimate_us
    excess_us = np.where(is_slow, took_us - estimate_us, 0.0)
    wall_us = max(run.source["duration_s"] * 1e6 / run.speed, took_us.sum(), 1.0)
    first = int(is_slow.size if is_slow.all() else is_slow.argmin())
    first *= bool(2 * excess_us[:first].sum() >= excess_us.sum())
    held_us = 1e6 * (run.held_s or 0.0)
    return Pauses(
        times,
        int(is_slow.sum()),
        float(took_us[is_slow].sum() / wall_us),
        float(excess_us.sum() / wall_us),
        first,
        float(took_us[:first].sum()),
        bool(0 < held_us >= excess_us.sum() / 2),
        float(min(max(excess_us.sum(), held_us) / wall_us, 1.0)),
    )


def _bad_data_limit(run: Run, wanted: float) -> bool:
    """Whether bad events alone are too many, and more than all that was lost of the good ones."""
    ledger = run.ledger
    lost = ledger.received * (1 - run.in_time) - ledger.filtered
    return ledger.rejected > (1 - wanted) * ledger.received and 2 * ledger.rejected >= lost


def _good_in_time(run: Run) -> float:
    """Share in time of the events that neither the validator nor the user's filter took out."""
    ledger = run.ledger
    good = ledger.received - ledger.rejected - ledger.filtered
    return run.in_time * ledger.received / good if good else 1.0


def _late_share(run: Run) -> float:
    """Share of the time in which the producer was late by over half the bound, 1 ms a push."""
    wall_us = run.source["duration_s"] * 1e6 / run.speed
    if run.lateness is None or wall_us <= 0:
        return 0.0
    low, high = 0.0, 1.0  # the share of pushes that were not so late
    for _ in range(30):
        q = (low + high) / 2
        is_late = run.lateness.quantile(q) > run.latency_bound_us / 2
        low, high = (low, q) if is_late else (q, high)
    return min((1 - high) * run.lateness.count * 1_000 / float(wall_us), 1.0)


def _most_in(rates_hz: Floats, share: float) -> float:
    """Share of the events in the busiest windows that are so large a share of the time."""
    busiest = np.sort(rates_hz)[::-1][: int(np.ceil(share * rates_hz.size))]
    return float(busiest.sum() / rates_hz.sum()) if busiest.size else 0.0


def _explains(run: Run, cost: Cost, rates_hz: Floats) -> bool:
    """Whether at most twice as much was lost or late as has to be dropped at this cost (T6)."""
    ledger = run.ledger
    passed = float(np.minimum(rates_hz, cost.throughput_hz(run.latency_bound_us)).sum())
    unavoidable = (ledger.received - ledger.rejected) * (1 - passed / float(rates_hz.sum()))
    late = ledger.delivered - run.latency.within_bound
    return ledger.discarded + ledger.stale + late <= 2 * unavoidable


class Windows(NamedTuple):
    """Events of each window by where they went; the edges in s, one more than windows."""

    edges_s: Floats
    received: Floats
    delivered: Floats
    filtered: Floats
    discarded: Floats
    stale: Floats
    overflow: Floats

    def rate_hz(self, events: Floats, speed: float = 1.0) -> Floats:
        """Return so many events of each window as a rate, of wall time at this speed."""
        return np.asarray(events / np.diff(self.edges_s) * speed, np.float64)


def windows(run: Run, window_us: float | None = None) -> Windows:
    """Count where the events of a run went, in windows of equal length on the recording's axis.

    The events of a package count as evenly spread over it, what was lost before it as evenly spread
    since the package before. By default a window is 1, 2 or 5 times a power of ten long, so that it
    holds 100 events on average and there are at most 400.
    """
    check_run(run)
    rows = run.packages
    if rows.size == 0:
        return Windows(np.zeros(1), *[np.empty(0)] * 6)
    # From its first event to just after its last.
    at_us = np.column_stack((rows["t_first"], rows["t_last"] + 1)).ravel() - _begin_us(run)
    within = np.asarray(np.maximum.accumulate(at_us), np.float64)
    duration_us = max(float(within[-1]), run.source["duration_s"] * 1e6)
    before = np.concatenate(([0.0], within, [duration_us]))  # and after the last
    stale, overflow = (
        np.append(rows[name], run.ledger[name] - rows[name].sum()) for name in ("stale", "overflow")
    )
    if window_us is None:
        events = int(rows["offered"].sum() + stale.sum() + overflow.sum())
        window_us = _round_up(max(duration_us / 400, 100 * duration_us / events))
    count = min(max(round(duration_us / window_us), 1), 1_000_000)
    edges_us = np.append(np.arange(count) * window_us, duration_us)  # the last takes the rest
    thinned = np.rint(rows["size"] / rows["gamma"])
    went = (
        _spread(within, rows["size"], edges_us),
        _spread(within, rows["offered"] - thinned, edges_us),
        _spread(within, thinned - rows["size"], edges_us),
        _spread(before, stale, edges_us),
        _spread(before, overflow, edges_us),
    )
    return Windows(edges_us / 1e6, np.sum(went, axis=0), *went)


def _round_up(value: float) -> float:
    power = 10.0 ** np.floor(np.log10(value))
    return float(next(factor * power for factor in (1, 2, 5, 10) if factor * power >= value))


def _spread(at_us: Floats, counts: NDArray[np.int64], edges_us: Floats) -> Floats:
    """Events in each window, from those of each package between its two times."""
    total = np.cumsum(counts, dtype=np.float64)
    before_and_after = np.column_stack((np.append(0.0, total[:-1]), total)).ravel()
    reached = np.interp(edges_us, at_us, before_and_after)
    reached[0], reached[-1] = 0.0, total[-1]
    return np.asarray(np.diff(reached), np.float64)


def _throughput_to_keep(rates_hz: Floats, share: float) -> float:
    """Cap c for which sum(min(rate, c)) is the given share of sum(rate)."""
    if rates_hz.size == 0:
        return 0.0
    ascending = np.sort(rates_hz)
    # With the cap at ascending[i], the i smaller ones pass whole and the others are cut to it.
    below = np.append(0.0, np.cumsum(ascending)[:-1])
    others = np.arange(ascending.size, 0, -1)
    passed = below + others * ascending
    wanted = share * float(ascending.sum())
    i = min(int(np.searchsorted(passed, wanted)), ascending.size - 1)
    return float((wanted - below[i]) / others[i])
