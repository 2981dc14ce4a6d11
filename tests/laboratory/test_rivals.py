"""The rivals of the benchmark in the simulator. Each rule is tested natively."""

from __future__ import annotations

import numpy as np
import pytest

import asap
import streams
from asap_laboratory import baselines

LATENCY_MS = 10.0
COST = asap.LinearCost(alpha_us=100, beta_ns=300, noise=0.3, seed=5)


def test_each_is_a_scheme_with_a_bound_of_its_own_and_loses_events_in_its_own_way() -> None:
    """At three times what the algorithm can do."""
    events = streams.make(np.arange(500_000) // 10)
    made = baselines(LATENCY_MS, COST)
    found = asap.compare(events, cost=COST, schemes=made, latency_ms=LATENCY_MS)
    lost = {
        label: {line for line in ("discarded", "stale") if run.ledger[line]}
        for label, run in found.runs.items()
    }
    assert all(run.ledger.balanced for run in found.runs.values())
    assert {label: lost[label] for label in ("jAER timer", "greedy+clear", "Spark PID")} == {
        "jAER timer": {"stale"},
        "greedy+clear": {"stale"},
        "Spark PID": {"discarded"},
    }
    for scheme in map(baselines(LATENCY_MS, COST).get, ("jAER timer", "greedy+clear", "Spark PID")):
        with pytest.raises(ValueError, match=r"^latency_ms = 5: "):
            asap.simulate(events[:1], cost=COST, scheme=scheme, latency_ms=5)
