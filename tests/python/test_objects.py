"""Objects of the extension: never made, copied, made of wrong values, used by several threads."""

from __future__ import annotations

import decimal
import inspect
import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import asap
from asap import _core, synthetic
from children import run_script
from threads import TRIES

EVENTS = np.zeros(5, asap.EVENT_DTYPE)
COST = asap.LinearCost(1, 1)
PUBLIC = [
    item
    for name in asap.__all__
    if isinstance(item := getattr(asap, name), type) and item.__module__ == "asap._core"
]
CONSTRUCTORS = [cls for cls in PUBLIC if cls is not asap.Scheme]
ALGORITHMS = [cls for cls in PUBLIC if hasattr(cls, "process")]


# ---- objects that were never made -----------------------------------------------------------


@pytest.mark.parametrize("cls", [*PUBLIC, _core.LatencyHistogram], ids=lambda cls: cls.__name__)
def test_object_without_init_is_refused_wherever_it_is_used(cls: type) -> None:
    unmade = cls.__new__(cls)
    for name, item in vars(cls).items():
        if isinstance(item, property):
            with pytest.raises((TypeError, RuntimeError)):
                getattr(unmade, name)
        elif callable(item) and name not in ("__init__", "_pybind11_conduit_v1_"):
            with pytest.raises((TypeError, RuntimeError)):  # of too few arguments, if it takes any
                item(unmade)


@pytest.mark.parametrize("cls", ALGORITHMS, ids=lambda cls: cls.__name__)
def test_algorithm_without_init_is_refused_with_events(cls: type) -> None:
    unmade: Any = cls.__new__(cls)
    for use in (
        lambda: unmade.process(EVENTS),
        lambda: unmade.set_gamma(0.5),
        lambda: asap.simulate(EVENTS, cost=COST, algorithm=unmade),
    ):
        with pytest.raises(RuntimeError, match="non-held"):
            use()


@pytest.mark.parametrize(
    "use",
    [
        lambda new: asap.simulate(EVENTS, cost=COST, scheme=new(asap.Deadline)),
        lambda new: asap.simulate(EVENTS, cost=new(asap.LinearCost)),
        lambda new: asap.simulate(EVENTS, cost=COST, before=new(asap.HotPixelMask)),
        lambda new: asap.run(EVENTS, algorithm=new(asap.ClusterTracker)),
        lambda new: asap.Pipeline(scheme=new(asap.Greedy)),
        lambda new: _core.Oracle(new(asap.LinearCost), 1.0),
    ],
)
def test_object_without_init_is_refused_as_an_argument(use: Callable[..., Any]) -> None:
    with pytest.raises((TypeError, RuntimeError)):
        use(lambda cls: cls.__new__(cls))


# ---- values of a constructor ----------------------------------------------------------------


@pytest.mark.parametrize("cls", CONSTRUCTORS, ids=lambda cls: cls.__name__)
def test_keyword_that_is_unknown_or_has_no_text_is_refused(cls: Any) -> None:
    for given in ((), (9, 9)):
        for name in ("latncy_ms", "\ud800"):
            with pytest.raises(TypeError):
                cls(*given, **{name: 3})


@pytest.mark.parametrize("value", [np.float32(9.7), decimal.Decimal("9.7"), np.float16(9)])
def test_no_fraction_is_cut_down_to_a_whole_number(value: Any) -> None:
    for call in (
        lambda: asap.EFast(value, 9),
        lambda: asap.ClusterTracker(9, 9, slots=value),
        lambda: asap.FixedSize(size=value),
        lambda: asap.ClusterTracker(9, 9).clusters_at(value),
        lambda: asap.ClusterTracker(9, 9).outline(value),
        lambda: asap.ClusterTracker(9, 9).advance_to(value),
    ):
        with pytest.raises(TypeError):
            call()


def test_whole_numbers_of_numpy_are_taken() -> None:
    assert asap.EFast(np.uint8(9), np.int64(8)).height == 8
    assert asap.ClusterTracker(9, 9, slots=np.int16(7)).parameters["slots"] == 7
    pipeline = asap.Pipeline()
    pipeline.upstream_lost(np.int64(3), packets=np.uint8(1))
    assert pipeline.stats()["upstream_lost"] == {"marks": 3, "packets": 1}
    for stream in (synthetic.FlightOverChairs, synthetic.ShakenPattern):
        events = next(iter(stream(duration_s=0.01, seed=np.int64(3))))
        assert np.array_equal(events, next(iter(stream(duration_s=0.01, seed=3))))
    assert _core.TextDecoder(first_offset=np.int64(3)).noted == ()


CLASSES = [kind for name in asap.__all__ if isinstance(kind := getattr(asap, name), type)]
MADE_BY_USERS = [kind for kind in CLASSES if kind not in (asap.Scheme, asap.CameraError)]


@pytest.mark.parametrize("kind", MADE_BY_USERS, ids=lambda kind: kind.__name__)
def test_a_signature_names_every_argument_of_a_public_class(kind: type) -> None:
    kinds = {one.kind for one in inspect.signature(kind).parameters.values()}
    assert not kinds & {inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD}


# ---- one object, several threads ------------------------------------------------------------


def test_threads_take_turns_at_one_object() -> None:
    ended = run_script("""
        events = np.zeros(2000, asap.EVENT_DTYPE)
        events["x"], events["y"] = np.arange(2000) % 60, np.arange(2000) % 40
        events["t"] = np.arange(2000) * 10
        tracker = asap.PublishedClusterTracker(64, 48)
        gamma = asap.GammaFilter()

        def work():
            for _ in range(100):
                tracker.process(events)
                gamma.mask(events, 0.5)
                tracker.clusters
                tracker.reset()

        threads = [threading.Thread(target=work) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        print(gamma.position)
    """)
    assert (ended.code, ended.lines) == (0, ["800000"])


STEP = 100_000
OUTSIDE = np.zeros(40 * STEP, asap.EVENT_DTYPE)  # of the filter's frame
OUTSIDE["x"], OUTSIDE["t"] = 100, np.arange(OUTSIDE.size) // 50


def noise_of(calls: Callable[[Any], object]) -> tuple[Any, threading.Thread]:
    noise = asap.BackgroundActivityFilter(50, 50)
    worker = threading.Thread(target=calls, args=(noise,))
    worker.start()
    return noise, worker


def as_algorithm(noise: Any) -> None:
    scheme = asap.FixedSize(size=STEP)
    asap.simulate(OUTSIDE, cost=COST, scheme=scheme, algorithm=noise)


def by_calls(noise: Any) -> None:
    for _ in range(400):
        noise.process(OUTSIDE[:STEP])


@pytest.mark.parametrize("work", [as_algorithm, by_calls])
def test_reader_finds_what_the_last_package_has_left(work: Callable[[Any], object]) -> None:
    values: set[int] = set()
    for _ in range(TRIES):  # a busy machine may give the reader no turn during a run
        noise, worker = noise_of(work)
        while worker.is_alive():
            values.add(noise.rejected)
        if len(values) > 20:
            break
    assert len(values) > 20
    assert {value % STEP for value in values} == {0}
