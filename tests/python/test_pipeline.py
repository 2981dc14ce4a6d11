"""The live pipeline: another thread pushes, this one works, and everything adds up."""

from __future__ import annotations

import gc
import signal
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest

import asap
import streams


def push_all(pipeline, events, chunk=500):
    """A camera: pushes everything from a thread of its own, then stops the pipeline."""

    def camera():
        for begin in range(0, events.size, chunk):
            pipeline.push(events[begin : begin + chunk])
        pipeline.stop()

    thread = threading.Thread(target=camera)
    thread.start()
    return thread


def test_delivers_what_another_thread_pushes():
    events = streams.poisson(1e6, 0.2)
    with asap.Pipeline(latency_ms=500, width=346, height=260) as pipeline:
        camera = push_all(pipeline, events)
        packages = [(package.index, package.events.copy()) for package in pipeline]
        camera.join()
    assert [index for index, _ in packages] == list(range(len(packages)))
    assert np.concatenate([part for _, part in packages]).tolist() == events.tolist()
    assert dict(pipeline.ledger) == {
        **dict.fromkeys(pipeline.ledger, 0),
        "received": events.size,
        "delivered": events.size,
    }


def test_a_package_says_what_it_is():
    pipeline = asap.Pipeline(scheme=asap.FixedSize(size=10), capacity=30)
    pipeline.push(streams.make(np.arange(40)))
    pipeline.stop()
    package = next(iter(pipeline))
    assert (package.index, package.t_first, package.t_last, len(package)) == (0, 0, 9, 10)
    assert (package.gamma, package.keep, package.lost_before) == (1.0, 1.0, 10)
    assert not package.events.flags.writeable
    with pytest.raises(ValueError, match="read-only"):
        package.events["x"] = 1


def test_events_stay_valid_as_long_as_they_are_kept():
    events = streams.make(np.arange(5000))
    pipeline = asap.Pipeline(scheme=asap.FixedSize(size=10))
    pipeline.push(events)
    pipeline.stop()
    kept = [package.events for package in pipeline]
    del pipeline
    gc.collect()
    assert np.concatenate(kept).tolist() == events.tolist()


def test_the_loop_body_is_what_is_measured():
    with asap.Pipeline() as pipeline:
        pipeline.push(streams.make([1, 2]))
        for _ in pipeline:
            time.sleep(0.05)
            pipeline.stop()
        assert 50e3 <= pipeline.stats()["latency_us"]["max"] < 2e6
        assert pipeline.stats()["cpu"] > 0.5


def test_an_age_counts_from_the_arrival_time():
    pipeline = asap.Pipeline(scheme=asap.Greedy())
    pipeline.push(streams.make([10**12]), arrival_time=time.monotonic() - 3)
    pipeline.stop()
    list(pipeline)
    assert 3e6 <= pipeline.stats()["latency_us"]["max"] < 30e6


def test_stop_ends_the_loop_from_another_thread():
    with asap.Pipeline() as pipeline:
        timer = threading.Timer(0.05, pipeline.stop)
        timer.start()
        begin = time.monotonic()
        assert list(pipeline) == []
        assert time.monotonic() - begin < 2
        timer.join()


def test_without_draining_the_rest_stays_pending():
    pipeline = asap.Pipeline(scheme=asap.FixedSize(size=10))
    pipeline.push(streams.make(np.arange(95)))
    for _ in pipeline:
        pipeline.stop(drain=False)
    assert (pipeline.ledger.delivered, pipeline.ledger.pending) == (10, 85)
    assert pipeline.ledger.balanced


def test_a_push_after_stop_raises_and_counts_nothing():
    pipeline = asap.Pipeline()
    pipeline.stop()
    with pytest.raises(RuntimeError, match="the pipeline is stopped"):
        pipeline.push(streams.make([1]))
    assert pipeline.ledger.received == 0


def test_an_exception_in_the_body_comes_out_unchanged_and_stops():
    error = KeyError("mine")
    with pytest.raises(KeyError) as caught:  # noqa: SIM117
        with asap.Pipeline(scheme=asap.FixedSize(size=10)) as pipeline:
            pipeline.push(streams.make(np.arange(30)))
            for package in pipeline:
                if package.index == 1:
                    raise error
    assert caught.value is error
    assert not pipeline.is_open
    assert (pipeline.ledger.delivered, pipeline.ledger.pending) == (10, 20)
    assert pipeline.ledger.balanced


def test_restarts_from_nothing():
    pipeline = asap.Pipeline(scheme=asap.Greedy())
    for count in (10, 20):
        with pipeline:
            assert pipeline.ledger.received == 0
            pipeline.push(streams.make(np.arange(count)))
            pipeline.stop()
            assert sum(len(package) for package in pipeline) == count
            assert pipeline.ledger.delivered == count


def test_flush_waits_for_nothing():
    with asap.Pipeline(scheme=asap.FixedSize(size=1000), latency_ms=1e6) as pipeline:
        pipeline.push(streams.make([1, 2, 3]))
        pipeline.flush()
        assert len(next(iter(pipeline))) == 3


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
            assert asap.experiment.result.Ledger(stats["ledger"]).balanced
    stats = pipeline.stats()
    assert stats["rejected"]["out_of_bounds"] == stats["ledger"]["rejected"] == 7
    assert stats["upstream_lost"] == {"marks": 2, "packets": 30}
    assert stats["packages"]["count"] == 10
    assert stats["gamma"] == {"mean": 1.0, "min": 1.0}
    assert stats["mode"] == "live"
    assert stats["open"] is False


def test_bad_events_can_be_refused():
    with asap.Pipeline(width=346, height=260, on_bad="raise") as pipeline:
        with pytest.raises(ValueError, match="x = 400"):
            pipeline.push(streams.make([1, 2], x=[5, 400]))
        assert (pipeline.ledger.received, pipeline.ledger.rejected) == (2, 1)


def test_has_one_consumer():
    with asap.Pipeline() as pipeline:
        waiting = threading.Thread(target=lambda: list(pipeline))
        waiting.start()
        time.sleep(0.05)
        with pytest.raises(RuntimeError, match="another thread consumes"):
            for _ in range(50):  # it is inside but for moments
                next(iter(pipeline))
        pipeline.stop()
        waiting.join()


@pytest.mark.parametrize("bad", [{"latency_ms": -1}, {"capacity": 0}, {"on_bad": "ignore"}])
def test_a_bad_configuration_is_refused(bad):
    with pytest.raises(ValueError, match=next(iter(bad))):
        asap.Pipeline(**bad)


def test_ctrl_c_ends_a_waiting_loop():
    code = textwrap.dedent(
        """
        import time
        import asap
        with asap.Pipeline() as pipeline:
            print("ready", flush=True)
            try:
                for _ in pipeline:
                    pass
            except KeyboardInterrupt:
                print(time.monotonic(), flush=True)
        assert not pipeline.is_open
        """
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout.readline() == "ready\n"
        time.sleep(0.1)
        asked = time.monotonic()
        child.send_signal(signal.SIGINT)
        caught = float(child.stdout.readline())
        assert child.wait(10) == 0
    assert caught - asked < 1.0  # 0.1 s on a machine that is not busy
