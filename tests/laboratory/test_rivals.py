"""The rivals of the benchmark in the simulator. Each rule is tested natively."""

from __future__ import annotations

import numpy as np
import pytest

import asap
import streams
from asap_laboratory import _native, baselines

LATENCY_MS = 10.0
COST = asap.LinearCost(alpha_us=100, beta_ns=300, noise=0.3, seed=5)
RIVALS = {
    "jaer_timer": lambda: _native.JaerTimer(LATENCY_MS, COST),
    "greedy_clear": lambda: _native.GreedyClear(LATENCY_MS),
    "spark_pid": lambda: _native.SparkPid(LATENCY_MS),
}


def simulated(events, name):
    return asap.simulate(events, cost=COST, scheme=RIVALS[name](), capacity=2**20)


@pytest.fixture(scope="module")
def events():
    """0.3 s at 10 Mev/s, three times what the algorithm can do, between two quiet stretches."""
    quiet = np.arange(0, 50_000, 100)
    busy = 50_000 + np.arange(3_000_000) // 10
    return streams.make(np.concatenate([quiet, busy, 350_000 + quiet]))


@pytest.fixture(scope="module")
def runs(events):
    return {name: simulated(events, name) for name in RIVALS}


@pytest.mark.parametrize("name", RIVALS)
def test_is_a_scheme_with_a_bound_of_its_own(name, runs):
    scheme = RIVALS[name]()
    assert isinstance(scheme, asap.Scheme)
    assert scheme.name == name
    assert scheme.parameters == {"latency_ms": 10.0}
    assert not hasattr(asap, type(scheme).__name__)  # no product
    assert runs[name].summary()["latency_bound_us"] == 10_000
    with pytest.raises(ValueError, match=r"^latency_ms = 5: "):
        asap.simulate(streams.make([0]), cost=COST, scheme=scheme, latency_ms=5)


@pytest.mark.parametrize("name", RIVALS)
def test_books_every_event_and_repeats_itself(name, events, runs):
    run = runs[name]
    assert run.ledger.balanced
    assert run.ledger.pending == 0
    np.testing.assert_array_equal(simulated(events, name).packages, run.packages)


def test_each_loses_events_in_its_own_way(runs):
    lost = {
        name: {line for line in ("discarded", "stale", "overflow") if run.ledger[line]}
        for name, run in runs.items()
    }
    assert lost == {
        "jaer_timer": {"stale"},
        "greedy_clear": {"stale"},
        "spark_pid": {"discarded"},
    }


def test_compare_takes_the_published_schedulers(events):
    made = baselines(LATENCY_MS, COST)
    found = asap.compare(events[:20_000], cost=COST, schemes=made, latency_ms=LATENCY_MS)
    assert set(found) == {"SingleEvent", "jAER timer", "greedy+clear", "Spark PID"}
