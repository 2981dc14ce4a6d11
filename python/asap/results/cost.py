"""What the algorithm of a run costs, as far as the run tells; and the bound that this rules out."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from asap import _checks

if TYPE_CHECKING:
    from asap.results.run import Run

Floats = NDArray[np.float64]

BOUND_KEPT = 1.01  # times the bound: one stratum of a package may run over it
LEAST_BOUND = 2.5  # fixed costs

_FITTED = 8192  # packages; of more, so many are drawn at random
_OF_NORMAL = 1.4826  # standard deviation over median absolute deviation
_OF_MEDIAN = 1.25  # standard error of a median over that of a mean
_PLACE = 1e-6  # of the fixed share, as the argument of a logistic function
_SURE = 0.05  # standard error of the fixed share at which alpha and beta are told apart


@dataclass(frozen=True)
class Cost:
    """A package of n events takes ``(alpha_us + beta_ns n / 1000) X`` us.

    X is lognormal of mean 1 with sigma = `noise`, as in `LinearCost`. `one_size` is None unless the
    packages were too few, or too alike in size, to tell alpha from beta: then it is their typical
    size, and the cost is known for packages like them.
    """

    alpha_us: float
    beta_ns: float
    noise: float = 0.0
    one_size: int | None = None

    def throughput_hz(self, bound_us: float) -> float:
        """Largest event rate whose latency stays below the bound at full load.

        a* = (1 - 2 alpha / L) / beta: theory T6 of the project's control notes.
        """
        bound_us = _checks.number("bound_us", bound_us, 0, sys.float_info.max, "give 0 us or more")
        share = max(0.0, 1 - 2 * self.alpha_us / bound_us) if bound_us > 0 else 0.0
        if self.beta_ns > 0:
            return share / self.beta_ns * 1e9
        return np.inf if share > 0 else 0.0

    @property
    def least_bound_us(self) -> float:
        """Shortest latency bound that can be promised: 2.5 fixed costs, or two single events.

        An event that just misses a package waits for its end, and one of 1.25 fixed costs is the
        shortest that is worth its while (theory, section 6). Where the fixed cost is not known, two
        events at their share of a package.
        """
        if self.one_size is not None:
            return 2 * (self.alpha_us / self.one_size + self.beta_ns / 1e3)
        return max(LEAST_BOUND * self.alpha_us, 2 * (self.alpha_us + self.beta_ns / 1e3))


def fit_cost(run: Run) -> Cost:
    """Fit the cost that explains the packages of a run; a run without packages costs nothing.

    Notes
    -----
    The line has the least mean absolute deviation of log c from log(alpha + beta n), alpha >= 0 and
    beta >= 0: a package that the machine interrupted does not tilt it. The noise is the median
    absolute deviation, as that of a normal distribution; a mean is exp(noise^2 / 2) medians.

    A scheme with a budget ends an anytime package by the clock: its size follows from its cost and
    tells nothing of the line. There the fixed share is that of the packages that were not thinned
    or, where these are few, the one that the scheme has learned from the parts of its packages.
    """
    check_run(run)
    rows = run.packages
    if rows.size > _FITTED:
        rows = rows[np.random.default_rng(0).integers(0, rows.size, _FITTED)]
    rows = rows[(rows["size"] > 0) & (rows["processing_us"] > 0)]
    if rows.size == 0:
        return Cost(0.0, 0.0)
    typical = float(np.exp(np.log(rows["size"]).mean()))
    size, log_cost = rows["size"] / typical, np.log(rows["processing_us"])
    share, error = _fixed_share(run, size, log_cost, rows["size"] == rows["offered"], typical)
    off = log_cost - np.log(share + (1 - share) * size)
    noise = _noise(off)
    mean_us = float(np.exp(np.median(off) + min(noise, 1.0) ** 2 / 2))
    return Cost(
        alpha_us=share * mean_us,
        beta_ns=(1 - share) * mean_us / typical * 1e3,
        noise=noise,
        one_size=None if error <= _SURE else round(typical),
    )


def _fixed_share(
    run: Run, size: Floats, log_cost: Floats, whole: NDArray[np.bool_], typical: float
) -> tuple[float, float]:
    """Find the share of alpha in the cost of a package of the typical size, and its error."""
    learned = run.learned
    if learned is None or run.opaque:
        return _fitted_share(size, log_cost)
    if 2 * np.count_nonzero(whole) >= whole.size:
        return _fitted_share(size[whole], log_cost[whole])
    events_us = learned.beta_ns / 1e3 * typical
    return learned.alpha_us / max(learned.alpha_us + events_us, sys.float_info.min), 0.0


def _fitted_share(size: Floats, log_cost: Floats) -> tuple[float, float]:
    """Find the share whose line has the least deviation, and its standard error."""

    def off(share: float) -> Floats:
        return log_cost - np.log(share + (1 - share) * size)

    def deviation(share: float) -> float:
        found = off(share)
        return float(np.abs(found - np.median(found)).mean())

    def at(place: float) -> float:
        return float(1 / (1 + np.exp(-place)))

    grid, golden = np.arange(-18.0, 20.0, 2.0), (5**0.5 - 1) / 2
    centre = float(min(grid, key=lambda place: deviation(at(place))))
    low, high = centre - 2, centre + 2
    while high - low > _PLACE:
        left, right = high - golden * (high - low), low + golden * (high - low)
        low, high = (low, right) if deviation(at(left)) <= deviation(at(right)) else (left, high)
    # One coefficient alone, where that explains the packages as well.
    share = min(0.0, 1.0, at((low + high) / 2), key=lambda share: round(deviation(share), 9))
    tilt = (1 - size) / (share + (1 - share) * size)
    spread = float(tilt.std()) * size.size**0.5 if size.size > 2 else 0.0
    return share, _OF_MEDIAN * _noise(off(share)) / spread if spread > 0 else np.inf


def _noise(off: Floats) -> float:
    """Return the sigma of deviations from a line, which passes through two packages."""
    away = np.sort(np.abs(off - np.median(off)))[2:]
    return _OF_NORMAL * float(np.median(away)) if away.size else 0.0


def check_run(run: Any) -> None:
    """Refuse what is no run, and one that holds no packages since it was saved without."""
    if not hasattr(run, "packages"):
        raise TypeError(_checks.named("run", run, "give a run of asap.run or asap.simulate"))
    if getattr(run, "without_log", False):
        remedy = "a summary holds no packages; save the run with run.save('run.npz')"
        raise ValueError(_checks.named("run", run, remedy))


def bound_needed_us(run: Run, cost: Cost) -> float | None:
    """Shortest bound that the algorithm allows, us, where that of the run was shorter.

    None where the bound was kept, or was missed for another reason.
    """
    kept = run.latency.max <= BOUND_KEPT * run.latency_bound_us
    return None if kept or cost.least_bound_us <= run.latency_bound_us else cost.least_bound_us


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
        explains at least half of what the scheme dropped. ``"scheme"``: the algorithm could have
        done it. ``"machine"``: it could, but the replay itself was late by much of the bound.
        ``"unknown"``: the packages do not tell the cost of an event (`Cost.one_size`).
    cost : Cost
        As the packages of the run explain it (`fit_cost`).
    offered_hz : float
        Mean event rate.
    needed_hz : float
        Throughput that keeps the wanted share of the events.
    bound_us : float or None
        Latency bound that gives it; None where no bound does.
    speedup : float
        How many times faster the algorithm would have to be, at the bound of the run.
    """

    limit: str
    cost: Cost
    offered_hz: float
    needed_hz: float
    bound_us: float | None
    speedup: float


def diagnose(run: Run, *, wanted: float = 0.95) -> Diagnosis:
    """Find what kept a run from delivering the wanted share of its events in time.

    The events that came in each window of one latency bound are compared with what the estimated
    cost lets through (T6): a longer load cannot be buffered within the bound.
    """
    cost = fit_cost(run)
    wanted = _checks.number("wanted", wanted, 0, 1, "give a share from 0 to 1")
    bound_us = run.latency_bound_us
    rates_hz = _offered_rates(run, bound_us)
    needed_hz = _throughput_to_keep(rates_hz, wanted)
    # T6 solved for L, and for a factor on alpha and beta together.
    load = cost.beta_ns * needed_hz / 1e9
    needed_bound_us = 2 * cost.alpha_us / (1 - load) if load < 1 else None
    speedup = load + 2 * cost.alpha_us / bound_us
    late_us = run.lateness.quantile(0.99) if run.lateness is not None else 0.0
    if _bad_data_limit(run, wanted):
        limit = "data"
    elif bound_needed_us(run, cost) is not None and _explains(run, cost, rates_hz):
        limit = "fixed cost"
    elif _good_in_time(run) >= wanted:
        limit = "camera"
    elif speedup > 1 and cost.one_size is None and _explains(run, cost, rates_hz):
        limit = "algorithm" if needed_bound_us is None else "bound"
    elif late_us > bound_us / 2:
        limit = "machine"
    else:
        limit = "scheme" if cost.one_size is None else "unknown"
    mean_hz = float(rates_hz.mean()) if rates_hz.size else 0.0
    return Diagnosis(limit, cost, mean_hz, needed_hz, needed_bound_us, speedup)


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


def _explains(run: Run, cost: Cost, rates_hz: Floats) -> bool:
    """Whether the scheme dropped at most twice what has to be dropped at this cost (T6)."""
    ledger = run.ledger
    passed = float(np.minimum(rates_hz, cost.throughput_hz(run.latency_bound_us)).sum())
    unavoidable = (ledger.received - ledger.rejected) * (1 - passed / float(rates_hz.sum()))
    return ledger.discarded + ledger.stale <= 2 * unavoidable


def _offered_rates(run: Run, window_us: float) -> Floats:
    """Event rate (wall time) in windows over the run, losses before the packages included."""
    rows = run.packages
    if rows.size == 0:
        return np.empty(0)
    total = np.cumsum(rows["offered"] + rows["stale"] + rows["overflow"], dtype=np.float64)
    # Within a package the events count as evenly spread from its first to just after its last.
    at_us = np.column_stack((rows["t_first"], rows["t_last"] + 1)).ravel() - rows["t_first"][0]
    at_us = np.maximum.accumulate(at_us) / run.speed
    before_and_after = np.column_stack((np.append(0.0, total[:-1]), total)).ravel()
    duration_us = float(at_us[-1])
    windows = min(max(round(duration_us / window_us), 1), 1_000_000)
    edges_us = np.linspace(0.0, duration_us, windows + 1)
    counts = np.diff(np.interp(edges_us, at_us, before_and_after))
    return np.asarray(counts * (windows * 1e6 / duration_us), np.float64)


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
