"""Probes: measurements for single goals that no table holds.

`SteadyProbe` compares the mean latency at a constant rate with theory (notebooks/theory.md, T3);
`CapProbe` a capped greedy scheme with the clairvoyant optimum after a step (T4).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from asap import _core
from asap.experiment import simulate
from asap.profiles import COSTS, Profile, scenario

__all__ = ["CapProbe", "Steady", "SteadyProbe", "Window", "mean_latency_us", "probes"]


@dataclass(frozen=True)
class Steady:
    """What a `SteadyProbe` has found."""

    mean_us: float
    theory_us: float
    kept: float


@dataclass(frozen=True)
class SteadyProbe:
    """Deadline without a limit on the overhead, at a constant rate below what fills the time."""

    cost_model: str
    rate_hz: float
    seed: int = 1
    duration_s: float = 1.0

    @property
    def name(self) -> str:
        """How it is called on the screen."""
        return f"{self.cost_model} at {self.rate_hz / 1e6:g} Mev/s"

    def weight(self) -> float:
        """Events to be simulated."""
        return self.rate_hz * self.duration_s

    def measure(self) -> Steady:
        """Run it."""
        model = COSTS[self.cost_model]
        run = simulate(
            Profile(lambda t: self.rate_hz, noise=0.0, seed=self.seed, duration_s=self.duration_s),
            cost=_core.LinearCost(model.alpha_us, model.beta_ns),
            scheme=_core.Deadline(latency_ms=model.latency_ms, overhead=0.0),
        )
        theory_us = mean_latency_us(model.alpha_us, model.beta_ns, self.rate_hz)
        return Steady(run.latency.mean, theory_us, run.kept)


@dataclass(frozen=True)
class Window:
    """What a `CapProbe` has found: the largest latencies of one window, us."""

    greedy_us: float
    capped_us: float
    optimum_us: float


@dataclass(frozen=True)
class CapProbe:
    """The step of fast/steps60, 0.40 to 0.52 s, and the draining of what it leaves behind."""

    seed: int = 1

    @property
    def name(self) -> str:
        """How it is called on the screen."""
        return "fast/steps60, 0.40-0.52 s"

    def weight(self) -> float:
        """Events to be simulated; the optimum is dearer than a run."""
        return 3e7

    def measure(self) -> Window:
        """Run it."""
        source = scenario("steps60", "fast", seed=self.seed, duration_s=0.52).source
        events = source.events()
        events = events[events["t"] >= 400_000]
        cost = _core.LinearCost(COSTS["fast"].alpha_us, COSTS["fast"].beta_ns)
        greedy, capped = (
            simulate(events, cost=cost, scheme=_core.Greedy(efficiency=efficiency)).latency.max
            for efficiency in (None, 0.97)
        )
        return Window(greedy, capped, _core.clairvoyant_latency_us(events, cost))


def mean_latency_us(alpha_us: float, beta_ns: float, rate_hz: float) -> float:
    """Mean latency of greedy packages with Poisson arrivals, us (notebooks/theory.md, T3).

    Exact if the server never idles, else an upper bound. The load must be below 1.
    """
    rho = beta_ns * 1e-9 * rate_hz
    return 1.5 * alpha_us / (1 - rho) + beta_ns / 2e3 * (rho + 2) / (1 - rho**2)


_RATES_HZ = {"slow": (0.1e6, 1e6, 2e6), "fast": (1e6, 10e6, 30e6)}


def probes(form: str) -> Iterator[SteadyProbe | CapProbe]:
    """Yield the probes of a form of the study."""
    for seed in (1, 2, 3) if form != "quick" else (1,):
        yield CapProbe(seed)
        for model, rates_hz in _RATES_HZ.items():
            for rate_hz in rates_hz:
                yield SteadyProbe(model, rate_hz, seed)
