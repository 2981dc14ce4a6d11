"""What the algorithm of a run costs, as far as the run tells; and the bound that this rules out."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

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
