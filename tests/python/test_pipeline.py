"""The live pipeline: another thread pushes, this one works, and everything adds up."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import asap
import streams

# Deadline, the default, drops what is too old, which is a matter of whose turn it is.
AN_HOUR = {"latency_ms": 3.6e6, "capacity": 1 << 20}


def push_all(pipeline, events, chunk=500):
    """A camera: pushes everything from a thread of its own, then stops the pipeline."""

    def camera():
        for begin in range(0, events.size, chunk):
            pipeline.push(events[begin : begin + chunk])
        pipeline.stop()

    thread = threading.Thread(target=camera)
    thread.start()
    return thread


def test_a_package_says_what_it_is():
    pipeline = asap.Pipeline(
        scheme=asap.FixedSize(size=10),
        capacity=30,
        when_full="keep_oldest",
        before=lambda events: events[::2].copy(),
    )
    pipeline.push(streams.make(np.arange(40)))
    pipeline.stop()
    package = next(iter(pipeline))
    assert (package.index, package.t_first, package.t_last, len(package)) == (0, 0, 8, 5)
    assert (package.stale_before, package.overflow_before, package.lost_before) == (0, 10, 10)
    assert (package.gamma, package.filtered) == (1.0, 5)
    assert not package.events.flags.writeable
    with pytest.raises(ValueError, match="read-only"):
        package.events["x"] = 1


def test_the_loop_body_is_what_is_measured():
    with asap.Pipeline(scheme=asap.Greedy()) as pipeline:
        begun = time.monotonic()
        pipeline.push(streams.make([1, 2]))
        for _ in pipeline:
            time.sleep(0.05)
            pipeline.stop()
        took_us = 1e6 * (time.monotonic() - begun)
    stats, rows = pipeline.stats(), pipeline.packages
    assert 50e3 <= rows["processing_us"][0] <= stats["latency_us"]["max"] < took_us + 1e3
    share = rows["processing_us"][0] / (1e6 * stats["source"]["duration_s"])
    assert stats["cpu"] == pytest.approx(share, rel=1e-4)  # a duration of whole us


@pytest.mark.parametrize("t", [[1], []])
def test_a_push_after_stop_raises_and_counts_nothing(t):
    pipeline = asap.Pipeline()
    pipeline.stop()
    with pytest.raises(RuntimeError, match=f"the pipeline is stopped; 0 of {len(t)} events"):
        pipeline.push(streams.make(t))
    assert pipeline.ledger.received == 0


def test_stats_are_there_while_it_runs():
    with asap.Pipeline(scheme=asap.FixedSize(size=10), width=346, height=260) as pipeline:
        bad = streams.make(np.arange(100))
        bad["x"][:7] = 400
        pipeline.upstream_lost(2, packets=30)
        pipeline.push(bad)
        pipeline.stop()
        for package in pipeline:
            stats = pipeline.stats()
            assert stats["ledger"]["delivered"] == 10 * package.index
            assert asap.results.Ledger(**stats["ledger"]).balanced
    stats = pipeline.stats()
    assert stats["rejected"]["out_of_bounds"] == stats["ledger"]["rejected"] == 7
    assert stats["upstream_lost"] == {"marks": 2, "packets": 30}
    assert stats["packages"]["count"] == 10
    assert stats["gamma"] == {"mean": 1.0, "min": 1.0}
    assert stats["mode"] == "live"
    assert stats["open"] is False


# ---- what gives way when the ring is full ---------------------------------------------------


@pytest.mark.parametrize(
    ("when_full", "overflow", "first", "last"),
    [("keep_oldest", 4000, 0, 999), ("keep_newest", 4500, 500, 999), ("thin", 0, 0, None)],
)
def test_when_full(when_full, overflow, first, last):
    pipeline = asap.Pipeline(scheme=asap.Greedy(), capacity=1000, when_full=when_full)
    for begin in range(0, 5000, 100):
        pipeline.push(streams.make(np.arange(begin, begin + 100)))
    pipeline.stop()
    stamps = np.concatenate([package.events["t"] for package in pipeline])
    assert pipeline.ledger.overflow == overflow
    assert stamps[:500].tolist() == list(range(first, first + 500))
    assert stamps[-1] == last if last else stamps[-1] > 2000 and pipeline.ledger.discarded > 4000


def test_a_ring_that_cannot_be_had_names_the_field():
    code = """
import resource, asap
resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30))
for make in (asap.Pipeline, lambda **kw: asap.simulate(asap.synthetic.FlightOverChairs(
        duration_s=0.01), cost=asap.LinearCost(1, 1), **kw)):
    try:
        make(capacity=2**30)
    except MemoryError as error:
        print(error)
"""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    run = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    )
    message = "capacity = 1073741824: needs 16 GiB of memory, which cannot be had; choose less\n"
    assert run.stdout == 2 * message


# ---- an algorithm of the pipeline's own -----------------------------------------------------


class Collector:
    def __init__(self):
        self.arrays, self.gammas = [], []

    def set_gamma(self, gamma):
        self.gammas.append(gamma)

    def process(self, events):
        self.arrays.append(events)


def test_run_hands_every_package_to_the_algorithm():
    events = streams.poisson(1e6, 0.1)
    collector = Collector()
    with asap.Pipeline(collector, scheme=asap.FixedSize(size=500), latency_ms=500) as pipeline:
        camera = push_all(pipeline, events)
        pipeline.run()
        camera.join()
    assert np.concatenate(collector.arrays).tolist() == events.tolist()
    assert not any(array.flags.writeable for array in collector.arrays)
    assert collector.gammas == [1.0] * len(collector.arrays)
    assert pipeline.ledger.delivered == events.size
    assert pipeline.stats()["algorithm"]["name"] == "Collector"


def test_the_algorithm_of_a_pipeline_takes_packages_as_it_says():
    events = streams.poisson(1e6, 0.05)
    for execution, found in {None: "whole", "whole": "whole", "anytime": "anytime"}.items():
        parts = []
        with asap.Pipeline(parts.append, execution=execution, **AN_HOUR) as pipeline:
            pipeline.push(events)
            pipeline.stop()
            pipeline.run()
            sizes = pipeline.packages["size"].tolist()
        assert np.concatenate(parts).tolist() == events.tolist()
        assert ([part.size for part in parts] == sizes) == (found == "whole")
        assert pipeline.stats()["execution"] == found
    with pytest.raises(ValueError, match="execution = 'anytime': a loop takes whole packages"):
        asap.Pipeline(execution="anytime")


def test_each_form_says_what_the_other_is_for():
    with pytest.raises(RuntimeError, match="call run"):
        iter(asap.Pipeline(lambda events: None))
    with pytest.raises(RuntimeError, match="for package in pipeline"):
        asap.Pipeline().run()
    with pytest.raises(TypeError, match="algorithm = 3"):
        asap.Pipeline(3)


def small_packages(algorithm, size):
    pipeline = asap.Pipeline(algorithm, scheme=asap.FixedSize(size=size), latency_ms=1e6)
    pipeline.push(streams.make(np.arange(1000 * size)))
    pipeline.stop()
    pipeline.run()
    return pipeline


def test_small_packages_for_python_are_worth_one_warning():
    with pytest.warns(RuntimeWarning, match="packages of 99 events") as caught:
        pipeline = small_packages(lambda events: None, 99)
    assert caught[0].filename == __file__
    assert len(caught) == 1
    pipeline.start()
    pipeline.push(streams.make(np.arange(99_000)))
    pipeline.stop()
    pipeline.run()  # not again: warnings are errors here
    small_packages(lambda events: None, 100)
    small_packages(asap.ClusterTracker(346, 260), 10)


# ---- looking and changing while it runs -----------------------------------------------------


def test_the_latency_bound_can_change():
    with asap.Pipeline(scheme=asap.FixedSize(size=1000), latency_ms=1e6) as pipeline:
        pipeline.push(streams.make([1, 2, 3]))
        pipeline.set_latency(5)
        assert pipeline.latency_bound_us == pipeline.stats()["latency_bound_us"] == 5000
        assert len(next(iter(pipeline))) == 3  # long before 1000 s


def becomes(pipeline, state):
    """Whether it does, however long the other thread has to wait for its turn."""
    until = time.monotonic() + 60
    while pipeline.state != state and time.monotonic() < until:
        time.sleep(0.001)
    return pipeline.state == state


def test_a_consumer_that_stays_away_is_a_stall():
    pipeline = asap.Pipeline(latency_ms=1, scheme=asap.Greedy())
    assert pipeline.state == "open"
    pipeline.push(streams.make([1]))
    assert becomes(pipeline, "stalled")
    assert pipeline.stats()["state"] == "stalled"
    assert "stalled" in repr(pipeline)
    packages = []
    consumer = threading.Thread(target=lambda: packages.extend(pipeline))
    consumer.start()
    try:
        assert becomes(pipeline, "open")  # it waits for the next one, which is no stall
    finally:
        pipeline.stop()
        consumer.join()
    assert [len(package) for package in packages] == [1]
    assert pipeline.state == pipeline.stats()["state"] == "stopped"


def test_the_log_is_there_when_the_run_is_over():
    pipeline = asap.Pipeline(scheme=asap.FixedSize(size=10), latency_ms=1e4)
    pipeline.push(streams.make(np.arange(200_000)))
    with pytest.raises(RuntimeError, match="the pipeline is open"):
        _ = pipeline.packages
    pipeline.stop()
    list(pipeline)
    rows = pipeline.packages
    assert rows.dtype == asap.simulate([], cost=asap.LinearCost(1, 1)).packages.dtype
    assert rows["index"].tolist() == list(range(20_000 - 16_384, 20_000))
    assert rows["t_first"].tolist() == list(range(10 * (20_000 - 16_384), 200_000, 10))
    pipeline.start()
    pipeline.stop()
    assert (pipeline.packages.size, rows.size) == (0, 16_384)
