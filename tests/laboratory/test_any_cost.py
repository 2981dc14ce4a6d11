"""Bounds, costs and rates that nobody has named, drawn at random: `Deadline` keeps its promise.

A draw: L of 1 to 50 ms, a fixed cost of up to L / 20, 10 ns to 20 us an event, noise, a cost that
swings or jumps, a rate of up to ten times what the algorithm can do, in one of seven shapes. The
scheme is told nothing of it but L. ASAP_LONG_TESTS=1 draws 400.
"""

from __future__ import annotations

import os
from typing import NamedTuple

import numpy as np
import pytest

import asap
from asap_laboratory import profiles

LONG = bool(os.environ.get("ASAP_LONG_TESTS"))
MAX_EVENTS = 4e6 if LONG else 1e6
SHAPES = ("constant", "square", "on and off", "ramp", "spikes", "sine", "walk")


class Draw(NamedTuple):
    """A stream and an algorithm, L in ms, and whether the cost jumps by up to four times."""

    profile: profiles.Profile
    cost: asap.LinearCost
    latency_ms: float
    jumps: bool


def draw(seed):
    random = np.random.default_rng(seed)
    latency_ms = float(random.choice([1, 2, 5, 10, 20, 50]))
    alpha_us = latency_ms * 1e3 * 10 ** random.uniform(-4, -1.3)
    beta_ns = 10 ** random.uniform(1, 4.3)
    low, high = 10 ** random.uniform(-2, 0.2), 10 ** random.uniform(0, 1)  # of the capacity
    duration_s = max(20e-3 * latency_ms, min(1.0, MAX_EVENTS * beta_ns / 1e9 / high))
    beta_ns = max(beta_ns, 1e9 * high * duration_s / MAX_EVENTS)
    shape = str(random.choice(SHAPES))
    period_s = 10 ** random.uniform(-3, -0.3)
    walk = np.exp(np.cumsum(random.normal(0, 0.1, 11_000)))

    def rate(t):
        phase = (t / period_s) % 1
        of_the_capacity = {
            "constant": np.full(t.shape, high),
            "square": np.where(phase < 0.5, low, high),
            "on and off": np.where(phase < 0.5, 0, high),
            "ramp": low * (high / low) ** phase,
            "spikes": np.where(phase < 0.02, 5 * high, low),
            "sine": low + (high - low) * (1 + np.sin(2 * np.pi * phase)) / 2,
            "walk": walk[(t * 1e4).astype(int) % walk.size] / walk.mean(),
        }
        return np.clip(1e9 / beta_ns * of_the_capacity[shape], 0, 2e9)

    ms = np.arange(int(duration_s * 1e3) + 2)
    swings = 1 + 0.5 * np.sin(ms / random.uniform(5, 200))
    jumps = np.repeat(2 ** random.uniform(-1, 1, ms.size // 50 + 1), 50)
    kind = int(random.integers(3))
    noise = float(random.choice([0, 0, 0.05, 0.15]))
    return Draw(
        profiles.Profile(rate, duration_s=duration_s, seed=seed),
        asap.LinearCost(
            alpha_us, beta_ns, noise=noise, seed=seed, drift=[None, swings, jumps][kind]
        ),
        latency_ms,
        kind == 2,
    )


@pytest.mark.parametrize("execution", ["anytime", "whole"])
@pytest.mark.parametrize("seed", range(400 if LONG else 24))
def test_the_bound_is_kept_whatever_it_costs(seed, execution):
    profile, cost, latency_ms, jumps = draw(seed)
    run = asap.simulate(profile, cost=cost, latency_ms=latency_ms, execution=execution)
    received = run.ledger.received
    assert run.ledger.balanced
    assert run.ledger.pending == 0
    if received < 1000:
        return
    # Nothing stops a whole package whose events become up to four times as dear.
    latest = 1.2 if execution == "anytime" else 1.15 if not jumps else 1.7
    assert run.latency.max <= latest * 1e3 * latency_ms
    if not (execution == "whole" and jumps):
        assert run.latency.quantile(0.99) <= 1.05e3 * latency_ms
    if received > 20_000:
        best = asap.oracle(profile, cost=cost, latency_ms=latency_ms, execution=execution)
        assert run.in_time * received > (0.5 if execution == "whole" else 0.75) * best
