"""Probes: measurements beside the tables of the profiles.

`SteadyProbe` compares the mean latency at a constant rate with theory (notebooks/theory.md, T3);
`CapProbe` a capped greedy scheme with the clairvoyant optimum after a step (T4); `FewProbe` schemes
with the exact clairvoyant where few packages fit into the bound.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from asap import _core
from asap.experiment import simulate
from asap.experiment.comparing import side_by_side
from asap.io.source import CheckedStream
from asap_laboratory import _native
from asap_laboratory.clairvoyant import exact_oracle
from asap_laboratory.page import Rows
from asap_laboratory.profiles import COSTS, Profile, scenario
from asap_laboratory.schemes.contenders import contender

BOUNDS = (100, 50, 20, 10, 5)
"""Latency bounds of the `FewProbe`, fixed costs."""


@dataclass(frozen=True)
class SteadyProbe:
    """Deadline without a limit on the overhead, at a constant rate below what fills the time."""

    cost_model: str
    rate_hz: float
    seed: int = 1
    duration_s: float = 1.0

    def weight(self) -> float:
        """Events to be simulated."""
        return self.rate_hz * self.duration_s

    def measure(self) -> Rows:
        """Run it."""
        model = COSTS[self.cost_model]
        run = simulate(
            Profile(lambda t: self.rate_hz, noise=0.0, seed=self.seed, duration_s=self.duration_s),
            cost=_core.LinearCost(model.alpha_us, model.beta_ns),
            scheme=_core.Deadline(latency_ms=model.latency_ms, overhead=0.0),
        )
        theory_us = mean_latency_us(model.alpha_us, model.beta_ns, self.rate_hz)
        excess = run.latency.mean / theory_us
        return [{"kind": "steady", "excess": excess, "kept": run.kept}]


@dataclass(frozen=True)
class CapProbe:
    """The step of fast/steps60, 0.40 to 0.52 s, and the draining of what it leaves behind."""

    seed: int = 1

    def weight(self) -> float:
        """Events to be simulated; the optimum is dearer than a run."""
        return 3e7

    def measure(self) -> Rows:
        """Run it."""
        source = scenario("steps60", "fast", seed=self.seed, duration_s=0.52).source
        events = source.events()
        events = events[events["t"] >= 400_000]
        cost = _core.LinearCost(COSTS["fast"].alpha_us, COSTS["fast"].beta_ns)
        greedy, capped = (
            simulate(events, cost=cost, scheme=_core.Greedy(efficiency=efficiency)).latency.max
            for efficiency in (None, 0.97)
        )
        optimum = _native.clairvoyant_latency_us(events, cost)
        return [{"kind": "cap", "greedy": greedy / optimum, "capped": capped / optimum}]


@dataclass(frozen=True)
class FewProbe:
    """Schemes beside the exact clairvoyant: L = 10 ms = `bound` alpha = 150 beta, 0.4 s."""

    bound: int
    arrivals: str
    seed: int = 1

    def weight(self) -> float:
        """Events to be simulated; the exact clairvoyant is dearer than a run."""
        return 1e6

    def measure(self) -> Rows:
        """Run it."""
        load, latency_ms = _ARRIVALS[self.arrivals], 10.0
        cost = _core.LinearCost(1e3 * latency_ms / self.bound, 1e6 * latency_ms / 150)
        rate_hz = 1e9 / cost.parameters["beta_ns"]
        profile = Profile(lambda t: rate_hz * load(t), noise=0.0, seed=self.seed, duration_s=0.4)
        found = side_by_side(
            CheckedStream(profile),
            [contender(label) for label in _FEW],
            cost=cost,
            latency_ms=latency_ms,
            seed=self.seed,
            threads=1,
        )
        exact = exact_oracle(profile, cost=cost, latency_ms=latency_ms)
        what = {"kind": "few", "bound": self.bound, "arrivals": self.arrivals, "seed": self.seed}
        shares = {"EC(L)/OB(L)": exact / found.oracles["anytime"]}
        for label, run in zip(_FEW, found.runs, strict=True):
            shares[label] = run.latency.within_bound / exact
        return [{**what, "contender": label, "share": share} for label, share in shares.items()]


def mean_latency_us(alpha_us: float, beta_ns: float, rate_hz: float) -> float:
    """Mean latency of greedy packages with Poisson arrivals, us (notebooks/theory.md, T3).

    Exact if the server never idles, else an upper bound. The load must be below 1.
    """
    rho = beta_ns * 1e-9 * rate_hz
    return 1.5 * alpha_us / (1 - rho) + beta_ns / 2e3 * (rho + 2) / (1 - rho**2)


_RATES_HZ = {"slow": (0.1e6, 1e6, 2e6), "fast": (1e6, 10e6, 30e6)}


_Load = Callable[[NDArray[np.float64]], NDArray[np.float64]]
_ARRIVALS: dict[str, _Load] = {
    "steady, load 1.1": lambda t: np.full_like(t, 1.1),
    "steady, load 1.5": lambda t: np.full_like(t, 1.5),
    "steady, load 3": lambda t: np.full_like(t, 3.0),
    "bursts of 5 ms, load 6": lambda t: np.where(t % 0.05 < 0.005, 6.0, 0.5),
    "on and off for 20 ms, load 2.5": lambda t: np.where(t % 0.04 < 0.02, 2.5, 0.2),
}
_FEW = ("Deadline", "DeadBeat", "whole Deadline", "whole DeadBeat")

Probe = SteadyProbe | CapProbe | FewProbe


def probes(form: str) -> Iterator[Probe]:
    """Yield the probes of a form of the study."""
    for seed in (1, 2, 3) if form != "quick" else (1,):
        yield CapProbe(seed)
        for bound in BOUNDS:
            for arrivals in _ARRIVALS:
                yield FewProbe(bound, arrivals, seed)
        for model, rates_hz in _RATES_HZ.items():
            for rate_hz in rates_hz:
                yield SteadyProbe(model, rate_hz, seed)
