"""CostCase: what a consumer costs on this machine, and the baselines that suit it.

Tasks of this kind run one at a time: a neighbour would be measured too.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from asap_laboratory.ladder.rungs import RUNGS, SLOWDOWN, stream
from asap_laboratory.ladder.settings import tried
from asap_laboratory.page import Rows

_SIZES = (1, 10, 100, 1000, 10_000)
_TIME_FOR_A_SIZE_NS = 40_000_000
_TUNED_OVER_US = 100_000


@dataclass(frozen=True)
class CostCase:
    """Measure one consumer, then try the baselines on it in virtual time, on the first 100 ms."""

    rung: str
    size: str = "whole"

    def weight(self) -> float:
        """Events to be processed, about."""
        return 1e7

    def measure(self) -> Rows:
        """Run it."""
        rung = RUNGS[self.rung]
        scene = stream(self.size, 0)
        alpha_us, beta_ns = rung.stated or measured(
            rung.make(scene.width, scene.height), scene.events
        )
        begin = scene.events[: np.searchsorted(scene.events["t"], _TUNED_OVER_US)]
        found = tried(begin, alpha_us * SLOWDOWN, beta_ns * SLOWDOWN)
        cost = {"kind": "cost", "rung": self.rung, "alpha_us": alpha_us, "beta_ns": beta_ns}
        return [cost, *({"kind": "tried", "rung": self.rung, **row} for row in found)]


def measured(algorithm: Any, events: NDArray[np.void]) -> tuple[float, float]:
    """Time packages of the second half of a stream; return alpha in us and beta in ns.

    On a surface that is still empty a corner detector costs a third of what it does later.
    """
    warm_up = events.size // 2
    begin = events.size  # the first package begins a round
    times_us = []
    for size in _SIZES:
        spent_ns = 0
        taken_ns: list[int] = []
        while (spent_ns < _TIME_FOR_A_SIZE_NS and len(taken_ns) < 100) or len(taken_ns) < 3:
            if begin + size > events.size:
                algorithm.reset()
                algorithm.process(events[:warm_up])
                begin = warm_up
            package = events[begin : begin + size]
            begin += size
            start_ns = time.perf_counter_ns()
            algorithm.process(package)
            taken_ns.append(time.perf_counter_ns() - start_ns)
            spent_ns += taken_ns[-1]
        times_us.append(float(np.quantile(taken_ns, 0.25)) / 1e3)
    return fit(_SIZES, times_us)


def fit(sizes: Sequence[int], times_us: Sequence[float]) -> tuple[float, float]:
    """Fit alpha in us and beta in ns, neither below zero, to the times of packages.

    Relative errors count: a package of one event says what a package costs, a large one what an
    event does.
    """
    weights = 1 / np.array(times_us)
    table = np.stack([np.ones(len(sizes)), np.array(sizes, float)], axis=-1)
    alpha, beta = np.linalg.lstsq(table * weights[:, None], np.ones(len(sizes)), rcond=None)[0]
    if alpha < 0:
        per_event = table[:, 1] * weights
        alpha, beta = 0.0, per_event.sum() / (per_event @ per_event)
    return float(alpha), max(0.0, float(beta)) * 1e3
