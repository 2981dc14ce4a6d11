"""Objects of the extension: never made, copied, made of wrong values, used by several threads."""

from __future__ import annotations

import copy
import decimal
import pickle
import threading
from collections.abc import Callable
from functools import partial
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
        lambda: unmade.set_keep(0.5),
        lambda: asap.simulate(EVENTS, cost=COST, algorithm=unmade),
    ):
        with pytest.raises(RuntimeError, match="non-held"):
            use()


def test_derived_class_that_does_not_call_init_is_refused() -> None:
    class Forgetful(asap.Deadline):
        def __init__(self) -> None:
            pass

    class TooEarly(asap.ClusterTracker):
        def __init__(self) -> None:
            self.process(EVENTS)
            super().__init__(10, 10)

    with pytest.raises(TypeError, match=r"__init__\(\) must be called"):
        Forgetful()
    with pytest.raises(RuntimeError, match="non-held"):
        TooEarly()


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


@pytest.mark.parametrize("made", [_core.Validator(), _core.ReadAhead()], ids=type)
def test_objects_of_the_library_itself_are_neither_copied_nor_pickled(made: Any) -> None:
    for duplicate in (
        copy.copy,
        copy.deepcopy,
        *(partial(pickle.dumps, protocol=protocol) for protocol in range(6)),
    ):
        with pytest.raises(TypeError, match="pickle"):
            duplicate(made)


def test_object_keeps_its_class() -> None:
    corners: Any = asap.EFast(9, 9)
    with pytest.raises(TypeError, match="__class__"):
        corners.__class__ = asap.ArcStar
    assert corners.process(EVENTS).shape == EVENTS.shape


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
    assert _core.Ledger(received=np.int64(3), pending=np.uint64(3)).balanced
    for stream in (synthetic.FlightOverChairs, synthetic.ShakenPattern):
        events = next(iter(stream(duration_s=0.01, seed=np.int64(3))))
        assert np.array_equal(events, next(iter(stream(duration_s=0.01, seed=3))))
    assert _core.TextDecoder(first_offset=np.int64(3)).noted == ()


class Mine:
    """A number with errors of its own."""

    def __float__(self) -> float:
        raise KeyError("mine")

    def __index__(self) -> int:
        raise KeyError("mine")

    def __repr__(self) -> str:
        raise KeyError("mine")


def test_error_of_the_argument_itself_comes_out_unchanged() -> None:
    for call in (lambda: asap.Deadline(latency_ms=Mine()), lambda: asap.EFast(9, Mine())):
        with pytest.raises(KeyError, match="mine"):
            call()


def test_type_error_of_a_callback_comes_out_unchanged() -> None:
    def algorithm(events: np.ndarray) -> None:
        raise TypeError("process(): incompatible with me")

    with pytest.raises(TypeError, match=r"^process\(\): incompatible with me$"):
        asap.simulate(EVENTS, cost=COST, algorithm=algorithm)


# ---- one object, several threads ------------------------------------------------------------


def test_threads_take_turns_at_one_object() -> None:
    ended = run_script("""
        events = np.zeros(2000, asap.EVENT_DTYPE)
        events["x"], events["y"] = np.arange(2000) % 60, np.arange(2000) % 40
        events["t"] = np.arange(2000) * 10
        tracker = asap.ClusterTracker(64, 48, engine="compat")
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


def in_front(noise: Any) -> None:
    asap.simulate(OUTSIDE, cost=COST, scheme=asap.Greedy(), before=noise)


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


@pytest.mark.parametrize("work", [as_algorithm, in_front])
def test_threads_do_not_work_with_one_object_at_once(work: Callable[[Any], object]) -> None:
    calls = 0
    for _ in range(TRIES):
        noise, worker = noise_of(work)
        before = calls
        while worker.is_alive() and calls - before < 100:
            noise.process(OUTSIDE[:STEP])
            calls += 1
        worker.join()
        assert noise.rejected == OUTSIDE.size + (calls - before) * STEP  # none was lost
        if calls > 20:
            break
    assert calls > 20


def test_reader_finds_what_the_last_check_has_left() -> None:
    validator = _core.Validator(width=50)
    worker = threading.Thread(target=validator.check, args=(OUTSIDE,))
    worker.start()
    received = set()
    while worker.is_alive():
        received.add(validator.received)
    worker.join()
    assert received <= {0, OUTSIDE.size}
    assert validator.received == validator.rejected["out_of_bounds"] == OUTSIDE.size
