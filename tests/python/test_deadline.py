"""Deadline and DeadBeat as Python sees them. The laws are tested natively."""

from __future__ import annotations

import re

import pytest

import asap
import streams

COST = asap.LinearCost(alpha_us=100, beta_ns=300)

DEADLINE = {
    "latency_ms": 10.0,
    "overhead": 0.5,
    "min_interval_ms": 0.0,
    "first_alpha_us": 50.0,
    "first_beta_ns": 100.0,
    "prefer": "balanced",
}
DEAD_BEAT = {"latency_ms": 10.0, "knee": 33.0, "overhead": 0.25, "min_interval_ms": 0.0}

both = pytest.mark.parametrize(
    ("make", "name", "defaults"),
    [(asap.Deadline, "deadline", DEADLINE), (asap.DeadBeat, "dead_beat", DEAD_BEAT)],
    ids=["Deadline", "DeadBeat"],
)


def test_a_preference_is_named_and_a_near_name_is_found():
    message = 'prefer = "speed": must be "balanced", "events" or "continuity"'
    with pytest.raises(ValueError, match=re.escape(message)):
        asap.Deadline(prefer="speed")
    with pytest.raises(TypeError, match=r"^preffer = 5: .*did you mean prefer\?"):
        asap.Deadline(preffer=5)


@pytest.mark.parametrize("opaque", [False, True])
def test_continuity_makes_shorter_gaps_and_events_keeps_more(opaque):
    """Load 3, the bound is 20 fixed costs."""
    events = streams.poisson(6e4, 0.5)
    cost = asap.LinearCost(alpha_us=500, beta_ns=50_000)
    runs = {
        prefer: asap.simulate(
            events, cost=cost, opaque=opaque, scheme=asap.Deadline(overhead=0, prefer=prefer)
        )
        for prefer in ("continuity", "balanced", "events")
    }
    gaps = [run.gap_us for run in runs.values()]
    kept = [run.latency.within_bound for run in runs.values()]
    assert gaps[0] < min(gaps[1:])
    assert kept[0] < kept[2]


# ---- the default -----------------------------------------------------------------------------


@pytest.mark.parametrize(("asked", "got"), [(None, 10.0), (3, 3.0)])
def test_simulate_and_run_take_it_when_nothing_else_is_said(asked, got):
    events = streams.poisson(1e4, 0.05)
    for run in (
        asap.simulate(events, cost=COST, latency_ms=asked),
        asap.run(events, algorithm=lambda events: None, latency_ms=asked),
    ):
        assert run.scheme.name == "deadline"
        assert run.scheme.parameters == {**DEADLINE, "latency_ms": got}
        assert run.latency_bound_us == 1e3 * got


# ---- the bound -------------------------------------------------------------------------------


@both
def test_two_different_bounds_are_refused(make, name, defaults):
    events = streams.make([0, 1])
    differs = r"^latency_[mu]s = \d+: differs from the bound of the scheme; "
    with pytest.raises(ValueError, match=differs):
        asap.simulate(events, cost=COST, scheme=make(), latency_ms=5)
    with pytest.raises(ValueError, match=differs):
        asap.run(events, algorithm=len, scheme=make(latency_ms=5), latency_ms=10)
    assert asap.simulate(events, cost=COST, scheme=make(), latency_ms=10).kept == 1
