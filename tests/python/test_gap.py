"""The gap of a run: the longest time of stamps without a delivered event while events were lost."""

from __future__ import annotations

import numpy as np
import pytest

import asap
import streams
from asap.experiment.comparing import user_schemes

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
@pytest.mark.parametrize("execution", ["anytime", "whole"])
@pytest.mark.parametrize("capacity", [None, 500])
def test_it_is_what_the_mask_shows(contender, execution, capacity):
    for seed in range(4):
        events = uneven(seed)
        run = asap.simulate(
            events,
            cost=SLOW,
            scheme=contender.make(4.0, SLOW),
            latency_ms=4.0,
            execution=execution,
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


@pytest.mark.parametrize("when_full", ["thin", "keep_oldest", "keep_newest"])
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
