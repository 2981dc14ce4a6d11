"""The gap of a run: the longest time of stamps without a delivered event while events were lost."""

from __future__ import annotations

import copy
import json
import pickle
import time
import zipfile

import numpy as np
import pytest

import asap
import streams
from asap.experiment.contenders import user_schemes
from asap.results import text as text_of

SCHEMES = [pytest.param(one, id=one.label) for one in user_schemes()]
SLOW = asap.LinearCost(alpha_us=300, beta_ns=1000, noise=0.3, seed=1)


def gap_of(t, kept):
    """Return the gap of events with these stamps of which these were delivered."""
    if len(t) == 0:
        return 0
    number = np.concatenate([[-1], np.flatnonzero(kept), [len(t)]])  # both ends count as delivered
    stamp = np.concatenate([t[:1], t[kept], t[-1:]])
    return int(np.diff(stamp)[np.diff(number) > 1].max(initial=0))


def uneven(seed, duration_s=0.3):
    """Bursts, silences and a steady stream, of different stamps."""
    rng = np.random.default_rng(seed)
    count = int(1e6 * duration_s)
    regime = np.repeat(rng.choice([1, 3, 20, 4000], count // 500, p=[0.4, 0.4, 0.15, 0.05]), 500)
    steps = rng.integers(1, 2 * regime)
    steps[regime == 4000] *= rng.random((regime == 4000).sum()) < 0.02
    t = np.cumsum(steps + 1)
    return streams.make(t[t < t[0] + duration_s * 1e6])


@pytest.mark.parametrize("contender", SCHEMES)
@pytest.mark.parametrize("opaque", [False, True])
@pytest.mark.parametrize("capacity", [None, 500])
def test_it_is_what_the_mask_shows(contender, opaque, capacity):
    for seed in range(4):
        events = uneven(seed)
        run = asap.simulate(
            events,
            cost=SLOW,
            scheme=contender.make(4.0, SLOW),
            latency_ms=4.0,
            opaque=opaque,
            capacity=capacity,
            seed=seed,
            keep_mask=True,
        )
        assert run.gap_us == gap_of(events["t"], run.kept_mask)
        assert run.gap_us == run.summary()["gap_us"]


def test_rejected_and_filtered_events_make_no_gap():
    events = streams.poisson(2e6, 0.05, seed=4)
    events["t"] = np.arange(events.size)
    bad = events.copy()
    bad["t"][::7] = -5  # rejected but the first, which is the oldest
    run = asap.simulate(bad, cost=SLOW, scheme=asap.Greedy(), keep_mask=True)
    assert run.ledger.rejected > 10_000
    assert run.gap_us == 0
    run = asap.simulate(
        events, cost=SLOW, scheme=asap.Greedy(), before=lambda some: some[some["x"] < 40]
    )
    assert run.ledger.filtered > 50_000
    assert run.gap_us == 0


def test_before_the_first_and_behind_the_last():
    cost = asap.LinearCost(alpha_us=1, beta_ns=0, outages_ms=[(0, 30)])
    events = streams.make(np.arange(0, 60_000, 10))
    run = asap.simulate(
        events, cost=cost, scheme=asap.Deadline(latency_ms=5), latency_ms=5, keep_mask=True
    )
    assert run.gap_us == events["t"][run.kept_mask][0] > 20_000
    late = asap.LinearCost(alpha_us=1, beta_ns=0, outages_ms=[(30, 200)])
    run = asap.simulate(
        events, cost=late, scheme=asap.Deadline(latency_ms=5), latency_ms=5, keep_mask=True
    )
    assert run.gap_us == gap_of(events["t"], run.kept_mask) > 20_000


def test_of_nothing_there_is_none():
    assert asap.simulate(streams.make([]), cost=SLOW).gap_us == 0


@pytest.mark.parametrize("speed", [1.0, 4.0])
def test_in_real_time_it_is_of_the_wall(speed):
    events = streams.make(np.arange(0, 200_000, 20) * int(speed))
    run = asap.run(
        events,
        algorithm=lambda package: time.sleep(2e-3),
        scheme=asap.FixedSize(size=10),
        speed=speed,
        capacity=300,
        keep_mask=True,
    )
    assert run.ledger.overflow > 0
    assert run.gap_us == round(gap_of(events["t"], run.kept_mask) / speed) > 0


@pytest.mark.parametrize("when_full", ["thin", "newest", "oldest"])
def test_live_it_is_of_the_stamps(when_full):
    events = uneven(5)
    pipeline = asap.Pipeline(
        scheme=asap.FixedSize(size=100), latency_ms=1e6, capacity=1000, when_full=when_full
    )
    got = []

    def consume(packages):
        for _, package in zip(range(packages), pipeline, strict=False):
            got.append(package.events.copy())

    for chunk in np.array_split(events, 5):
        pipeline.push(chunk)
        consume(4)
    pipeline.stop()
    consume(1000)
    stats = pipeline.stats()
    assert stats["ledger"]["pending"] == 0
    kept = np.isin(events["t"], np.concatenate(got)["t"])
    assert stats["gap_us"] == gap_of(events["t"], kept) > 0


def test_it_is_saved_copied_and_pickled(tmp_path):
    run = asap.simulate(uneven(2), cost=SLOW, scheme=asap.Greedy(), capacity=500)
    assert run.gap_us > 0
    for twin in (copy.copy(run), pickle.loads(pickle.dumps(run))):
        assert twin.gap_us == run.gap_us
    for name in ("run.npz", "run.json"):
        assert asap.load_run(run.save(tmp_path / name)).gap_us == run.gap_us


def test_a_run_saved_without_it_opens(tmp_path):
    run = asap.simulate(uneven(2), cost=SLOW)
    summary = {key: value for key, value in run.summary().items() if key != "gap_us"}
    (tmp_path / "old.json").write_text(json.dumps(summary))
    with (
        zipfile.ZipFile(run.save(tmp_path / "new.npz")) as new,
        zipfile.ZipFile(tmp_path / "old.npz", "w") as old,
    ):
        for name in new.namelist():
            old.writestr(name, json.dumps(summary) if name == "summary.json" else new.read(name))
    for name in ("old.json", "old.npz"):
        loaded = asap.load_run(tmp_path / name)
        assert loaded.gap_us is None
        assert loaded.summary()["gap_us"] is None
        assert "gap        not known" in str(loaded)
    summary["gap_us"] = -1
    (tmp_path / "bad.json").write_text(json.dumps(summary))
    with pytest.raises(ValueError, match="gap_us = -1"):
        asap.load_run(tmp_path / "bad.json")


def test_the_table_and_the_verdict_tell_a_long_one():
    events = uneven(2)
    whole = asap.simulate(events, cost=asap.LinearCost(1, 10), latency_ms=4)
    assert "  gap        none\n" in str(whole)
    assert "longest gap" not in text_of.run_verdict(whole)
    slow = asap.LinearCost(3000, 1000)
    lossy = asap.simulate(events, cost=slow, scheme=asap.Greedy(), latency_ms=4, capacity=500)
    assert lossy.gap_us > 2000
    assert "without a processed event while events came\n" in str(lossy)
    words = f"({lossy.gap_us / 4000:.2g} L): events came, and none of them was processed."
    assert words in text_of.run_verdict(lossy)


def test_a_comparison_has_one_in_each_row():
    found = asap.compare(uneven(1), cost=SLOW, latency_ms=4)
    assert {row.label: row.gap_us for row in found.rows} == {
        label: run.gap_us for label, run in found.runs.items()
    }
    assert all(type(one["gap_us"]) is int for one in found.summary()["schemes"])
