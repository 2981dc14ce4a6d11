"""Where Greedy finishes every event within the bound, Deadline finishes as many, but for its start.

A NumPy function, a network or a rendered image costs a package much and an event next to nothing.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import asap
import streams

PREFERENCES = ("balanced", "events", "continuity")
START = 10  # packages


def greedy_and_deadline(events, *, latency_ms, execution, prefer="balanced", told=False, **cost):
    first = {f"first_{name}": cost[name] for name in ("alpha_us", "beta_ns") if told}
    cost = asap.LinearCost(**cost)
    return [
        asap.simulate(events, cost=cost, scheme=scheme, latency_ms=latency_ms, execution=execution)
        for scheme in (
            asap.Greedy(),
            asap.Deadline(latency_ms=latency_ms, prefer=prefer, **first),
        )
    ]


@st.composite
def scenes(draw):
    """Return events and a cost that leaves Greedy room, but for the noise."""
    alpha_us = 10 ** draw(st.floats(1.7, 4.7))
    load = draw(st.one_of(st.floats(1e-4, 0.05), st.floats(0.05, 0.5)))
    noise = draw(st.one_of(st.just(0.0), st.floats(0.02, 0.3)))
    rate_hz = min(10 ** draw(st.floats(0.5, 3.5)) / alpha_us * 1e6, 1e7)
    duration_s = min(300 * alpha_us * 1e-6, 4e5 / rate_hz)
    steps = [*draw(st.lists(st.sampled_from([0.1, 0.5, 1.0]), min_size=1, max_size=4)), 1.0]
    drift = draw(st.sampled_from([(), (1.0, 1.5, 0.7)]))
    part_s = duration_s / len(steps)
    parts = [
        streams.poisson(rate_hz * step, part_s, seed=draw(st.integers(0, 2**32))) for step in steps
    ]
    for i, part in enumerate(parts):
        part["t"] += round(1e6 * part_s * i)
    return np.concatenate(parts), {
        "latency_ms": draw(st.floats(2.6, 15)) * alpha_us / 1e3,
        "alpha_us": alpha_us,
        "beta_ns": load / rate_hz * 1e9,
        "noise": noise,
        "drift": drift,
        "seed": draw(st.integers(0, 2**32)),
    }


@settings(max_examples=60)
@given(scenes(), st.sampled_from(PREFERENCES), st.sampled_from(["anytime", "whole"]))
def test_deadline_finishes_what_greedy_finishes(scene, prefer, execution):
    events, setup = scene
    assume(len(events) > 200)
    greedy, deadline = greedy_and_deadline(events, prefer=prefer, execution=execution, **setup)
    assume(greedy.latency.max <= 0.9 * greedy.latency_bound_us)  # by more than luck
    lost = greedy.latency.within_bound - deadline.latency.within_bound
    assert lost <= START * greedy.packages["size"].max()


@pytest.mark.parametrize(
    ("per_alpha", "load", "told", "share"),
    [
        (2.6, 0.001, False, 0.975),
        (3.0, 0.1, False, 0.98),
        (4.0, 0.001, False, 0.985),
        (8.0, 0.1, False, 0.985),
        (2.2, 0.001, False, 0.92),
        (3.0, 0.1, True, 0.99),
        (4.0, 0.001, True, 0.995),
    ],
)
def test_a_flat_cost_loses_no_more_than_the_start(per_alpha, load, told, share):
    """600 packages of 5 ms, noise .1, 1 Mev/s."""
    events = streams.poisson(1e6, 3, seed=3)
    greedy, deadline = greedy_and_deadline(
        events,
        latency_ms=5 * per_alpha,
        execution="whole",
        told=told,
        alpha_us=5000,
        beta_ns=1000 * load,
        noise=0.1,
    )
    assert deadline.in_time >= share * greedy.in_time


def test_no_package_is_spent_on_a_fixed_cost_that_is_known():
    """Before, every sixteenth package was a single event where four alpha exceed the bound."""
    events = streams.poisson(1e6, 3, seed=4)
    _, run = greedy_and_deadline(
        events, latency_ms=15, execution="whole", alpha_us=5000, beta_ns=1, noise=0.1
    )
    assert not (run.packages["size"][20:] == 1).any()
