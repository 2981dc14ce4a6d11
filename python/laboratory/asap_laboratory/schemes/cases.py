"""Case: a profile, a cost model, a seed and a window, and the contenders that go through it.

Three forms of the study choose cases. "default" takes the windows of the reference with one of its
three seeds: 5 s, 2 s for the further profiles. "full" takes all three seeds and the rows with
hindsight, and `FRESH` on twenty more seeds. "quick" takes a part of the cases in windows of 1 to
5 s; the rates of `uav` and `ramp`, which climb for 5 s, climb as far in a shorter window, and the
rise of beta in slow_tv at 2.75 s is beyond most of them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

from asap_laboratory.page import Rows
from asap_laboratory.profiles import FURTHER, PROFILES, Profile, Scenario, scenario
from asap_laboratory.schemes.contenders import HINDSIGHT, PRIORS, TABLE, contender
from asap_laboratory.schemes.measure import measure

NAMED = ("quiet", "low", "uav", "flicker", "steps", "bursts", "high", "ramp", "steps60")

FRESH_SEEDS = range(2000, 2020)
"""Seeds that chose nothing."""

FRESH = ("Deadline", "Deadline oh.5", "whole Deadline", "jAER timer")
"""Contenders that go through the cases of the fresh seeds."""

_CAPACITY = 1 << 20
_CLIMB_FOR_5_S = ("uav", "ramp")
_STEP = ("steps", "steps60")
_KEYS = ("cost_model", "profile", "seed", "duration_s")
_WITH_WRONG_PRIORS = ("high", "steps", "uav")

Pair: TypeAlias = tuple[str, str]


@dataclass(frozen=True)
class Case:
    """One stream for many contenders."""

    profile: str
    cost_model: str
    seed: int = 1
    duration_s: float = 5.0
    contenders: tuple[str, ...] = TABLE

    @property
    def is_further(self) -> bool:
        """Whether the profile is not one of the nine."""
        return self.profile in FURTHER

    def scenario(self) -> Scenario:
        """Arrivals, cost and latency bound."""
        parameters: dict[str, Any] = {"duration_s": self.duration_s}
        found = scenario(self.profile, self.cost_model, seed=self.seed, **parameters)
        if self.profile not in _CLIMB_FOR_5_S or self.duration_s == 5.0:
            return found
        climb: Any = PROFILES[self.profile]
        stretch = 5.0 / self.duration_s
        source = Profile(
            lambda t: climb(t * stretch), seed=self.seed, name=self.profile, **parameters
        )
        return found._replace(source=source)

    def weight(self) -> float:
        """Events to be simulated, about."""
        events = sum(float(rates.sum()) for rates in self.scenario().source.rates()) * 1e-4
        return events * len(self.contenders)

    def measure(self) -> Rows:
        """Run it."""
        what = {name: getattr(self, name) for name in _KEYS}
        found = measure(
            self.scenario(),
            [contender(label) for label in self.contenders],
            duration_s=self.duration_s,
            seed=self.seed,
            capacity=self.capacity(),
            steps=self.profile in _STEP,
        )
        return [{"kind": "run", **what, **row} for row in found]

    def capacity(self) -> int:
        """Ring of every contender, events: 2**20 as in the reference, more where L fills it."""
        scenario = self.scenario()
        highest_hz = max(float(rates.max()) for rates in scenario.source.rates())
        needed = 1.5 * highest_hz * scenario.latency_ms / 1e3  # the rate noise is on top of it
        return max(_CAPACITY, 1 << math.ceil(math.log2(needed))) if self.is_further else _CAPACITY


class _Form(NamedTuple):
    seeds: tuple[int, ...]
    contenders: tuple[str, ...]
    durations_s: dict[Pair, float]


_BEST = tuple(label for settings in HINDSIGHT.values() for label in settings)
_WHOLE: dict[Pair, float] = {
    **{(profile, "fast"): 5.0 for profile in NAMED},
    **{(profile, "slow"): 5.0 for profile in NAMED},
    **{
        (profile, model): 5.0
        for model in ("slow_tv", "slow_ht")
        for profile in NAMED
        if profile not in ("quiet", "steps60")
    },
    **{
        (profile, model): 2.0
        for profile in FURTHER
        for model in ("fast", "slow", "slow_tv", "slow_ht")
    },
}
_PART: dict[Pair, float] = {
    ("low", "fast"): 1.0,
    ("bursts", "fast"): 1.0,
    ("steps60", "fast"): 1.5,
    **{(profile, "slow"): 1.0 for profile in NAMED if profile not in ("steps", "steps60")},
    ("steps", "slow"): 1.5,
    ("steps", "slow_tv"): 1.0,
    ("bursts", "slow_tv"): 3.0,
    ("uav", "slow_tv"): 1.0,
    # Outages are rare: a short window says nothing about them.
    **{(profile, "slow_ht"): 5.0 for profile in ("low", "uav", "flicker", "steps", "bursts")},
    **{(profile, "slow_ht"): 2.0 for profile in ("high", "ramp")},
    ("spikes", "slow"): 1.0,
    ("telegraph", "slow"): 1.0,
    ("train", "slow"): 1.0,
    ("breath", "slow_tv"): 1.0,
    ("train", "fast"): 1.0,
}
_FORMS = {
    "quick": _Form((1,), TABLE, _PART),
    "default": _Form((1,), TABLE, _WHOLE),
    "full": _Form((1, 2, 3), TABLE + _BEST, _WHOLE),
}


def cases(form: str) -> Iterator[Case]:
    """Yield the cases of a form of the study."""
    seeds, contenders, durations_s = _FORMS[form]
    for seed in seeds:
        for (profile, model), duration_s in durations_s.items():
            with_wrong_priors = model == "slow" and profile in _WITH_WRONG_PRIORS
            extra = PRIORS if with_wrong_priors else ()
            yield Case(profile, model, seed, duration_s, contenders + extra)
    for seed in FRESH_SEEDS if form == "full" else ():
        for (profile, model), duration_s in durations_s.items():
            yield Case(profile, model, seed, duration_s, FRESH)
