"""The schemes as Python sees them: what all share, Greedy with its cap and Asap2022.

The rules are tested natively.
"""

from __future__ import annotations

import inspect
import itertools

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


def test_greedy_has_no_cap_unless_asked():
    assert asap.Greedy().parameters == {"efficiency": None}
    assert asap.Greedy(efficiency=None).parameters == {"efficiency": None}
    assert asap.Greedy(efficiency=0.97).parameters == {"efficiency": 0.97}
    assert repr(asap.Greedy()) == "Greedy(efficiency=None)"
    assert repr(asap.Greedy(efficiency=0.5)) == "Greedy(efficiency=0.5)"
    with pytest.raises(ValueError, match=r"^efficiency = 1: "):
        asap.Greedy(efficiency=1)
    with pytest.raises(TypeError):
        asap.Greedy(0.97)


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
    for scheme, opaque in itertools.product(schemes, (False, True)):
        for cost in (asap.LinearCost(0, 0), asap.LinearCost(1e9, 1e9)):
            done = asap.simulate(one_stamp, cost=cost, scheme=scheme, opaque=opaque, capacity=4096)
            for column in done.packages.dtype.names:
                assert np.isfinite(done.packages[column]).all(), (scheme, column)
            assert ((done.packages["gamma"] > 0) & (done.packages["gamma"] <= 1)).all()
            assert done.ledger.balanced
