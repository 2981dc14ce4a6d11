"""The gap of a run: the longest time of stamps without a delivered event while events were lost.

Live, and under any decision: tests/cpp/runner.
"""

from __future__ import annotations

import numpy as np
import pytest

import asap
import streams

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


@pytest.mark.parametrize("scheme", [asap.Deadline(latency_ms=4), asap.FixedSize(size=100)])
@pytest.mark.parametrize("capacity", [None, 500])
def test_it_is_what_the_mask_shows(scheme, capacity):
    for seed in range(4):
        events = uneven(seed)
        run = asap.simulate(
            events,
            cost=SLOW,
            scheme=scheme,
            latency_ms=4.0,
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
