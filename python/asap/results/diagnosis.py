"""What limited a run, what that cost, and what would lift the limit: in numbers and in words."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from asap import _checks, _units
from asap.results.cost import MIN_BOUND, Cost, Floats, bound_needed_us, fit
from asap.results.run import LONG_GAP, Run, check_run

_FAR = 3.5  # sigma of the noise of a cost


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


# ---- over time ---------------------------------------------------------------------------------


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


# ---- in words ----------------------------------------------------------------------------------


def verdict(run: Run) -> str:
    """Say what limited a run, what that cost, and what would have kept 95 % of the events.

    What follows from the measured processing times is marked as estimated.
    """
    if run.ledger.received == 0:
        return "No event was received."
    if run.without_log:
        return (
            "Bottleneck: not known, since a summary holds no packages; run.save('run.npz') keeps "
            f"them. {_losses(run)}"
        )
    found = diagnose(run)
    if run.packages.size == 0 and found.limit != "data":
        return f"No event reached the algorithm. {_losses(run)}"
    bottleneck = _BOTTLENECKS[found.limit].format(scheme=run.scheme.name)
    in_time = _units.share(run.in_time).replace("100.0 %", "100 %")
    return (
        f"Bottleneck: {bottleneck}. {in_time} processed in time. "
        f"{_explanation(run, found)} {_losses(run)}"
    )


_BOTTLENECKS = {
    "data": "bad events in the data",
    "camera": "the camera",
    "scheme": "the scheme ({scheme})",
    "machine": "this machine",
    "bound": "the latency bound",
    "algorithm": "the algorithm",
    "first call": "the first call",
    "pauses": "pauses of the algorithm",
    "fixed cost": "the fixed cost of a package",
    "unknown": "not known",
}


def _explanation(run: Run, found: Diagnosis) -> str:
    if found.limit == "data":
        return (
            f"{_units.count(run.ledger.rejected)} of {_units.count(run.ledger.received)} events "
            f"were rejected ({_units.reasons(run.rejected)}). asap.check shows where."
        )
    cost = f"Estimated cost: {_run_cost(found.cost)}{_slow_packages(run, found.pauses)}."
    return f"{cost} {_run_remedy(run, found)}".rstrip()


def _run_cost(cost: Cost) -> str:
    noise = f"{100 * cost.noise:.0f}"
    spread = f", +- {noise} %" if noise != "0" else ""
    per_event = _units.duration((cost.beta_ns or cost.beta_error_ns) / 1e3)
    if cost.one_size is None:
        least = "at most " * (cost.beta_ns == 0 < cost.beta_error_ns)
        return (
            f"{_units.duration(cost.alpha_us)} per package + {least}{per_event} per event{spread}"
        )
    package = _units.duration(cost.alpha_us + cost.beta_ns / 1e3 * cost.one_size)
    events = "1 event" if cost.one_size == 1 else f"{_units.count(cost.one_size)} events"
    return f"{package} per package of {events}{spread}"


def _slow_packages(run: Run, pauses: Pauses) -> str:
    if pauses.slow < 0.01 * run.packages.size and pauses.share < 0.01:
        return ""
    which = f"{pauses.first} packages" if pauses.first > 1 else "package"
    first = f", the first {which} {_units.duration(pauses.first_us)}" if pauses.first else ""
    packages = "1 package" if pauses.slow == 1 else f"{_units.count(pauses.slow)} packages"
    return (
        f"; {packages} took more than {pauses.times:.2g} times the estimate, "
        f"{_units.share(pauses.share)} of the time{first}"
    )


def _run_remedy(run: Run, found: Diagnosis) -> str:
    bound = _units.duration(run.latency_bound_us)
    if found.limit == "machine":
        late = (
            f"The replay itself was late, by {_units.duration(run.lateness.max)} at most and by "
            f"more than half the bound for {_units.share(found.late_share)} of the time. "
            if run.lateness and found.late_share
            else ""
        )
        held = f"waited for a processor for {_units.duration(1e6 * (run.held_s or 0))} in all"
        held = f"The algorithm's thread {held}. " * found.pauses.held
        return f"{late}{held}Repeat it on a quiet machine, or in virtual time."
    if found.limit == "fixed cost":
        return _impossible(run, found.cost)
    if found.limit == "first call":
        return "Call the algorithm once before the run."
    if found.limit == "pauses":
        others = ", or other programs took the processor" * (run.held_s is None)
        return f"A garbage collector, memory, files or locks make an algorithm pause{others}."
    if found.limit == "unknown":
        return (
            "These packages are too few, or too alike in size, to tell what of it is per event. "
            "Those of another scheme may tell: asap.Greedy() takes all that waits. If the first "
            "call compiles or loads something, call the algorithm once before the run."
        )
    if found.cost.one_size is not None:
        return ""
    faster = f"make the algorithm {math.ceil(10 * found.speedup) / 10} times as fast"
    if getattr(run.scheme, "parameters", {}).get("rate_bound", found.needed_hz) < found.needed_hz:
        faster += " and raise rate_bound"
    if found.pauses.excess_share > 0.05:
        faster += ", and call it once before the run" if found.pauses.first else ", without pauses"
    more, remedy = " asap.compare shows which scheme processes more.", ""
    if found.limit == "bound" and found.bound_us is not None:
        remedy = f"use a bound of {_units.duration(found.bound_us)} or {faster}."
    if found.limit == "algorithm":
        remedy = f"{faster}: it has to process {_units.rate(found.needed_hz)}."
    if remedy:
        up_to = f"bound of up to {_units.duration(found.longest_us)}"
        ruled_out = f"A {'longer bound' if math.isinf(found.longest_us) else up_to} does not help. "
        ruled_out *= found.bound_us is None and found.longest_us > run.latency_bound_us
        late = more * (run.kept - run.in_time > 0.05)
        return f"{ruled_out}To process 95 % in time, {remedy}{late}"
    is_told = found.cost.beta_ns > 0 and found.cost.one_size is None
    passes_hz = (found.cost if is_told else found.cost.dearest).throughput_hz(run.latency_bound_us)
    if passes_hz == float("inf"):
        passes = f"The algorithm keeps up with any event rate within {bound}."
    else:
        passes = (
            f"The algorithm can process {'' if is_told else 'at least '}{_units.rate(passes_hz)} "
            f"within {bound}; {_units.rate(found.offered_hz)} arrived on average."
        )
    return passes + more * (found.limit == "scheme")


def _impossible(run: Run, cost: Cost) -> str:
    bound_us = run.latency_bound_us
    p99, most = (f"{us / bound_us:.3g}" for us in (run.latency.quantile(0.99), run.latency.max))
    least_us = cost.least_bound_us
    if least_us > MIN_BOUND * cost.alpha_us:
        cheaper = f"an algorithm that processes a single event in {_units.duration(bound_us / 2)}"
    else:
        cheaper = f"a fixed cost of {_units.duration(bound_us / MIN_BOUND)}"
    return (
        f"No scheme can keep a bound of {_units.duration(bound_us)} at this cost: latency was "
        f"{p99} (p99) and {most} (max) times as long. "
        f"Use a bound of at least {_units.duration(least_us)}, or {cheaper} or less."
    )


def _losses(run: Run) -> str:
    ledger = run.ledger
    causes = ("rejected", "discarded", "stale", "overflow", "pending")  # a filter is a choice
    shares = {cause: ledger[cause] / ledger["received"] for cause in causes}
    shares["delivered late"] = run.kept - run.in_time
    lost = [f"{_units.share(share)} {cause}" for cause, share in shares.items() if share > 0]
    words = f"Lost: {', '.join(lost)}." if lost else "No event was lost."
    if ledger["filtered"] > 0:
        words += f" The filter took out {_units.share(ledger['filtered'] / ledger['received'])}."
    gap_us = run.gap_us or 0
    if ledger["delivered"] == 0 or gap_us <= LONG_GAP * run.latency_bound_us:
        return words
    return (
        f"{words} The longest gap is {_units.duration(gap_us)} "
        f"({gap_us / run.latency_bound_us:.2g} L): events came, and none of them was processed. "
        "asap.compare shows the gaps of other schemes."
    )
