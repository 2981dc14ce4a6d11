"""asap.compare and asap.oracle: rows against single runs."""

import hashlib
import json

import numpy as np
import pytest

import asap
import streams
from asap.experiment import comparing as contenders
from asap.experiment.comparing import side_by_side
from asap.io.source import CheckedStream

COST = asap.LinearCost(alpha_us=100, beta_ns=300, noise=0.05, seed=3)
EVENTS = streams.poisson(6e6, 0.1)  # rho = 1.8


def schemes():
    return {
        "size": asap.FixedSize(size=500),
        "greedy": asap.Greedy(),
        "paper": asap.Asap2020(),
        "deadline": asap.Deadline(latency_ms=5),
    }


def digest(run):
    columns = [run.packages[name] for name in run.packages.dtype.names]
    columns += [run.slots[name] for name in run.slots.dtype.names]
    return hashlib.sha256(b"".join(column.tobytes() for column in columns)).hexdigest()


@pytest.fixture(scope="module")
def comparison():
    return asap.compare(EVENTS, cost=COST, schemes=schemes(), seed=7)


@pytest.mark.parametrize("label", schemes())
@pytest.mark.parametrize("execution", ["anytime", "whole"])
def test_every_run_is_that_of_simulate(label, execution):
    found = asap.compare(EVENTS, cost=COST, schemes=schemes(), seed=7, execution=execution)
    alone = asap.simulate(
        EVENTS, cost=COST, scheme=schemes()[label], latency_ms=5, seed=7, execution=execution
    )
    run = found.runs[label]
    assert digest(run) == digest(alone)
    assert run.summary() == alone.summary()
    assert run.latency.state() == alone.latency.state()


def test_bad_events_are_counted_in_every_run_and_never_reach_the_oracle():
    bad = EVENTS.copy()
    bad["t"][1000:30_000:2] = -1  # go back
    bad["x"][5::50] = 9999
    options = {"width": 346, "height": 260}
    found = asap.compare(bad, cost=COST, schemes=schemes(), seed=7, **options)
    alone = asap.simulate(
        bad, cost=COST, scheme=schemes()["paper"], latency_ms=5, seed=7, **options
    )
    assert digest(found.runs["paper"]) == digest(alone)
    assert found.runs["paper"].summary() == alone.summary()
    assert found.runs["paper"].ledger.rejected > 14_500
    good = (bad["t"] >= 0) & (bad["x"] < 346)
    assert found.received == np.count_nonzero(good)
    assert found.oracle == asap.oracle(bad[good].copy(), cost=COST, latency_ms=5)
    assert found.oracle == asap.oracle(bad, cost=COST, latency_ms=5, **options)
    with pytest.raises(ValueError, match="9999"):
        asap.compare(bad[:900], cost=COST, on_bad="raise", **options)


def test_rows_are_the_runs_in_numbers(comparison):
    assert set(comparison.runs) == set(schemes()) == {row.label for row in comparison.rows}
    for row in comparison.rows:
        run = comparison.runs[row.label]
        assert row.scheme == run.scheme.name
        assert row.score == run.latency.within_bound / comparison.oracle
        assert (row.kept, row.in_time) == (run.kept, run.in_time)
        assert row.late == round((run.kept - run.in_time) * EVENTS.size)
        assert row.p50_us == run.latency.quantile(0.5)
        assert row.p99_us == run.latency.quantile(0.99)
        assert row.max_us == run.latency.max
        assert row.gap_us == run.gap_us
        assert row.overflow == 0
        ends_us = run.packages["start_us"] + run.packages["processing_us"]
        elapsed_s = max(ends_us[-1] - EVENTS["t"][0], EVENTS["t"][-1] - EVENTS["t"][0]) / 1e6
        assert row.packages_per_s == pytest.approx(run.packages.size / elapsed_s)
        assert row.cpu == pytest.approx(run.packages["processing_us"].sum() / 1e6 / elapsed_s)
        assert 0 < row.cpu <= 1
        assert comparison[row.label] is row
    with pytest.raises(KeyError, match="nobody"):
        _ = comparison["nobody"]


def test_no_scheme_beats_the_oracle_and_the_best_is_first(comparison):
    scores = [row.score for row in comparison.rows]
    assert max(scores) <= 1.001
    assert scores == sorted(scores, reverse=True)
    assert comparison.rows[0].label == "deadline"
    assert scores[0] > 0.9 > 0.5 > comparison["greedy"].score


# ---- the source -----------------------------------------------------------------------------


def test_does_not_depend_on_the_cut_or_the_threads(comparison):
    cuts = np.sort(np.random.default_rng(1).integers(0, EVENTS.size, 50))
    found = asap.compare(np.split(EVENTS, cuts), cost=COST, schemes=schemes(), seed=7)
    assert found.oracle == comparison.oracle
    assert found.rows == comparison.rows
    made = [contenders.Contender("x", lambda *_: asap.Greedy())] * 3
    for threads in (1, 3):
        runs, *_ = side_by_side(
            CheckedStream(EVENTS), made, cost=COST, latency_ms=5, seed=7, threads=threads
        )
        assert {digest(run) for run in runs} == {digest(comparison.runs["greedy"])}


def test_a_contender_that_does_not_flush_waits_for_its_size():
    made = [
        contenders.Contender(label, lambda *_: asap.FixedSize(size=1000), flush=flush)
        for label, flush in (("flushes", True), ("waits", False))
    ]
    quiet = streams.make(np.arange(0, 200_000, 100))
    runs = side_by_side(CheckedStream(quiet), made, cost=COST, latency_ms=5).runs
    assert runs[0].latency.max < 6000
    assert runs[1].latency.max > 99_000


@pytest.mark.parametrize("make", [iter, lambda arrays: (one for one in arrays)])
def test_what_can_be_read_only_once_is_refused(make):
    with pytest.raises(ValueError, match="read only once; give a path, an array"):
        asap.compare(make([EVENTS]), cost=COST)


def test_speed_compresses_the_stamps():
    slow = streams.make(1000 + 40 * np.arange(5000))
    fast = streams.make(1000 + 4 * np.arange(5000))
    options = {"cost": COST, "latency_ms": 5, "seed": 1}
    found = asap.compare(slow, speed=10, schemes=[asap.Asap2020()], **options)
    given = asap.compare(fast, schemes=[asap.Asap2020()], **options)
    assert found.rows == given.rows
    assert digest(found.runs["Asap2020"]) == digest(given.runs["Asap2020"])
    assert found.oracle == given.oracle == asap.oracle(slow, cost=COST, latency_ms=5, speed=10)
    assert found.source["duration_s"] == pytest.approx(4 * 4999e-6)
    assert "(10 times as fast as recorded)" in str(found)


# ---- schemes and arguments ------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "labels"),
    [
        ([asap.Greedy(), asap.FixedSize()], ["Greedy", "FixedSize"]),
        (
            [asap.FixedSize(size=10), asap.FixedSize(size=20)],
            ["FixedSize size=10", "FixedSize size=20"],
        ),
        ([asap.Greedy(), asap.Greedy(efficiency=0.9)], ["Greedy", "Greedy efficiency=0.9"]),
        ([asap.SingleEvent(), asap.SingleEvent()], ["SingleEvent", "SingleEvent (2)"]),
        ({"mine": asap.Greedy()}, ["mine"]),
        (asap.Greedy(), ["Greedy"]),
    ],
)
def test_labels(given, labels):
    assert list(contenders.labelled(given)) == labels


# ---- what it shows --------------------------------------------------------------------------


def test_summary_is_json(comparison):
    summary = json.loads(json.dumps(comparison.summary(), allow_nan=False))
    assert summary["schema_version"] == 1
    assert summary["latency_bound_us"] == 5000
    assert summary["oracle"] == {
        "events": comparison.oracle,
        "in_time": comparison.oracle / EVENTS.size,
    }
    assert [one["label"] for one in summary["schemes"]] == list(comparison)
    first = summary["schemes"][0]
    assert first["scheme"] == "deadline" and first["parameters"]["latency_ms"] == 5
    assert first["score"] == comparison.rows[0].score
    assert summary["cost"]["alpha_us"] == 100
    assert summary["source"]["events"] == EVENTS.size


@pytest.mark.parametrize(
    ("cost", "rate_bound", "min_size"),
    [
        ((100, 300), 0.9 * 0.98 / 300e-9, 20),
        ((100, 200_000), 0.9 * 0.98 / 200e-6, 5),
        ((100, 0), 5e6, 1),
        ((5000, 300), 5e6, 1),
    ],
)
def test_the_papers_scheme_gets_what_its_user_is_advised_to_give(cost, rate_bound, min_size):
    """Where the cost tells none, it has its own."""
    events = streams.make(np.arange(100))
    found = asap.compare(events, cost=asap.LinearCost(*cost), latency_ms=10)
    given = found.runs["Asap2020"].scheme.parameters
    assert given["rate_bound"] == pytest.approx(rate_bound)
    assert given["min_size"] == min_size
    assert ("90 % of what this cost can do" in str(found)) == (rate_bound != 5e6)


@pytest.mark.parametrize("cost", [(100, 1500), (20, 3000)])
def test_the_papers_scheme_is_compared_at_its_best(cost):
    """With a rate bound of all that the cost can do its queue grows, here to .08 and .10."""
    events = streams.poisson(1.5 / (cost[1] * 1e-9), 1.0)
    found = asap.compare(
        events, cost=asap.LinearCost(*cost, noise=0.05), latency_ms=10, execution="whole"
    )
    assert found["Asap2020"].score > 0.6


def test_overflow_is_a_share():
    found = asap.compare(EVENTS, cost=COST, schemes=[asap.Greedy()], capacity=1024)
    ledger = found.runs["Greedy"].ledger
    assert found["Greedy"].overflow == ledger.overflow / ledger.received > 0.1


def test_compressed_stamps_are_rounded_down():
    stream = CheckedStream(streams.make([1000, 1003, 1006, 1009]), speed=4.0)
    assert np.concatenate(list(stream))["t"].tolist() == [1000, 1000, 1001, 1002]


ONE = asap.Greedy()


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"cost": (100, 300)}, TypeError, "give asap.LinearCost"),
        ({"schemes": []}, ValueError, r"schemes = \[\]: give at least one"),
        ({"schemes": ["greedy"]}, TypeError, "schemes = 'greedy': give"),
        ({"schemes": [ONE, ONE]}, ValueError, "stands there twice"),
        ({"schemes": {1: ONE, "1": asap.Greedy()}}, ValueError, r"\['1', '1'\] are not all diff"),
        ({"schemes": [asap.Deadline(latency_ms=5)], "latency_ms": 10}, ValueError, "= 5, 10: two"),
        ({"latency_ms": 0}, ValueError, "latency_ms = 0: must be between"),
        ({"speed": 0}, ValueError, "speed = 0: must be between"),
        ({"speed": float("nan")}, ValueError, "speed = nan"),
        ({"capacity": 0}, ValueError, "capacity = 0"),
    ],
)
def test_bad_arguments_are_named(options, error, words):
    with pytest.raises(error, match=words):
        asap.compare(EVENTS[:10], **{"cost": COST, **options})


def test_the_oracle_takes_a_window_and_the_seed_of_the_others(tmp_path):
    path = tmp_path / "events.npy"
    np.save(path, EVENTS)
    first_us, options = int(EVENTS["t"][0]), {"cost": COST, "latency_ms": 5}
    elapsed_s = (EVENTS["t"] - first_us) * 1e-6
    inside = EVENTS[(elapsed_s >= 0.01) & (elapsed_s < 0.03)].copy()
    assert 0 < inside.size < EVENTS.size
    found = asap.oracle(path, start=0.01, stop=0.03, seed=7, **options)
    assert found == asap.oracle(inside, **options)
    with pytest.raises(ValueError, match="seed = -1"):
        asap.oracle(EVENTS, seed=-1, **options)
