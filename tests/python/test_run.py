"""asap.run: real time, on a machine that may let a thread wait for its turn for a second."""

import sys
import threading
import time

import numpy as np
import pytest

import asap
import streams
from threads import turns_meanwhile


@pytest.fixture
def no_thread_left():
    before = set(threading.enumerate())
    yield
    for thread in set(threading.enumerate()) - before:
        thread.join(60)
        assert not thread.is_alive()


class Collector:
    """An algorithm that keeps what it gets."""

    def __init__(self):
        self.packages = []

    def process(self, events):
        self.packages.append(events)

    def column(self, name):
        return np.concatenate([events[name] for events in self.packages])


class Slow(Collector):
    """Lets some hundred events come while it works."""

    def process(self, events):
        super().process(events)
        time.sleep(0.002)


def test_every_event_arrives_once_and_in_order():
    events = streams.poisson(0.5e6, 0.2, t0_us=1_633_953_690_975_950)
    algorithm = Collector()
    run = asap.run(events, algorithm=algorithm, scheme=asap.FixedSize(size=100))
    assert run.ledger.balanced
    assert run.ledger.delivered == events.size == run.latency.count
    for name in "xypt":
        np.testing.assert_array_equal(algorithm.column(name), events[name])
    assert [package.size for package in algorithm.packages] == run.packages["size"].tolist()
    assert run.mode == "real"
    assert run.lateness.count > 0


def test_the_mask_leads_back_to_the_users_array():
    events = streams.poisson(1e6, 0.05, seed=3)
    chunks = np.array_split(events, 7)
    got = []
    run = asap.run(iter(chunks), algorithm=got.append, capacity=2000, keep_mask=True)
    assert run.kept_mask.shape == events.shape
    np.testing.assert_array_equal(events[run.kept_mask], np.concatenate([events[:0], *got]))
    assert run.packages["first"].size == len(got)


def test_takes_as_long_as_the_recording_divided_by_speed():
    events = streams.poisson(1e5, 0.6)
    began = time.monotonic()
    run = asap.run(events, algorithm=lambda events: None, speed=2)
    elapsed = time.monotonic() - began
    assert elapsed > 0.29  # slower is the machine's business
    # The log's times are on the recording's own axis, its durations are wall time.
    starts = run.packages["start_us"]
    assert (starts >= run.packages["t_last"]).all()
    assert starts[-1] - events["t"][0] <= 2e6 * elapsed
    assert run.summary()["packages"]["per_s"] == pytest.approx(run.packages.size / 0.3, rel=0.05)


def test_a_quiet_scene_is_flushed_within_the_bound():
    # 10 events, then silence: FixedSize(1000) must not wait for the other 990.
    delivered = threading.Event()
    sizes = []

    def scene():
        yield streams.make(range(0, 100, 10))
        assert delivered.wait(60), "the burst waits for what follows"
        yield streams.make([500_000])

    def algorithm(events):
        sizes.append(events.size)
        delivered.set()

    asap.run(scene(), algorithm=algorithm, scheme=asap.FixedSize(size=1000), latency_ms=10)
    assert sum(sizes) == 11
    assert sizes[-1] == 1


def test_the_backlog_of_a_stall_does_not_stay():
    stalled, since = [], []

    def algorithm(events):
        if stalled:
            since.append(events.size)
        elif events["t"][-1] > 100_000:
            stalled.append(True)
            time.sleep(0.3)

    def scene():
        """600 ms, again and again until packages came after the stall: a busy machine drops."""
        for second in range(100):
            yield streams.poisson(5e3, 0.6, t0_us=600_000 * second)
            time.sleep(0.6)
            if len(since) >= 10:
                break

    run = asap.run(scene(), algorithm=algorithm, latency_ms=10)
    assert run.ledger.balanced and run.ledger.pending == run.ledger.overflow == 0
    assert run.latency.max >= 300_000
    assert run.packages["latency_max_us"][-len(since) :].min() < 200_000


def test_the_producer_is_not_delayed_by_the_algorithm():
    # The algorithm holds the GIL beyond the recording's end; the producer must not care.
    events = streams.poisson(1e5, 0.5)
    begun = []

    def busy(events):
        begun.append(time.monotonic())
        while time.monotonic() < begun[0] + 1.5:
            pass

    interval = sys.getswitchinterval()
    sys.setswitchinterval(10)
    try:
        run = asap.run(events, algorithm=busy, scheme=asap.Greedy())
    finally:
        sys.setswitchinterval(interval)
    assert run.lateness.quantile(0.5) < 600_000  # 1.2 s if it had waited


def test_others_go_on_while_nothing_happens():
    events, tracker = streams.make([0, 200_000]), asap.ClusterTracker(346, 260)
    assert turns_meanwhile(lambda: asap.run(events, algorithm=tracker)) > 2


@pytest.mark.usefixtures("no_thread_left")
def test_exception_of_the_algorithm_comes_out_unchanged():
    class Broken(Exception):
        pass

    error = Broken("mine")

    def algorithm(events):
        raise error

    with pytest.raises(Broken) as caught:
        asap.run(streams.poisson(1e5, 0.1), algorithm=algorithm, scheme=asap.Greedy())
    assert caught.value is error
    run = asap.last_run()
    assert run.ledger.balanced
    assert run.ledger.delivered == 0
    assert run.ledger.pending > 0


def test_progress_is_reported():
    seen = []
    events = streams.poisson(1e5, 0.3)
    asap.run(
        events,
        algorithm=lambda events: time.sleep(0.02),  # so that something is pending
        on_progress=lambda done, total, ledger: seen.append((done, total, ledger)),
    )
    done = [one[0] for one in seen]
    assert done == sorted(done)
    assert done[-1] > 0
    assert {one[1] for one in seen} == {events.size}
    assert set(seen[-1][2]) == set(asap.last_run().ledger)
    assert all(done == ledger["received"] - ledger["pending"] for done, _, ledger in seen)


def test_an_algorithm_takes_packages_as_it_says():
    events = streams.poisson(1e6, 0.1)
    for execution, found in {None: "whole", "whole": "whole", "anytime": "anytime"}.items():
        algorithm = Slow()
        run = asap.run(events, algorithm=algorithm, execution=execution, latency_ms=60_000)
        assert run.execution == found
        sizes = [package.size for package in algorithm.packages]
        assert (sizes == run.packages["size"].tolist()) == (found == "whole")
        np.testing.assert_array_equal(algorithm.column("t"), events["t"])
    filters = {None: "anytime", "whole": "whole", "anytime": "anytime"}
    for execution, found in filters.items():
        algorithm = asap.BackgroundActivityFilter(346, 260)
        assert asap.run(events, algorithm=algorithm, execution=execution).execution == found
