"""What limited a run, from its packages and the cost that they show."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from asap import _checks
from asap.results.cost import Cost, bound_needed_us, cost_of

if TYPE_CHECKING:
    from asap.results.run import Run

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
