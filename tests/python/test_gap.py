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


@pytest.mark.parametrize("scheme", [asap.Deadline(latency_ms=4), asap.FixedSize(size=100)])
@pytest.mark.parametrize("capacity", [None, 500])
def test_it_is_what_the_mask_shows(scheme, capacity):
    events = streams.poisson(1e6, 0.3)
    events = events[np.diff(events["t"], prepend=-1) > 0]  # of different stamps
    run = asap.simulate(
        events, cost=SLOW, scheme=scheme, latency_ms=4.0, capacity=capacity, keep_mask=True
    )
    assert run.gap_us == gap_of(events["t"], run.kept_mask)
    assert (run.gap_us > 0) == (run.kept < 1)
    assert run.gap_us == run.summary()["gap_us"]
