"""What a run is judged by: the quantities of the tables, from a run and the oracle.

How long a disturbance lasts is read from ``run.slots``, one row per 1 ms slot of the stamps that
holds an event. Source: notebooks/theory.md, section 10.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from asap.experiment import Run
from asap.experiment.comparing import Contender, side_by_side
from asap.io.source import CheckedStream
from asap_laboratory.page import Row, Rows
from asap_laboratory.profiles import Scenario

PHASE_MS = 500  #: of the profiles that step
_LATE = 1.1  # of the bound
_KEPT = 0.98
_LAST_MS = 4  # of a phase: too late to count as settled


def measure(
    scenario: Scenario,
    contenders: Sequence[Contender],
    *,
    duration_s: float,
    seed: int,
    capacity: int,
    steps: bool = False,
) -> Rows:
    """Run every contender through a scenario, all over one reading of the stream.

    `steps`: the rate steps up at the middle of every second, and down at its end. A row for each
    contender: label, the figures of `figures_of`, events of the input and OB(L).
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
    of_all = {"events": found.runs[0].ledger.received, "oracle": found.oracles["anytime"]}
    return [
        {
            "contender": one.label,
            **figures_of(run, found.oracles, duration_s, steps),
            **of_all,
        }
        for one, run in zip(contenders, found.runs, strict=True)
    ]


def figures_of(run: Run, oracles: Mapping[str, float], duration_s: float, steps: bool) -> Row:
    """Return one contender's figures in one scenario; latencies of delivered events, ms.

    The score is in-time events / OB(L), the whole one that against the oracle which takes a
    package as a whole; in_time, kept and overflow are shares of the input.
    """
    slots = run.slots
    assert slots is not None  # virtual time
    bound_us = run.latency_bound_us
    in_time = run.latency.within_bound
    up, down = _steps_ms(duration_s) if steps else ([], [])
    settling = settle_ms(slots, up, PHASE_MS, bound_us)
    recoveries = recovery_ms(slots, down, PHASE_MS, bound_us)
    start = slots["latency_max_us"][slots["slot"] < 100]
    return {
        "score": in_time / max(oracles["anytime"], 1.0),
        "whole_score": in_time / max(oracles["whole"], 1.0),
        "in_time": run.in_time,
        "kept": run.kept,
        "p50_ms": run.latency.quantile(0.5) / 1e3,
        "p99_ms": run.latency.quantile(0.99) / 1e3,
        "max_ms": run.latency.max / 1e3,
        "start_max_ms": float(start.max(initial=0.0)) / 1e3,  # of the first 100 ms
        "gap_ms": (run.gap_us or 0) / 1e3,  # between delivered events that lost one between
        "silence_ms": silence_ms(slots),
        "overflow": run.ledger.overflow / max(run.ledger.received, 1),
        "packages_per_s": run.packages.size / duration_s,
        "cpu": min(float(run.packages["processing_us"].sum()) / (duration_s * 1e6), 1.0),
        "settle_ms": float(np.mean(settling)) if settling else None,
        "slowest_recovery_ms": max(recoveries, default=None),
    }


def _steps_ms(duration_s: float) -> tuple[list[int], list[int]]:
    """Return the times of the steps up and down whose phase is whole."""
    last = round(duration_s * 1e3) - PHASE_MS
    return list(range(500, last + 1, 1000)), list(range(1000, last + 1, 1000))


def silence_ms(slots: NDArray[np.void], ignore_last: int = 60) -> int:
    """Longest run of slots with events of which none was delivered, ms; an empty slot ends it.

    The last 60 ms of the stamps do not count: their events may be on their way.
    """
    if slots.size == 0:
        return 0
    counted = slots["slot"] <= slots["slot"][-1] - ignore_last
    silent = slots["slot"][counted & (slots["delivered"] == 0)]
    begins = np.flatnonzero(np.diff(silent, prepend=silent[:1] - 2) != 1)
    return int(np.diff(begins, append=silent.size).max(initial=0))


def settle_ms(
    slots: NDArray[np.void], steps_ms: Sequence[int], phase_ms: int, bound_us: float
) -> list[int]:
    """Time from each step up to the end of the last slot of its phase that is later than 1.1 L.

    phase_ms - 4 (496 of 500): it never settled.
    """
    late = slots["latency_max_us"] > _LATE * bound_us
    return _disturbances_ms(slots["slot"][late], steps_ms, phase_ms)


def recovery_ms(
    slots: NDArray[np.void], steps_ms: Sequence[int], phase_ms: int, bound_us: float
) -> list[int]:
    """Time from each step down until nothing is late or lost any more: 98 % of each slot kept."""
    late = slots["latency_max_us"] > _LATE * bound_us
    lossy = slots["delivered"] < _KEPT * slots["received"]
    return _disturbances_ms(slots["slot"][late | lossy], steps_ms, phase_ms)


def _disturbances_ms(
    disturbed: NDArray[np.int64], steps_ms: Sequence[int], phase_ms: int
) -> list[int]:
    ends = []
    for step in steps_ms:
        inside = disturbed[(disturbed >= step) & (disturbed < step + phase_ms)]
        end = int(inside[-1]) + 1 - step if inside.size else 0
        ends.append(min(end, phase_ms - _LAST_MS))
    return ends
