"""The cost models of the comparison: simulated algorithms, and the latency asked of each."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from asap import _checks, _core
from asap_laboratory.profiles.profile import Profile
from asap_laboratory.profiles.rates import FURTHER, PROFILES, Draws, Floats, portable


class CostModel(NamedTuple):
    """A simulated algorithm and the latency that is asked of it."""

    alpha_us: float  #: per package
    beta_ns: float  #: per event
    noise: float  #: sigma of the logarithm
    latency_ms: float  #: the bound
    drifts: bool = False  #: beta changes in time
    fails: bool = False  #: outages


COSTS = {
    "fast": CostModel(alpha_us=20.0, beta_ns=20.0, noise=0.05, latency_ms=2.0),
    "slow": CostModel(alpha_us=100.0, beta_ns=300.0, noise=0.05, latency_ms=10.0),
    "slow_tv": CostModel(100.0, 300.0, noise=0.10, latency_ms=10.0, drifts=True),
    "slow_ht": CostModel(100.0, 300.0, noise=0.50, latency_ms=10.0, fails=True),
}
LATENCY_MS = {name: model.latency_ms for name, model in COSTS.items()}


def cost(name: str, *, seed: int = 1, duration_s: float = 5.0) -> _core.LinearCost:
    """Return one of `COSTS` as a simulated algorithm for a run of that length.

    Parameters
    ----------
    name : str
        fast, slow, slow_tv (beta drifts) or slow_ht (heavy tail: costs scatter, with outages).
    seed : int
        0 or more; the costs' own seed is 100 more, so that they are not those of the arrivals.
    duration_s : float
        How long the drift is tabled and outages are drawn; afterwards beta stays as it is.

    Raises
    ------
    ValueError
        There is no such name.
    """
    _checks.choice("name", name, COSTS)
    _checks.whole("seed", seed, 0, 2**64 - 101, "give 0 or more, and below 2**64 - 100")
    model = COSTS[name]
    return _core.LinearCost(
        model.alpha_us,
        model.beta_ns,
        noise=model.noise,
        seed=100 + seed,
        drift=drift(duration_s) if model.drifts else None,
        outages_ms=outages_ms(duration_s, seed=100 + seed) if model.fails else None,
    )


def drift(duration_s: float) -> Floats:
    """Factors on beta of slow_tv, one per ms: a sine of period 1 s, times 1.5 from 2.75 s on."""
    duration_s = _checked_duration(duration_s)
    t = np.arange(math.ceil(duration_s * 1e3)) * 1e-3
    return portable((1.0 + 0.5 * np.sin(2.0 * np.pi * t)) * np.where(t > 2.75, 1.5, 1.0))


def outages_ms(duration_s: float, *, seed: int) -> Floats:
    """Outages of slow_ht: 10 per second at random, Pareto of shape 1.5 from 1 ms to 30 ms.

    Shape (n, 2), begin and end in ms; one that would overlap the one before is put off to its end.
    """
    duration_s = _checked_duration(duration_s)
    _checks.whole("seed", seed, 0, 2**64 - 1, "give 0 or more, and below 2**64")
    draws = Draws(seed)
    mean_gap_ms, begin_ms, free_ms = 100.0, 0.0, 0.0
    outages: list[tuple[float, float]] = []
    while True:
        gaps = draws.exponential(mean_gap_ms, 64)
        durations = np.minimum((1.0 - draws.uniform(64)) ** (-1.0 / 1.5), 30.0)
        for gap, duration in zip(np.round(gaps, 6), np.round(durations, 6), strict=True):  # to ns
            begin_ms += gap
            if begin_ms >= duration_s * 1e3:
                return np.array(outages, np.float64).reshape(-1, 2)
            late_ms = max(begin_ms, free_ms)
            free_ms = late_ms + duration
            outages.append((late_ms, free_ms))


def _checked_duration(duration_s: float) -> float:
    return _checks.number("duration_s", duration_s, 0, 86_400, "give 0 to 86400 s")


class Scenario(NamedTuple):
    """What a scheme is put to: the arguments of ``asap.simulate``."""

    source: Profile
    cost: _core.LinearCost
    latency_ms: float


def scenario(profile: str, cost_model: str, *, seed: int = 1, **parameters: Any) -> Scenario:
    """Return a named profile and cost model as the comparison pairs them.

    Parameters
    ----------
    profile, cost_model : str
        Names of `PROFILES` and `COSTS`.
    seed : int
        Of arrivals and costs; the comparison takes 1, 2 and 3.
    **parameters
        Of `Profile`, instead of the comparison's: 5 s, but 2 s for those of `FURTHER`, whose rates
        are scaled by 15 where the cost model is "fast".
    """
    _checks.choice("profile", profile, PROFILES)
    _checks.choice("cost_model", cost_model, COSTS)
    further = profile in FURTHER
    source = Profile(
        profile,
        **{
            "duration_s": 2.0 if further else 5.0,
            "scale": 15.0 if further and cost_model == "fast" else 1.0,
            "seed": seed,
            **parameters,
        },
    )
    simulated = cost(cost_model, seed=seed, duration_s=source.duration_s)
    return Scenario(source, simulated, LATENCY_MS[cost_model])
