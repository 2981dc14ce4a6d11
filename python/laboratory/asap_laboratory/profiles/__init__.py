"""Arrival profiles and cost models: the scenarios in which the schemes are compared.

A profile is an event rate over time, made into real events natively while it is read: seeded, in
flat memory, of any length, faster than real time up to some hundred million events per second. Your
own profile is one line::

    asap_laboratory.profiles.Profile(lambda t: 1e6 + 9e6 * (t % 0.1 < 0.01), duration_s=20)

A cost model is the simulated algorithm that has to keep up. `scenario` pairs one of each as in the
comparison: `PROFILES` and `COSTS` name them.
"""

from asap_laboratory.profiles.costs import (
    COSTS,
    LATENCY_MS,
    CostModel,
    Scenario,
    cost,
    drift,
    outages_ms,
    scenario,
)
from asap_laboratory.profiles.profile import Profile
from asap_laboratory.profiles.rates import FURTHER, PROFILES, RandomRate

__all__ = [
    "COSTS",
    "FURTHER",
    "LATENCY_MS",
    "PROFILES",
    "CostModel",
    "Profile",
    "RandomRate",
    "Scenario",
    "cost",
    "drift",
    "outages_ms",
    "scenario",
]
