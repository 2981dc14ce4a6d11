"""The schemes as Python sees them: what all share, Greedy with its cap and Asap2022.

The rules are tested natively.
"""

from __future__ import annotations

import inspect
import itertools
import json
import re

import numpy as np
import pytest

import asap
import scheme_texts
import streams
from asap import _core, cli
from asap.cli.algorithms import scheme_of

COST = asap.LinearCost(alpha_us=100, beta_ns=300)


every_scheme = pytest.mark.parametrize("kind", _core.SCHEMES, ids=lambda kind: kind.__name__)


@every_scheme
def test_the_signature_has_the_parameters_and_their_defaults(kind):
    arguments = inspect.signature(kind).parameters.values()
    assert {one.name: one.default for one in arguments} == kind().parameters
    assert all(one.kind is one.KEYWORD_ONLY for one in arguments)
    assert kind(**kind().parameters).parameters == kind().parameters


@every_scheme
def test_the_docstring_names_every_parameter(kind):
    section = str(kind.__doc__).partition("Parameters\n----------\n")[2].partition("\n\n")[0]
    named = re.findall(r"^(\w[\w, ]*) : ", section, re.M)
    assert set(kind().parameters) == {name for names in named for name in names.split(", ")}


@every_scheme
def test_the_command_line_offers_it_by_name(kind):
    parsed = cli._parser().parse_args(["run", "f", "--scheme", kind().name])
    assert type(scheme_of(parsed.scheme, [])) is kind


def test_a_subclass_has_the_signature_of_its_own_constructor():
    class Mine(asap.Deadline):
        def __init__(self, bound):
            super().__init__(latency_ms=bound)

    assert list(inspect.signature(Mine).parameters) == ["bound"]
    assert Mine(3).parameters["latency_ms"] == 3.0


def test_the_texts_about_the_schemes_are_written():
    """Else run tests/python/scheme_texts.py."""
    outdated = {
        path.name for path, text in scheme_texts.texts().items() if path.read_text() != text
    }
    assert not outdated


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


def test_the_cap_shows_in_a_run_and_is_forgotten_between_runs():
    bursts = np.repeat(1000 * np.arange(100), np.tile([20, 80, 320, 1280], 25))
    events = streams.make(np.concatenate([np.zeros(5000), bursts + 10_000, np.full(9000, 200_000)]))
    capped = asap.Greedy(efficiency=0.5)
    first = asap.simulate(events, cost=COST, scheme=capped, latency_ms=10)
    # 50 us and 100 ns are assumed at first: 500 events; 100 us and 300 ns are found: 333.
    assert first.packages["size"][0] == 500
    assert first.packages["size"][-5:-1] == pytest.approx(333, rel=0.02)
    assert first.kept == 1.0
    again = asap.simulate(events, cost=COST, scheme=capped, latency_ms=10)
    np.testing.assert_array_equal(again.packages, first.packages)
    free = asap.simulate(events, cost=COST, scheme=asap.Greedy(), latency_ms=10)
    assert free.packages["size"][-1] == 9000


def test_no_cap_is_null_in_the_summary():
    run = asap.simulate(streams.make([0, 1]), cost=COST, scheme=asap.Greedy())
    assert json.loads(json.dumps(run.summary()))["scheme"] == {
        "name": "greedy",
        "efficiency": None,
    }


def test_asap2022_tells_its_parameters():
    scheme = asap.Asap2022(min_size=50, kappa=2)
    assert scheme.name == "asap2022"
    assert scheme.parameters == {
        "min_processing_ms": 0.2,
        "max_processing_ms": 10.0,
        "min_size": 50,
        "max_size": 29_700,
        "kappa": 2.0,
        "min_gamma": 0.1,
        "max_gamma": 1.0,
        "first_size": 1000,
    }
    assert asap.Asap2022(**scheme.parameters).parameters == scheme.parameters
    with pytest.raises(ValueError, match=r"^max_size = -1: "):
        asap.Asap2022(max_size=-1)
    with pytest.raises(ValueError, match=r"^kappa = 0: "):
        asap.Asap2022(kappa=0)


@pytest.mark.parametrize(("first_size", "end"), [(100, 100), (1000, 29_446)])
def test_the_size_of_asap2022_depends_on_its_start(first_size, end):
    """Two stable sizes at the same constant rate: notebooks/theory.md, 12 (2)."""
    events = streams.make(np.arange(1_500_000) // 5)
    run = asap.simulate(
        events,
        cost=COST,
        scheme=asap.Asap2022(first_size=first_size, min_gamma=1.0),
        latency_ms=1000,  # no flush
    )
    assert run.packages["size"][-3] == end


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
