"""What a run is judged by: the quantities of the tables, from a run and the oracle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from asap.experiment import Run
from asap.experiment.comparing import Contender, side_by_side
from asap.experiment.source import CheckedStream
from asap_laboratory import metrics
from asap_laboratory.profiles import Scenario

_PHASE_MS = 500  # of the profiles that step


@dataclass(frozen=True)
class Figures:
    """One contender in one scenario; latencies of delivered events, ms."""

    score: float  #: in-time events / OB(L)
    opaque_score: float  #: the same against the oracle that takes a package as a whole
    in_time: float  #: of the input
    kept: float  #: of the input
    p50_ms: float
    p99_ms: float
    max_ms: float
    start_max_ms: float  #: the largest latency of events of the first 100 ms
    gap_ms: float  #: between delivered events, of those that lost one between
    silence_ms: float  #: longest run of 1 ms slots with events of which none was delivered
    overflow: float  #: of the input
    packages_per_s: float
    cpu: float  #: at most 1
    settle_ms: float | None  #: mean over the steps up; None without steps
    recovery_ms: float | None  #: mean over the steps down
    slowest_recovery_ms: float | None  #: largest over the steps down


@dataclass(frozen=True)
class Measured:
    """All contenders in one scenario."""

    events: int
    oracle: float  #: OB(L), events
    figures: dict[str, Figures]  #: by label
    exact: int | None = None  #: EC(L), events, where it can be computed


def measure(
    scenario: Scenario,
    contenders: Sequence[Contender],
    *,
    duration_s: float,
    seed: int,
    capacity: int,
    steps: bool = False,
) -> Measured:
    """Run every contender through a scenario, all over one reading of the stream.

    Parameters
    ----------
    scenario : Scenario
        Arrivals, cost and latency bound.
    contenders : sequence of Contender
        Of different labels.
    duration_s : float
        Of the scenario.
    seed : int
        Of the gamma filters.
    capacity : int
        Of each ring, events.
    steps : bool
        Whether the rate steps up at the middle of every second, and down at its end.
    """
    found = side_by_side(
        CheckedStream(scenario.source),
        contenders,
        cost=scenario.cost,
        latency_ms=scenario.latency_ms,
        seed=seed,
        capacity=capacity,
        threads=1,  # cases run beside each other
    )
    return Measured(
        events=found.runs[0].ledger.received,
        oracle=found.oracle,
        figures={
            one.label: _figures(run, found.oracle, found.opaque_oracle, duration_s, steps)
            for one, run in zip(contenders, found.runs, strict=True)
        },
        exact=found.exact,
    )


def _figures(
    run: Run, oracle: float, opaque_oracle: float, duration_s: float, steps: bool
) -> Figures:
    slots = run.slots
    assert slots is not None  # virtual time
    bound_us = run.latency_bound_us
    in_time = run.latency.within_bound
    up, down = _steps_ms(duration_s) if steps else ([], [])
    recoveries = [metrics.recovery_ms(slots, [step], _PHASE_MS, bound_us) for step in down]
    start = slots["latency_max_us"][slots["slot"] < 100]
    return Figures(
        score=in_time / max(oracle, 1.0),
        opaque_score=in_time / max(opaque_oracle, 1.0),
        in_time=run.in_time,
        kept=run.kept,
        p50_ms=run.latency.quantile(0.5) / 1e3,
        p99_ms=run.latency.quantile(0.99) / 1e3,
        max_ms=run.latency.max / 1e3,
        start_max_ms=float(start.max(initial=0.0)) / 1e3,
        gap_ms=(run.gap_us or 0) / 1e3,
        silence_ms=metrics.gap_ms(slots),
        overflow=run.ledger.overflow / max(run.ledger.received, 1),
        packages_per_s=run.packages.size / duration_s,
        cpu=min(float(run.packages["processing_us"].sum()) / (duration_s * 1e6), 1.0),
        settle_ms=metrics.settle_ms(slots, up, _PHASE_MS, bound_us) if up else None,
        recovery_ms=sum(recoveries) / len(recoveries) if recoveries else None,
        slowest_recovery_ms=max(recoveries, default=None),
    )


def _steps_ms(duration_s: float) -> tuple[list[int], list[int]]:
    """Return the times of the steps up and down whose phase is whole."""
    last = round(duration_s * 1e3) - _PHASE_MS
    return list(range(500, last + 1, 1000)), list(range(1000, last + 1, 1000))
