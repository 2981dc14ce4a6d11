"""A filter in front (before=): in simulate, run and Pipeline, native and Python."""

from __future__ import annotations

import numpy as np
import pytest

import asap
from streams import poisson

WIDTH, HEIGHT = 346, 260
COST = asap.LinearCost(alpha_us=50, beta_ns=200)


class Sparse:
    """Lets every fourth event pass."""

    def __init__(self):
        self.seen = 0

    def process(self, events):
        first = -self.seen % 4
        self.seen += events.size
        return events[first::4].copy()


def baf():
    return asap.BackgroundActivityFilter(WIDTH, HEIGHT, window_us=10_000)


def stream(rate=1e6, duration_s=0.05, seed=1):
    return poisson(rate, duration_s, seed)


def test_the_filter_sees_every_event_and_the_ledger_says_what_it_dropped():
    events = stream()
    passing = baf().process(events)
    assert 0 < passing.size < events.size
    seen = []
    run = asap.simulate(
        events, cost=COST, scheme=asap.FixedSize(size=100), before=baf(), algorithm=seen.append
    )
    assert run.ledger.filtered == events.size - passing.size
    assert run.ledger.delivered == passing.size
    assert run.ledger.balanced
    np.testing.assert_array_equal(np.concatenate(seen), passing)
    assert (run.packages["offered"] >= run.packages["size"]).all()
    assert run.packages["offered"].sum() <= events.size
    assert (run.packages["gamma"] == 1).all(), "gamma is of what passed the filter"
    assert run.summary()["gamma"]["mean"] == 1


def test_under_the_clock_too():
    events = stream(duration_s=0.02)
    seen = []
    run = asap.run(events, algorithm=seen.append, before=Sparse(), scheme=asap.Greedy())
    assert run.ledger.balanced
    assert run.ledger.filtered == pytest.approx(0.75 * events.size, abs=1)
    assert sum(part.size for part in seen) == run.ledger.delivered


def test_live_too():
    events = stream()
    with asap.Pipeline(latency_ms=60_000, capacity=1 << 20, before=Sparse()) as pipeline:
        pipeline.push(events)
        pipeline.stop()
        delivered = [package.events for package in pipeline]
        ledger = pipeline.ledger
    assert ledger.balanced
    assert ledger.filtered == pytest.approx(0.75 * events.size, abs=1)
    assert sum(part.size for part in delivered) == ledger.delivered > 0
    assert pipeline.stats()["gamma"]["mean"] == pytest.approx(
        ledger.delivered / (ledger.delivered + ledger.discarded)
    )


class Boom(Exception):
    pass


def test_an_exception_of_the_filter_comes_out_unchanged():
    def before(events):
        raise Boom

    with pytest.raises(Boom):
        asap.simulate(stream(), cost=COST, before=before)
    run = asap.last_run()
    assert run.ledger.balanced
    assert run.ledger.pending > 0
    with pytest.raises(Boom):
        asap.run(stream(duration_s=0.01), algorithm=len, scheme=asap.Greedy(), before=before)
    assert asap.last_run().ledger.balanced
    with asap.Pipeline(scheme=asap.Greedy(), before=before) as pipeline:
        pipeline.push(stream())
        pipeline.flush()
        with pytest.raises(Boom):
            next(iter(pipeline))
    assert pipeline.ledger.balanced
    assert pipeline.ledger.pending == stream().size


@pytest.mark.parametrize(
    ("before", "error", "message"),
    [
        (3, TypeError, "before: expected an object with process"),
        (lambda events: events["t"], TypeError, "EVENT_DTYPE"),
        (lambda events: None, TypeError, "before: .* expected the events that pass"),
        (lambda events: np.repeat(events, 2), ValueError, "does not add any"),
    ],
)
def test_what_is_no_filter_is_refused(before, error, message):
    with pytest.raises(error, match=message):
        asap.simulate(stream(), cost=COST, before=before)


def test_of_events_that_the_filter_changes_there_is_no_mask():
    def shifted(events):
        events = events.copy()
        events["x"] += 1
        return events

    settings = {"cost": COST, "before": shifted, "keep_mask": True, "latency_ms": 1e4}
    with pytest.warns(UserWarning, match="kept_mask = None: `before` changes events"):
        run = asap.simulate(stream(), **settings)
    assert run.kept_mask is None
    assert run.ledger.delivered == stream().size


def test_a_filter_that_turns_the_order_around_is_refused():
    with pytest.raises(ValueError, match=r"before: .* t = \d+ after \d+; a filter keeps"):
        asap.simulate(stream(), cost=COST, before=lambda events: events[::-1])
