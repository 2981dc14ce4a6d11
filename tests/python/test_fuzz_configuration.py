"""Any configuration: a bad one is refused by its field, a good one never gives NaN or infinity.

R24 of the reliability goals: 100,000 random configurations, spread over the schemes. The ranges
below are the documented ones, written down a second time.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import asap
import streams
from fuzzing import TIMES

CONFIGURATIONS = 100_000  # built
RUNS = 250 if TIMES == 1 else CONFIGURATIONS // 8  # simulated, per scheme
NAN, INFINITY = float("nan"), float("inf")

Rng = np.random.Generator
Config = dict[str, Any]


@dataclass(frozen=True)
class Real:
    """A number from low to high; `open` ends do not belong to it, and `also` does."""

    low: float
    high: float
    open: str = ""  # "low", "high", "both"
    also: tuple[float, ...] = ()

    def good(self, rng: Rng) -> float:
        kind = rng.integers(10)
        if kind == 0 and self.also:
            return float(rng.choice(self.also))
        if kind < 3:
            return float(rng.choice(self.edges()))
        if kind < 7:
            most = min(self.high, 1e12)
            least = max(self.low, 1e-9 * most)
            return float(np.clip(least * (most / least) ** rng.random(), *self.edges()))
        return float(np.clip(self.low + rng.random() * (self.high - self.low), *self.edges()))

    def edges(self) -> tuple[float, float]:
        low = math.nextafter(self.low, INFINITY) if self.open in ("low", "both") else self.low
        high = math.nextafter(self.high, -INFINITY) if self.open in ("high", "both") else self.high
        return low, high

    def bad(self, rng: Rng) -> float:
        low, high = self.edges()
        beside = (math.nextafter(low, -INFINITY), math.nextafter(high, INFINITY))
        values = (NAN, INFINITY, -INFINITY, -1e308, 1e308, -1.0, *beside)
        return float(rng.choice([x for x in values if not low <= x <= high and x not in self.also]))


class Time(Real):
    """A time in ms from low to high, which the library keeps in whole nanoseconds."""

    def good(self, rng: Rng) -> float:
        return round(super().good(rng) * 1e6) / 1e6

    def bad(self, rng: Rng) -> float:
        beside = (self.low - 1e-6, self.high * (1 + 1e-9))
        return float(rng.choice([NAN, INFINITY, -INFINITY, -1e308, 1e308, -1.0, *beside]))


@dataclass(frozen=True)
class Whole:
    """A whole number from low to high."""

    low: int
    high: int

    def good(self, rng: Rng) -> int:
        if rng.integers(5) == 0:
            return (self.low, self.high)[rng.integers(2)]
        return min(self.low + int(2 ** (rng.random() * math.log2(self.high + 1))) - 1, self.high)

    def bad(self, rng: Rng) -> int:
        return (self.low - 1, -1, self.high + 1, 2**64, -(2**70))[rng.integers(5)]


@dataclass(frozen=True)
class Subject:
    """What is configured, the ranges of its fields, and which of them depend on each other."""

    make: Callable[..., Any]
    fields: dict[str, Any]
    ordered: tuple[tuple[str, ...], ...] = ()  # fields in rising order

    def good(self, rng: Rng) -> Config:
        config = {name: kind.good(rng) for name, kind in self.fields.items() if rng.integers(3)}
        for names in self.ordered:
            values = sorted(self.fields[name].good(rng) for name in names)
            config.update(zip(names, values, strict=True))
        return config


LATENCY = Time(0.01, 1e7)
SHARE = Real(0.0, 1.0)
KNEE = Real(1.0, 1e6, also=(0.0,))
INTERVAL = Time(0.0, 1e7)
SIZE = Whole(1, 2**40)
HALF_A_DAY = Time(1e-6, 1e9)

SUBJECTS = {
    "FixedSize": Subject(asap.FixedSize, {"size": SIZE}),
    "FixedTime": Subject(asap.FixedTime, {"period_ms": Time(0.001, 1e9)}),
    "Greedy": Subject(asap.Greedy, {"efficiency": Real(0.0, 1.0, open="both")}),
    "Asap2020": Subject(
        asap.Asap2020,
        {
            "rate_bound": Real(0.0, sys.float_info.max, open="low"),
            "epsilon": Real(0.0, 1.0, open="high"),
            "min_size": SIZE,
            "first_size": SIZE,
            "max_size": SIZE,
        },
        ordered=(("min_size", "first_size", "max_size"),),
    ),
    "Asap2022": Subject(
        asap.Asap2022,
        {
            "min_processing_ms": HALF_A_DAY,
            "max_processing_ms": HALF_A_DAY,
            "min_size": SIZE,
            "max_size": SIZE,
            "min_gamma": SHARE,
            "max_gamma": SHARE,
            "first_size": SIZE,
        },
        ordered=(
            ("min_processing_ms", "max_processing_ms"),
            ("min_size", "max_size"),
            ("min_gamma", "max_gamma"),
        ),
    ),
    "Deadline": Subject(
        asap.Deadline,
        {
            "latency_ms": LATENCY,
            "overhead": SHARE,
            "min_interval_ms": INTERVAL,
            "first_alpha_us": Real(0.001, 1e9),
            "first_beta_ns": Real(0.001, 1e9),
        },
    ),
    "DeadBeat": Subject(
        asap.DeadBeat,
        {"latency_ms": LATENCY, "knee": KNEE, "overhead": SHARE, "min_interval_ms": INTERVAL},
    ),
    "LinearCost": Subject(
        lambda alpha_us=100.0, beta_ns=300.0, **more: asap.LinearCost(alpha_us, beta_ns, **more),
        {
            "alpha_us": Real(0.0, 1e9),
            "beta_ns": Real(0.0, 1e9),
            "noise": Real(0.0, 5.0),
            "seed": Whole(0, 2**64 - 1),
        },
    ),
}
SCHEMES = [name for name in SUBJECTS if name != "LinearCost"]


def is_degenerate(config: Config) -> bool:
    """Equal limits, which Asap2022 refuses as there is no law between them."""
    least, longest = (config.get(f"{side}_processing_ms", 0.0) for side in ("min", "max"))
    return bool(longest and longest < least * (1 + 1e-6)) or config.get("max_gamma") == 0.0


def good_configurations(subject: Subject, count: int, seed: int) -> Iterator[Config]:
    rng = np.random.default_rng(seed)
    while count > 0:
        config = subject.good(rng)
        if not is_degenerate(config):
            count -= 1
            yield config


@pytest.mark.parametrize("name", SUBJECTS)
def test_good_configurations_are_taken_and_bad_ones_refused_by_name(name: str) -> None:
    subject = SUBJECTS[name]
    rng = np.random.default_rng(1)
    for config in good_configurations(subject, CONFIGURATIONS // len(SUBJECTS) // 2, seed=2):
        made = subject.make(**config)
        if name != "LinearCost":
            assert {key: made.parameters[key] for key in config} == config
        field = str(rng.choice(list(subject.fields)))
        value = subject.fields[field].bad(rng)
        with pytest.raises(ValueError, match=" = ") as refused:
            subject.make(**{**config, field: value})
        named = str(refused.value).partition(" = ")[0]
        # A limit that is out of range is one beyond which the other limit lies.
        assert named in {
            field,
            *(other for group in subject.ordered if field in group for other in group),
        }
        assert len(str(refused.value).partition(": ")[2]) > 10


def a_stream(rng: Rng) -> Any:
    """A few hundred events: bursts on one stamp, steady times, silences."""
    gaps = rng.choice((0, 1, 20, 5000), int(rng.integers(1, 300)), p=(0.4, 0.4, 0.18, 0.02))
    return streams.make(int(rng.choice((0, -(2**40), 2**50))) + np.cumsum(gaps))


def check_run(run: Any) -> None:
    """Every number is finite, nothing is negative, and the ledger is balanced."""
    packages = run.packages
    for column in packages.dtype.names:
        assert np.isfinite(packages[column]).all(), column
    for column in ("processing_us", "offered", "size", "event_rate", "rate", "stale", "overflow"):
        assert (packages[column] >= 0).all(), column
    assert ((packages["gamma"] > 0) & (packages["gamma"] <= 1)).all()
    assert (packages["offered"] >= packages["size"]).all()
    assert run.ledger.balanced
    assert run.ledger.pending == 0
    assert packages["size"].sum() == run.ledger.delivered == run.latency.count
    numbers = [run.kept, run.in_time, *(run.summary()["latency_us"].values())]
    assert all(math.isfinite(number) and number >= 0 for number in numbers)
    if run.learned is not None:
        assert 0 < run.learned.alpha_us < INFINITY
        assert 0 < run.learned.beta_ns < INFINITY


@pytest.mark.parametrize("name", [*SCHEMES, "SingleEvent"])
def test_good_configurations_give_finite_numbers(name: str) -> None:
    rng = np.random.default_rng(3)
    subject = SUBJECTS.get(name, Subject(asap.SingleEvent, {}))
    costs = good_configurations(SUBJECTS["LinearCost"], RUNS, seed=4)
    for config, cost in zip(good_configurations(subject, RUNS, seed=5), costs, strict=True):
        run = asap.simulate(
            a_stream(rng),
            cost=SUBJECTS["LinearCost"].make(**cost),
            scheme=subject.make(**config),
            execution=str(rng.choice(["anytime", "whole"])),
            seed=int(rng.integers(2**63)),
            capacity=int(rng.choice((1, 2, 31, 256, 1000))),
        )
        check_run(run)
