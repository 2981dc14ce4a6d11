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

BOUND_KEPT = 1.01  # times the bound: one stratum of a package may run over it
LEAST_BOUND = 2.5  # fixed costs

_ROUNDING_US = 1e-6  # no algorithm handles an event in a picosecond
_FIRST_GUESS_LASTS = 8  # packages


@dataclass(frozen=True)
class Cost:
    """A package of n events takes ``alpha_us + beta_ns n / 1000`` us."""

    alpha_us: float
    beta_ns: float

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
        shortest that is worth its while (theory, section 6).
        """
        return max(LEAST_BOUND * self.alpha_us, 2 * (self.alpha_us + self.beta_ns / 1e3))


def fit_cost(run: Run) -> Cost:
    """Least-squares line through the measured processing times of the packages.

    Neither coefficient is below zero: where the line says so, the other one alone is fitted.
    A run without packages costs nothing.
    """
    check_run(run)
    size = run.packages["size"].astype(np.float64)
    processing_us = run.packages["processing_us"].astype(np.float64)
    if size.size == 0:
        return Cost(0.0, 0.0)
    spread = size - size.mean()
    if (variance := float(spread @ spread)) > 0:
        beta_us = float(spread @ processing_us) / variance
        alpha_us = float(processing_us.mean() - beta_us * size.mean())
        if beta_us < _ROUNDING_US:
            return Cost(float(processing_us.mean()), 0.0)
        if alpha_us >= 0:
            return Cost(alpha_us, beta_us * 1e3)
    squares = float(size @ size)
    return Cost(0.0, float(size @ processing_us) / squares * 1e3 if squares > 0 else 0.0)


def cost_of(run: Run) -> Cost:
    """Cost that the scheme had learned by the end of the run; where it learns none, the fit."""
    check_run(run)
    rows = run.packages
    if run.learned is None or rows.size < _FIRST_GUESS_LASTS:
        return fit_cost(run)
    # An outage can make the fixed cost look larger than it is, but no package costs less.
    return Cost(min(run.learned.alpha_us, float(rows["processing_us"].min())), run.learned.beta_ns)


def check_run(run: Any) -> None:
    """Refuse what is no run, and one that holds no packages since it was saved without."""
    if not hasattr(run, "packages"):
        raise TypeError(_checks.named("run", run, "give a run of asap.run or asap.simulate"))
    if getattr(run, "without_log", False):
        remedy = "a summary holds no packages; save the run with run.save('run.npz')"
        raise ValueError(_checks.named("run", run, remedy))


def bound_needed_us(run: Run) -> float | None:
    """Shortest bound that the algorithm allows, us, where that of the run was shorter.

    None where the bound was kept, or was missed for another reason.
    """
    kept = run.latency.max <= BOUND_KEPT * run.latency_bound_us
    least_us = cost_of(run).least_bound_us
    return None if kept or least_us <= run.latency_bound_us else least_us


Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Diagnosis:
    """What limited a run, and what would lift the limit; everything but the first is estimated.

    Attributes
    ----------
    limit : str
        ``"data"``: bad events were most of the loss, and too many for the wanted share.
        ``"camera"``: nearly all good events were in time. ``"scheme"``: the algorithm could have
        done it. ``"machine"``: it could, but the replay itself was late by much of the bound.
        ``"bound"``: a longer one would do. ``"algorithm"``: only a cheaper one would.
        ``"fixed cost"``: the bound was not kept and could not be, whatever the events
        (`Cost.least_bound_us`).
    cost : Cost
        Learned by the scheme, else from the packages of the run.
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
    cost = cost_of(run)
    wanted = _checks.number("wanted", wanted, 0, 1, "give a share from 0 to 1")
    bound_us = run.latency_bound_us
    rates_hz = _offered_rates(run, bound_us)
    needed_hz = _throughput_to_keep(rates_hz, wanted)
    # T6 solved for L, and for a factor on alpha and beta together.
    load = cost.beta_ns * needed_hz / 1e9
    needed_bound_us = 2 * cost.alpha_us / (1 - load) if load < 1 else None
    speedup = load + 2 * cost.alpha_us / bound_us
    if _bad_data_limit(run, wanted):
        limit = "data"
    elif bound_needed_us(run) is not None:
        limit = "fixed cost"
    elif _good_in_time(run) >= wanted:
        limit = "camera"
    elif speedup <= 1:
        late_us = run.lateness.quantile(0.99) if run.lateness is not None else 0.0
        limit = "machine" if late_us > bound_us / 2 else "scheme"
    else:
        limit = "algorithm" if needed_bound_us is None else "bound"
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
