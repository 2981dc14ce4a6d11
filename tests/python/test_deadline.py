"""Deadline and DeadBeat as Python sees them. The laws are tested natively."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

import asap
import streams
from asap import cli

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


@pytest.fixture(scope="module")
def overload():
    return streams.poisson(8e6, 0.2)  # rho = 2.4


@both
def test_name_parameters_and_repr(make, name, defaults):
    scheme = make()
    assert scheme.name == name
    assert scheme.parameters == defaults
    inside = ", ".join(f"{key}={value!r}" for key, value in defaults.items())
    assert repr(scheme) == f"{make.__name__}({inside})"
    with pytest.raises(TypeError):
        make(10.0)


@both
def test_every_parameter_arrives_under_its_name(make, name, defaults):
    others = {key: i + 20 / 8 for i, key in enumerate(defaults)}
    others |= {"overhead": 0.125} | ({"prefer": "events"} if "prefer" in defaults else {})
    assert make(**others).parameters == others


def test_parameters_at_their_limits_are_taken():
    for limits in (
        {"latency_ms": 0.01, "overhead": 0, "min_interval_ms": 0},
        {"latency_ms": 1e7, "overhead": 1, "min_interval_ms": 1e7},
    ):
        assert asap.Deadline(**limits).parameters["latency_ms"] == limits["latency_ms"]
        assert asap.DeadBeat(**limits).parameters["overhead"] == limits["overhead"]
    assert asap.DeadBeat(knee=0).parameters["knee"] == 0
    assert asap.DeadBeat(knee=1e6).parameters["knee"] == 1e6


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


def test_a_thinned_package_of_an_opaque_algorithm_has_the_planned_size():
    """A number by chance, 7 % more or less here, would make one package in two late."""
    run = asap.simulate(
        streams.poisson(6e4, 0.5),
        cost=asap.LinearCost(alpha_us=100, beta_ns=50_000),
        opaque=True,
        scheme=asap.Deadline(overhead=0),
    )
    assert run.kept < 0.5
    assert run.latency.max <= 1.01 * 10_000


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


@pytest.mark.parametrize(
    ("words", "got"), [((), 10.0), (("--latency", "3ms"), 3.0)], ids=["10 ms", "3 ms"]
)
def test_the_command_line_takes_it_when_nothing_else_is_said(words, got, tmp_path, capsys):
    path = tmp_path / "events.npy"
    np.save(path, streams.poisson(1e5, 0.1))
    for algorithm in (("--cost", "100us+300ns"), ("--width", "346", "--height", "260")):
        assert cli.main(["run", str(path), *algorithm, *words, "--json"]) == 0
        summary = json.loads(capsys.readouterr().out)
        assert summary["scheme"] == {"name": "deadline", **DEADLINE, "latency_ms": got}
        assert summary["latency_bound_us"] == 1e3 * got


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


@both
@pytest.mark.parametrize("opaque", [False, True], ids=["anytime", "opaque"])
@pytest.mark.parametrize("latency_ms", [3, 10, 30])
def test_the_bound_is_kept_in_overload(overload, make, name, defaults, opaque, latency_ms):
    run = asap.simulate(overload, cost=COST, scheme=make(latency_ms=latency_ms), opaque=opaque)
    assert run.latency_bound_us == 1e3 * latency_ms
    assert run.bound_kept
    assert run.ledger.balanced
    assert run.ledger.overflow == run.ledger.pending == 0
    ideal = (1 - 2 * 0.1 / latency_ms) / 2.4
    in_flight = latency_ms / 200  # what waits when the source ends is worth up to a bound more
    assert 0.93 * ideal < run.in_time < 1.02 * ideal * (1 + in_flight)


@pytest.mark.parametrize(
    ("alpha_us", "beta_ns", "latency_ms", "quiet_hz", "options"),
    [
        pytest.param(100, 300, 10, 200, {"overhead": 0.0}, id="fast"),
        pytest.param(1000, 10_000, 30, 20, {}, id="slow"),
        pytest.param(
            1000, 10_000, 30, 20, {"first_alpha_us": 1000.0, "first_beta_ns": 1e4}, id="told"
        ),
    ],
)
def test_a_rush_after_a_quiet_second_is_in_time_in_whole_packages(
    alpha_us, beta_ns, latency_ms, quiet_hz, options
):
    rush = {"rate_hz": 2e9 / beta_ns, "duration_s": 0.01 * latency_ms, "t0_us": 1_000_000}
    for seed in range(10):
        events = np.concatenate(
            [streams.poisson(quiet_hz, 1.0, seed=seed), streams.poisson(**rush, seed=100 + seed)]
        )
        run = asap.simulate(
            events,
            cost=asap.LinearCost(alpha_us, beta_ns, noise=0.05, seed=seed),
            scheme=asap.Deadline(latency_ms=latency_ms, **options),
            opaque=True,
            seed=seed,
        )
        assert run.latency.max < 1.05e3 * latency_ms, seed


def test_flashing_light_costs_whole_packages_little():
    rng = np.random.default_rng(1)
    count = rng.poisson(4e6)  # load 1.2, in flashes of 0.5 ms at 100 Hz
    stamps = 10_000 * rng.integers(0, 100, count) + rng.integers(0, 500, count)
    events = streams.make(np.sort(stamps))
    cost = asap.LinearCost(100, 300, noise=0.05, seed=1)
    run = asap.simulate(events, cost=cost, scheme=asap.Deadline(), opaque=True)
    best = asap.oracle(events, cost=cost, latency_ms=10, opaque=True)
    assert run.latency.within_bound > 0.92 * best
    assert run.latency.max < 10_500


@both
def test_opaque_execution_changes_the_outcome(overload, make, name, defaults):
    anytime, opaque = (
        asap.simulate(overload, cost=COST, scheme=make(), opaque=opaque) for opaque in (False, True)
    )
    assert not np.array_equal(anytime.packages["size"], opaque.packages["size"])
    # A whole package has no budget that it could be thinned to: it starts small.
    assert opaque.packages["size"][:4].sum() < anytime.packages["size"][:4].sum()


# ---- what it learns --------------------------------------------------------------------------


@both
def test_it_starts_from_its_first_guess_and_learns_the_cost(overload, make, name, defaults):
    scheme = make()
    assert (scheme.alpha_us, scheme.beta_ns) == (50.0, 100.0)
    first = asap.simulate(overload, cost=COST, scheme=scheme)
    assert scheme.alpha_us == pytest.approx(100, rel=0.02)
    assert scheme.beta_ns == pytest.approx(300, rel=0.02)
    again = asap.simulate(overload, cost=COST, scheme=scheme)  # forgotten between runs
    np.testing.assert_array_equal(again.packages, first.packages)


def test_the_first_guess_is_a_parameter():
    scheme = asap.Deadline(first_alpha_us=7, first_beta_ns=8)
    assert (scheme.alpha_us, scheme.beta_ns) == pytest.approx((7, 8))


@both
def test_what_it_learned_cannot_be_set(make, name, defaults):
    with pytest.raises(AttributeError):
        make().alpha_us = 1
    with pytest.raises(AttributeError):
        make().beta_ns = 1
