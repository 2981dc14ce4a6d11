"""Scenario: a profile and a cost model, paired as the comparison of the schemes pairs them."""

from __future__ import annotations

from typing import Any, NamedTuple

from asap import _checks, _core
from asap.profiles.costs import COSTS, LATENCY_MS, cost
from asap.profiles.profile import Profile
from asap.profiles.rates import FURTHER, PROFILES


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
