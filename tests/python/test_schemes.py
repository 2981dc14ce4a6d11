"""The schemes as Python sees them; their laws are tested natively."""

from __future__ import annotations

import inspect
import itertools
import re

import numpy as np
import pytest

import asap
import streams
from asap import _core

COST = asap.LinearCost(alpha_us=100, beta_ns=300)


every_scheme = pytest.mark.parametrize("kind", _core.SCHEMES, ids=lambda kind: kind.__name__)


@every_scheme
def test_the_signature_has_the_parameters_and_their_defaults(kind):
    arguments = inspect.signature(kind).parameters.values()
    assert {one.name: one.default for one in arguments} == kind().parameters
    assert all(one.kind is one.KEYWORD_ONLY for one in arguments)
    assert kind(**kind().parameters).parameters == kind().parameters


def test_equal_limits_and_no_processing_time_are_refused_or_finite():
    """In the reference implementation atan(kappa log(t)) of them is NaN, cast to a size."""
    with pytest.raises(ValueError, match=r"^max_processing_ms = 3"):
        asap.Asap2022(min_processing_ms=3, max_processing_ms=3)
    with pytest.raises(ValueError, match=r"^min_processing_ms = 0"):
        asap.Asap2022(min_processing_ms=0)
    with pytest.raises(ValueError, match=r"^max_processing_ms = -2"):
        asap.Asap2022(max_processing_ms=-2)
    schemes = (
        asap.Asap2022(min_size=500, max_size=500, min_gamma=0.5, max_gamma=0.5),
        asap.Asap2022(min_gamma=0),
        asap.Asap2020(),
        asap.Deadline(),
        asap.DeadBeat(),
    )
    one_stamp = streams.make(np.zeros(700_000, np.int64))
    for scheme, execution in itertools.product(schemes, ("anytime", "whole")):
        for cost in (asap.LinearCost(0, 0), asap.LinearCost(1e9, 1e9)):
            done = asap.simulate(
                one_stamp, cost=cost, scheme=scheme, execution=execution, capacity=4096
            )
            for column in done.packages.dtype.names:
                assert np.isfinite(done.packages[column]).all(), (scheme, column)
            assert ((done.packages["gamma"] > 0) & (done.packages["gamma"] <= 1)).all()
            assert done.ledger.balanced


def test_a_preference_is_named_and_a_near_name_is_found():
    message = 'prefer = "speed": must be "balanced", "events" or "continuity"'
    with pytest.raises(ValueError, match=re.escape(message)):
        asap.Deadline(prefer="speed")
    with pytest.raises(TypeError, match=r"^preffer = 5: .*did you mean prefer\?"):
        asap.Deadline(preffer=5)


@pytest.mark.parametrize("execution", ["anytime", "whole"])
def test_continuity_makes_shorter_gaps_and_events_keeps_more(execution):
    """Load 3, the bound is 20 fixed costs."""
    events = streams.poisson(6e4, 0.5)
    cost = asap.LinearCost(alpha_us=500, beta_ns=50_000)
    runs = {
        prefer: asap.simulate(
            events, cost=cost, execution=execution, scheme=asap.Deadline(overhead=0, prefer=prefer)
        )
        for prefer in ("continuity", "balanced", "events")
    }
    gaps = [run.gap_us for run in runs.values()]
    kept = [run.latency.within_bound for run in runs.values()]
    assert gaps[0] < min(gaps[1:])
    assert kept[0] < kept[2]


@pytest.mark.parametrize(("asked", "got"), [(None, 10.0), (3, 3.0)])
def test_simulate_and_run_take_it_when_nothing_else_is_said(asked, got):
    events = streams.poisson(1e4, 0.05)
    for run in (
        asap.simulate(events, cost=COST, latency_ms=asked),
        asap.run(events, algorithm=lambda events: None, latency_ms=asked),
    ):
        assert type(run.scheme) is asap.Deadline
        assert run.scheme.parameters == asap.Deadline(latency_ms=got).parameters
        assert run.latency_bound_us == 1e3 * got


@pytest.mark.parametrize("make", [asap.Deadline, asap.DeadBeat])
def test_two_different_bounds_are_refused(make):
    events = streams.make([0, 1])
    differs = r"^latency_[mu]s = \d+: differs from the bound of the scheme; "
    with pytest.raises(ValueError, match=differs):
        asap.simulate(events, cost=COST, scheme=make(), latency_ms=5)
    with pytest.raises(ValueError, match=differs):
        asap.run(events, algorithm=len, scheme=make(latency_ms=5), latency_ms=10)
    assert asap.simulate(events, cost=COST, scheme=make(), latency_ms=10).kept == 1
