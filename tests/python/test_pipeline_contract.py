"""What a live pipeline promises to Python: exceptions, stopping, views, the GIL."""

from __future__ import annotations

import gc
import itertools
import os
import threading
import time
import traceback

import numpy as np
import pytest

import asap
import streams
from children import LONG, PATIENCE
from threads import turns_meanwhile

SMALL = {"scheme": asap.FixedSize(size=10), "capacity": 256}


def native_threads_are_back_to(count):
    """Whether they are, soon: the kernel's part of a thread ends a moment after its join."""
    until = time.monotonic() + 60
    while native_threads() > count and time.monotonic() < until:
        time.sleep(0.001)
    return native_threads() <= count


def native_threads():
    return len(os.listdir("/proc/self/task"))


class Mine(Exception):
    pass


# ---- exceptions -----------------------------------------------------------------------------


def broken(events):
    if events["t"][0] >= 10:
        raise Mine("unchanged")


def loop_that_breaks(pipeline):
    for package in pipeline:
        broken(package.events)


def run_that_breaks(pipeline):
    pipeline.run()


@pytest.mark.parametrize(
    ("work", "algorithm"), [(loop_that_breaks, None), (run_that_breaks, broken)]
)
def test_exceptions_come_out_unchanged_and_it_begins_anew(work, algorithm):
    pipeline = asap.Pipeline(algorithm, **SMALL)
    events = streams.make(np.arange(30))
    for _ in range(1000):
        with pytest.raises(Mine, match="unchanged") as caught, pipeline:
            pipeline.push(events)
            work(pipeline)
        assert traceback.extract_tb(caught.value.__traceback__)[-1].name == "broken"
        assert not pipeline.is_open
        ledger = pipeline.ledger
        assert ledger.balanced
        assert (ledger.delivered, ledger.pending) == (10, 20)
    pipeline.start()
    assert pipeline.ledger.received == 0


@pytest.mark.parametrize("begin", [asap.Pipeline.start, asap.Pipeline.__enter__])
@pytest.mark.parametrize("drain", [True, False])
def test_a_loop_that_was_left_does_not_keep_it_from_beginning_anew(begin, drain):
    pipeline = asap.Pipeline(**SMALL)
    events = streams.make(np.arange(30))
    pipeline.push(events)
    for package in pipeline:
        left = package.events
        break
    pipeline.stop(drain=drain)
    ledger = pipeline.ledger
    assert (ledger.delivered, ledger.pending) == (0, 30)
    begin(pipeline)
    assert pipeline.ledger.received == 0
    assert left.tolist() == events[:10].tolist()
    pipeline.push(events)
    pipeline.stop()
    assert [len(package) for package in pipeline] == [10, 10, 10]
    assert pipeline.packages["size"].tolist() == [10, 10, 10]


# ---- stopping -------------------------------------------------------------------------------


def make(kind, full):
    """A pipeline, and what its consumer does."""

    def stop(events):
        pipeline.stop(drain=False)

    algorithms = {
        "native": asap.ClusterTracker(346, 260),
        "callback": lambda events: None,
        "stopping callback": stop,
    }
    pipeline = asap.Pipeline(algorithms.get(kind), when_full=full, **SMALL)

    def loop():
        for package in pipeline:
            if kind == "stopping loop":
                stop(package.events)

    return pipeline, loop if pipeline.algorithm is None else pipeline.run


def push_until_stopped(pipeline, events):
    try:
        while True:
            pipeline.push(events)
    except RuntimeError:
        pass


STATES = list(
    itertools.product(
        ["none", "loop", "stopping loop", "native", "callback", "stopping callback"],
        ["no camera", "camera"],
        ["thin", "keep_newest", "block"],
        [True, False],
    )
)


@pytest.mark.filterwarnings("ignore:packages of")
def test_stops_from_any_state_and_leaves_no_thread():
    events = streams.make(np.zeros(100))
    before = native_threads()
    slowest = 0.0
    for trial in range(10_000 if LONG else 200):
        kind, camera, full, drain = STATES[trial % len(STATES)]
        pipeline, consume = make(kind, full)
        threads = []
        if kind != "none":
            threads.append(threading.Thread(target=consume))
        if camera == "camera":
            threads.append(threading.Thread(target=push_until_stopped, args=(pipeline, events)))
        for thread in threads:
            thread.start()
        time.sleep((trial % 5) * 0.001)
        began = time.monotonic()
        pipeline.stop(drain=drain)
        pipeline.stop()  # again: nothing happens
        for thread in threads:
            thread.join(60)
            assert not thread.is_alive()
        slowest = max(slowest, time.monotonic() - began)
        assert pipeline.state == "stopped"
        assert pipeline.ledger.balanced
        if drain and kind in ("loop", "native", "callback"):
            assert pipeline.ledger.pending == 0
    assert slowest < 0.5 * PATIENCE
    assert native_threads_are_back_to(before)


# ---- views ----------------------------------------------------------------------------------


def test_packages_that_are_kept_for_ever_are_never_overwritten():
    events = streams.poisson(1e6, 0.05, seed=1)
    pipeline = asap.Pipeline(scheme=asap.FixedSize(size=100))
    pipeline.push(events)
    pipeline.stop()
    kept, columns, passed = [], [], 0
    for package in pipeline:
        if package.index % 3 == 0:
            kept.append(package)
        elif package.index % 3 == 1:
            columns.append((package.index, package.events["t"][::7]))  # a view of a view
        passed += len(package)
    del package
    assert passed == events.size
    for package in kept:
        at = 100 * package.index
        assert package.events.tolist() == events[at : at + 100].tolist()
    for index, column in columns:
        at = 100 * index
        assert column.tolist() == events["t"][at : at + 100][::7].tolist()
    starts = [package.events.__array_interface__["data"][0] for package in kept]
    assert len(set(starts)) == len(kept)
    assert pipeline.stats()["pinned"] == len(kept) + len(columns)
    kept.clear()
    columns.clear()
    del package, column
    gc.collect()
    assert pipeline.stats()["pinned"] == 0


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="no /proc here")
def test_memory_is_flat_when_nothing_is_kept():
    def resident():
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")

    events = streams.make(np.zeros(50_000))
    pipeline = asap.Pipeline(scheme=asap.FixedSize(size=1000))
    packages = iter(pipeline)

    def work(rounds):
        for _ in range(rounds):
            pipeline.push(events)
            for _ in range(50):
                assert len(next(packages)) == 1000

    work(50)  # the ring, and 16384 rows of the log later
    work(300)
    before = resident()
    work(300)
    assert resident() - before < 1 << 20


# ---- the GIL --------------------------------------------------------------------------------

WAITS = {
    "in the loop": lambda: (asap.Pipeline(), list),
    "in run": lambda: (asap.Pipeline(lambda events: None), asap.Pipeline.run),
    "for room": lambda: (
        asap.Pipeline(capacity=16, when_full="block"),
        lambda pipeline: pipeline.push(streams.make(np.zeros(100))),
    ),
}


@pytest.mark.parametrize("where", WAITS)
def test_others_go_on_while_a_thread_waits(where):
    pipeline, wait = WAITS[where]()
    waiting = threading.Thread(target=wait, args=(pipeline,))
    waiting.start()
    until = time.monotonic() + 60
    while where == "for room" and pipeline.ledger.pending < 16 and time.monotonic() < until:
        time.sleep(0.001)  # or the push comes after the stop
    turns = sum(1 for _ in range(20) if time.sleep(0.005) is None and waiting.is_alive())
    pipeline.stop(drain=False)
    waiting.join(60)
    assert turns == 20
    assert not waiting.is_alive()


def test_others_go_on_while_a_native_algorithm_works():
    # One package: the algorithm works from its first event to the last without a look at Python.
    events = streams.poisson(20e6, 0.1)
    pipelines = []

    def filled():
        scheme = asap.FixedSize(size=events.size)
        pipeline = asap.Pipeline(asap.ClusterTracker(346, 260), scheme=scheme, capacity=1 << 22)
        pipeline.push(events)
        pipeline.stop()
        pipelines.append(pipeline)
        return pipeline

    assert turns_meanwhile(asap.Pipeline.run, filled) > 2
    for pipeline in pipelines:
        assert pipeline.packages["size"].tolist() == [events.size]
