"""A call that cannot be made is refused in words: argument, value, remedy; nothing crashes."""

from __future__ import annotations

import copy
import decimal
import math
import os
import pickle
import socket
import threading
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
from asap import _core, analysis, synthetic
from children import run_script
from threads import TRIES

pytest.importorskip("asap_laboratory")

from asap_laboratory import (
    accuracy_study,
    keep_curve,
    ladder_study,
    metrics,
    profiles,
    rivals_study,
    scenes,
    score,
    study,
)
from fake_scene import FakeScene

EVENTS = np.zeros(5, asap.EVENT_DTYPE)
CLASSES = [item for item in vars(_core).values() if isinstance(item, type)]
UNSIZED = np.array(3)  # len() of it is an error
COST = asap.LinearCost(1, 1)
UNMADE = "without __init__: make it by its constructor"


# ---- objects that were never made -----------------------------------------------------------


@pytest.mark.parametrize("cls", CLASSES, ids=lambda cls: cls.__name__)
def test_object_without_init_is_refused_wherever_it_is_used(cls: type) -> None:
    unmade = cls.__new__(cls)
    for name, item in vars(cls).items():
        if isinstance(item, property):
            with pytest.raises(TypeError, match=UNMADE):
                getattr(unmade, name)
        elif callable(item) and not name.startswith("__") and name != "_pybind11_conduit_v1_":
            with pytest.raises(TypeError):  # of too few arguments, unless there are none
                getattr(unmade, name)()
    if hasattr(cls, "process"):
        with pytest.raises(TypeError, match=UNMADE):
            unmade.process(EVENTS)


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
    with pytest.raises(TypeError, match=UNMADE):
        TooEarly()


@pytest.mark.parametrize(
    "use",
    [
        lambda new: asap.simulate(EVENTS, cost=COST, scheme=new(asap.Deadline)),
        lambda new: asap.simulate(EVENTS, cost=new(asap.LinearCost)),
        lambda new: asap.simulate(EVENTS, cost=COST, algorithm=new(asap.EFast)),
        lambda new: asap.simulate(EVENTS, cost=COST, before=new(asap.HotPixelMask)),
        lambda new: asap.run(EVENTS, algorithm=new(asap.ClusterTracker)),
        lambda new: asap.Pipeline(scheme=new(asap.Greedy)),
    ],
)
def test_object_without_init_is_refused_as_an_argument(use: Callable[..., Any]) -> None:
    with pytest.raises(TypeError, match=UNMADE):
        use(lambda cls: cls.__new__(cls))


DUPLICATES: list[Callable[[Any], Any]] = [
    copy.copy,
    copy.deepcopy,
    *(partial(pickle.dumps, protocol=protocol) for protocol in range(6)),
]


@pytest.mark.parametrize("made", [_core.Validator(), _core.ReadAhead()], ids=type)
def test_objects_of_the_library_itself_are_neither_copied_nor_pickled(made: Any) -> None:
    for duplicate in DUPLICATES:
        with pytest.raises(TypeError, match="pickle"):
            duplicate(made)


# ---- arguments that do not fit --------------------------------------------------------------


def refused(call: Callable[[], Any], opening: str, *remedy: str, by: Any = TypeError) -> None:
    """Assert that the error opens with field and value and goes on with a remedy.

    The remedy is free text, but holds the words in `remedy`.
    """
    with pytest.raises(by) as caught:
        call()
    said = str(caught.value)
    assert said.startswith(opening), said
    _, colon, text = said[len(opening) :].partition(": ")
    assert colon and len(text) >= 8, said
    assert all(word in text for word in remedy), said
    assert "\n" not in said


CORNERS, TRACKER = asap.EFast(9, 9), asap.ClusterTracker(9, 9)
LINEAR, IMAGE = asap.LinearCost, asap.EventImage
DTYPE = "asap.EVENT_DTYPE"

# A call, how its refusal opens, and what the remedy must name.
MISFITS: list[tuple[Any, ...]] = [
    (lambda: asap.Deadline(latency_ms="x"), "latency_ms = 'x'", "number"),
    (lambda: asap.Deadline(latency_ms=None), "latency_ms = None", "number"),
    (lambda: asap.Deadline(latency_ms=1j), "latency_ms = 1j", "number"),
    (lambda: asap.Deadline(latncy_ms=3), "latncy_ms = 3", "latency_ms,"),
    (lambda: asap.Deadline(5), "5", "latency_ms, overhead"),
    (lambda: asap.SingleEvent(5), "5", "none"),
    (lambda: asap.Greedy(efficiency="x"), "efficiency = 'x'", "number or None"),
    (lambda: LINEAR("a", None), "alpha_us = 'a'", "number"),
    (lambda: LINEAR(1), "beta_ns is missing", "number"),
    (lambda: LINEAR(1, 2, alpha_us=3), "alpha_us = 3"),  # given by position too
    (lambda: LINEAR(1, 2, drift=3), "drift = 3", "Sequence[number]", "None"),
    (lambda: LINEAR(1, 2, drift=UNSIZED), "drift = array(3)", "Sequence[number]"),
    (lambda: LINEAR(1, 2, drift=[1.0, "x"]), "drift = [1.0, 'x']", "Sequence[number]"),
    (lambda: LINEAR(1, 2, outages_ms=UNSIZED), "outages_ms = array(3)", "Sequence"),
    (lambda: LINEAR(1, 2, outages_ms=[UNSIZED]), "outages_ms = [array(3)]", "Sequence"),
    (lambda: LINEAR(1, 2, outages_ms=[(1,)]), "outages_ms = [(1,)]", "Sequence"),
    (lambda: LINEAR(1, 2, outages_ms=[(1, 2)], drift=3), "drift = 3", "Sequence"),
    (lambda: asap.HotPixelMask(9, 9, pixels=UNSIZED), "pixels = array(3)", "Sequence[tuple"),
    (lambda: IMAGE(9, 9, channels=UNSIZED), "channels = array(3)", "Sequence[str]"),
    (lambda: IMAGE(9, 9, channels="on"), "channels = 'on'", "Sequence[str]"),
    (lambda: asap.EFast(1.5, 3), "width = 1.5", "whole number"),
    (lambda: asap.EFast(None, None), "width = None", "whole number"),
    (lambda: asap.EFast(9, [9]), "height = [9]", "whole number"),
    (lambda: asap.EFast(9, 9, **{"\ud800": 3}), "'\\ud800'"),
    (lambda: asap.ClusterTracker(9, 9, engine=5), "engine = 5", "text"),
    (lambda: asap.ClusterTracker(9, 9, engine="\ud800"), "engine = '\\ud800'", "text"),
    (lambda: asap.ClusterTracker(9, 9, **{"\ud800": 3}), "'\\ud800'"),
    (lambda: asap.ClusterTracker(9, 9, windw=3), "windw = 3", '"fast"', "engine, support,"),
    (
        lambda: asap.ClusterTracker(9, 9, engine="compat", windw=3),
        *("windw = 3", '"compat"', "engine, window,"),
    ),
    (lambda: asap.ClusterTracker(9, 9, slots="x"), "slots = 'x'", "whole number"),
    (lambda: asap.PlaneFlow(9, 9, refit="x"), "refit = 'x'", "True or False"),
    (lambda: asap.PlaneFlow(9, 9, refit=np.zeros(2)), "refit = array(", "True or False"),
    (lambda: CORNERS.process([]), "events = []", DTYPE, "as_events"),
    (lambda: CORNERS.process(None), "events = None", DTYPE),
    (lambda: CORNERS.process(), "events is missing", DTYPE),
    (lambda: CORNERS.process(np.zeros((2, 3))), "events = array of shape (2, 3), float64", DTYPE),
    (lambda: CORNERS.process(EVENTS[::2]), "events = array of shape (3,)", "contiguous", DTYPE),
    (lambda: asap.EFast.process(3, EVENTS), "self = 3", "asap.EFast"),
    (lambda: CORNERS.set_keep("x"), "gamma = 'x'", "number"),
    (lambda: CORNERS.reset(1), "1", "none"),
    (lambda: TRACKER.process(EVENTS, "x"), "labels = 'x'", "True or False"),
    (lambda: TRACKER.clusters_at(1.5), "t_us = 1.5", "whole number"),
    (lambda: TRACKER.outline(1.5), "id = 1.5", "whole number"),
    (lambda: _core.Oracle(asap.Greedy(), 1.0), "cost = Greedy(", "asap.LinearCost"),
]


@pytest.mark.parametrize("case", MISFITS, ids=lambda case: ascii(case[1]))
def test_argument_that_does_not_fit_is_named(case: tuple[Any, ...]) -> None:
    refused(*case)


class Large:
    def __index__(self) -> int:
        return 2**70

    def __repr__(self) -> str:
        return "Large()"


OUT_OF_RANGE: list[tuple[Any, ...]] = [
    (lambda: asap.EFast(Large(), 9), "width = Large()"),
    (lambda: asap.EFast(10**12, 9), "width = 1000000000000"),
    (lambda: asap.EFast(9, -(10**12)), "height = -1000000000000"),
    (lambda: asap.EFast(10**5000, 9), "width = <int>"),
    (lambda: asap.FixedSize(size=10**5000), "size = <int>"),
    (lambda: asap.ClusterTracker(9, 9, slots=10**12), "slots = 1000000000000"),
    (lambda: asap.ClusterTracker(9, 9, support="\ud800"), "support = '\\ud800'"),
    (lambda: asap.Pipeline().upstream_lost(-1), "marks = -1", "0"),
    (lambda: TRACKER.clusters_at(2**64), f"t_us = {2**64}"),
    (lambda: asap.Deadline(latency_ms=10**400), "latency_ms = 1000000000"),
]


@pytest.mark.parametrize("case", OUT_OF_RANGE, ids=lambda case: ascii(case[1]))
def test_value_out_of_every_range_is_named(case: tuple[Any, ...]) -> None:
    refused(*case, by=ValueError)


@pytest.mark.parametrize("width", [np.float32(9.7), decimal.Decimal("9.7"), np.float16(9)])
def test_no_fraction_is_cut_down_to_a_whole_number(width: Any) -> None:
    refused(lambda: asap.EFast(width, 9), f"width = {width!r}", "whole number")
    refused(lambda: asap.ClusterTracker(9, 9, slots=width), f"slots = {width!r}", "whole number")


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


def test_true_is_a_whole_number_for_every_door() -> None:
    sides = {"width": True, "height": True}
    assert asap.simulate(EVENTS, cost=COST, **sides).kept == 1
    found = asap.check(EVENTS, **sides)
    assert (found.width, found.height, found.events) == (1, 1, EVENTS.size)


class Mine:
    """An object with errors of its own."""

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


def test_value_that_cannot_be_shown_is_told_by_its_type() -> None:
    refused(lambda: CORNERS.process(Mine()), "events = <Mine>", DTYPE)


def test_type_error_of_a_callback_comes_out_unchanged() -> None:
    def algorithm(events: np.ndarray) -> None:
        raise TypeError("process(): incompatible with me")

    with pytest.raises(TypeError, match=r"^process\(\): incompatible with me$"):
        asap.run(EVENTS, algorithm=algorithm)


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


def test_object_keeps_its_class() -> None:
    corners = asap.EFast(9, 9)
    with pytest.raises(TypeError, match="__class__"):
        corners.__class__ = asap.ArcStar
    assert corners.process(EVENTS).shape == EVENTS.shape


# ---- what Python checks by itself -----------------------------------------------------------


@pytest.mark.parametrize("unit", [[], {}, set(), None, 5, "h"], ids=repr)
def test_time_unit_of_any_kind_is_named(unit: Any) -> None:
    with pytest.raises(ValueError, match=r"^time_unit = "):
        asap.as_events(EVENTS, time_unit=unit)


@pytest.mark.parametrize("order", [5, 1.5, object(), "txx", []], ids=type)
def test_order_of_any_kind_is_named(order: Any) -> None:
    with pytest.raises(ValueError, match=r"^order = "):
        asap.as_events(np.zeros((2, 4), int), order=order)


@pytest.mark.parametrize("speed", [None, "1", 1j, [1.0], np.ones(2)], ids=repr)
def test_speed_that_is_no_number_is_named(speed: Any) -> None:
    with pytest.raises(TypeError, match=r"^speed = "):
        asap.oracle(EVENTS, cost=COST, latency_ms=10, speed=speed)
    with pytest.raises(TypeError, match=r"^speed = "):
        asap.compare(EVENTS, cost=COST, speed=speed)
    with pytest.raises(TypeError, match=r"^speed = "):
        asap.run(EVENTS, algorithm=lambda _: None, speed=speed)


HALF = decimal.Decimal("0.5")


@pytest.mark.parametrize(
    ("call", "plain"),
    [
        (lambda half: asap.Pipeline(latency_ms=half).latency_bound_us, 500),
        (lambda half: asap.oracle(EVENTS, cost=COST, latency_ms=half, speed=half), 5),
        (lambda half: asap.compare(EVENTS, cost=COST, latency_ms=half, speed=half).speed, 0.5),
        (lambda half: asap.run(EVENTS, algorithm=len, speed=half).summary()["speed"], 0.5),
        (lambda half: profiles.drift(half).size, 500),
        (lambda half: profiles.cost("slow_ht", duration_s=half).name, "linear_cost"),
        (lambda half: profiles.Profile("low", duration_s=half, scale=half).duration_s, 0.5),
        (lambda half: scenes.timing(1, 64, 48, half, duration_s=half).duration_us, 500_000),
        (lambda half: score(asap.EFast(64, 48), THIN, gamma=half)["events"], None),
        (
            lambda half: keep_curve(asap.EFast, THIN, gammas=[half]).rows[0].gamma,
            0.5,
        ),
        (lambda half: analysis.rate(EVENTS, half)[1][0], 1e7),
        (lambda half: metrics.settle_ms(RUN.slots, [], 9, half), 0),
        (lambda half: analysis.Cost(0, 1).throughput_hz(half), 1e9),
    ],
)
def test_number_of_any_kind_is_taken_as_a_float(call: Callable[[Any], Any], plain: Any) -> None:
    found = call(HALF)
    assert found == call(0.5)
    assert plain in (found, None)
    for bad in ("nan", "snan"):
        with pytest.raises((TypeError, ValueError), match=r"^\w+ = .*: "):
            call(decimal.Decimal(bad))


def test_whole_number_of_too_many_digits_is_told_by_its_type() -> None:
    many = 10**5000
    for field, call in (
        ("algorithm", lambda: asap.Pipeline(many)),
        ("scheme", lambda: asap.simulate(EVENTS, cost=COST, scheme=many)),
        ("cost", lambda: asap.simulate(EVENTS, cost=many)),
        ("cost", lambda: asap.compare(EVENTS, cost=many)),
        ("schemes", lambda: asap.compare(EVENTS, cost=COST, schemes=[many])),
        ("algorithm", lambda: keep_curve(many, SCENE)),
        ("before", lambda: keep_curve(asap.EFast, SCENE, before=many)),
    ):
        refused(call, f"{field} = <int>")


RUN = asap.simulate(EVENTS, cost=COST)
SCENE = FakeScene([(50, 50, 0, 0)], end_us=120_001)
THIN = scenes.timing(1, 64, 48, 50.0, (4.0, 8.0), duration_s=0.02)
CURVE = np.arange(9.0)

NO_NUMBERS = (
    None,
    "x",
    [],
    object(),
    1j,
    np.ones(1),
    np.ones(2),
    np.ones((2, 2)),
    np.empty(0),
    len,
)
NO_SHARES = (*NO_NUMBERS, math.nan, -1, 10**5000)
NO_WHOLES = (*NO_SHARES, 1.5)
NO_PATHS = (None, [], object(), 1.5, np.ones(2))
NO_SEQUENCES = (None, "x", [], object(), 1.5, np.ones((2, 2)), np.empty(0), len)
NO_TABLES = (None, "x", object(), 1.5, np.ones(2), np.zeros((2, 2)), np.zeros(2, [("a", int)]))
NO_FLAGS = ("x", [], object(), np.ones(2), np.empty(0), len)
NO_CALLBACKS = ("x", [], object(), math.nan, 1, np.ones(2))
NO_NAMES = (None, "x", [], object(), 1.5, np.ones(2), np.empty(0), np.zeros(2, [("a", int)]))


def nothing(events: np.ndarray) -> None:
    raise AssertionError("the algorithm was called")


class Nobody:
    def submit(self, *_: object) -> None:
        raise AssertionError("the study has begun")


def studies(field: str, values: tuple[Any, ...]) -> list[tuple[Any, ...]]:
    def call(made: Callable[..., Any]) -> Callable[..., Any]:
        return lambda **named: made(**{"out": "never", "executor": Nobody(), **named})

    made = (study, accuracy_study, ladder_study, rivals_study)
    return [(call(one), field, values) for one in made]


DOORS: list[tuple[Callable[..., Any], str, tuple[Any, ...]]] = [
    (lambda **named: asap.run(EVENTS, algorithm=nothing, **named), "on_progress", NO_CALLBACKS),
    (lambda **named: asap.simulate(EVENTS, cost=COST, **named), "on_progress", NO_CALLBACKS),
    (lambda **named: asap.simulate(EVENTS, cost=COST, **named), "opaque", NO_FLAGS),
    (lambda **named: asap.simulate(EVENTS, cost=COST, **named), "width", NO_WHOLES[1:]),
    (lambda **named: asap.compare(EVENTS, cost=COST, **named), "on_progress", NO_CALLBACKS),
    (lambda **named: asap.compare(EVENTS, cost=COST, **named), "schemes", (1.5, object(), len)),
    (lambda **named: asap.compare(EVENTS, cost=COST, **named), "opaque", NO_FLAGS),
    (lambda **named: asap.compare(EVENTS, cost=COST, **named), "height", NO_WHOLES[1:]),
    (lambda **named: asap.check(EVENTS, **named), "on_progress", NO_CALLBACKS),
    (lambda **named: asap.check(EVENTS, **named), "width", NO_WHOLES[1:]),
    (lambda **named: asap.check(EVENTS, **named), "order", NO_NAMES[1:]),
    (lambda **named: asap.check(EVENTS, **named), "time_unit", NO_NAMES[1:]),
    (lambda **named: asap.as_events(EVENTS, **named), "order", NO_NAMES[1:]),
    (lambda **named: asap.as_events(EVENTS, **named), "copy", NO_FLAGS),
    (asap.as_events, "source", (5, object(), 1j, len)),
    (asap.read, "path", NO_PATHS),
    (asap.load_run, "path", NO_PATHS),
    (RUN.save, "path", NO_PATHS),
    (RUN.report, "path", NO_PATHS[-1:]),  # each draws the page first
    (asap.check(EVENTS).report, "path", NO_PATHS[-1:]),
    (
        lambda **named: score(asap.EFast(346, 260), SCENE, **named),
        "gamma",
        NO_SHARES,
    ),
    (lambda **named: score(asap.EFast(346, 260), SCENE, **named), "told", NO_FLAGS),
    (
        lambda **named: score(asap.EFast(346, 260), SCENE, **named),
        "active",
        NO_NAMES,
    ),
    (
        lambda **named: score(asap.EFast(346, 260), SCENE, **named),
        "before",
        (1, "x", len),
    ),
    (lambda **named: score(scene=SCENE, **named), "tracker", (None, 1, "x", len)),
    (
        lambda **named: keep_curve(asap.EFast, SCENE, **named),
        "gammas",
        (*NO_SEQUENCES, [2]),
    ),
    (
        lambda **named: keep_curve(asap.EFast, SCENE, **named),
        "seeds",
        (*NO_SEQUENCES, [1.5]),
    ),
    (lambda **named: keep_curve(scene=SCENE, **named), "algorithm", (None, 1, "x")),
    *studies("out", NO_PATHS),
    *studies("form", NO_NAMES),
    *studies("executor", ("x", [], object(), 1.5, np.ones(2))),
    *studies("workers", (*NO_WHOLES[1:], 0)),
    *studies("fresh", NO_FLAGS),
    *studies("figures", NO_FLAGS),
    *studies("on_progress", NO_CALLBACKS),
    (lambda n: scenes.timing(n, 64, 48, 50.0), "n", NO_WHOLES),
    (lambda width: scenes.timing(1, width, 48, 50.0), "width", (*NO_WHOLES, 15)),
    (lambda height: scenes.timing(1, 64, height, 50.0), "height", (*NO_WHOLES, 15)),
    (lambda speed: scenes.timing(1, 64, 48, speed), "speed", NO_SHARES),
    (
        lambda radius: scenes.timing(1, 64, 48, 50.0, radius),
        "radius",
        (*NO_SEQUENCES, (1,), (2, 1)),
    ),
    (lambda **named: scenes.timing(1, 64, 48, 50.0, **named), "duration_s", NO_SHARES),
    (scenes.corners, "kind", NO_NAMES),
    (scenes.corners, "duration_s", NO_SHARES),
    (scenes.stop_and_go, "gap_ms", NO_SHARES),
    (scenes.stop_and_go, "speed", NO_SHARES),
    (scenes.stop_and_go, "radius", NO_SHARES),
    (scenes.occlusion, "gap_ms", NO_SHARES),
    (scenes.occlusion, "speed", NO_SHARES),
    (scenes.occlusion, "radius", NO_SHARES),
    (THIN.truth, "t_us", NO_SHARES),
    (THIN.vertices, "t_us", NO_SHARES),
    (THIN.thin, "gamma", NO_SHARES),
    (lambda **named: profiles.Profile("low", **named), "duration_s", NO_SHARES),
    (lambda **named: profiles.Profile("low", **named), "seed", NO_WHOLES),
    (lambda **named: profiles.Profile("low", **named), "scale", NO_SHARES),
    (lambda **named: profiles.Profile("low", **named), "name", NO_NAMES[2:]),
    (profiles.RandomRate, "pieces", (None, *NO_CALLBACKS)),
    (profiles.cost, "name", NO_NAMES),
    (lambda seed: profiles.cost("slow", seed=seed), "seed", NO_WHOLES),
    (profiles.drift, "duration_s", NO_SHARES),
    (lambda seed: profiles.outages_ms(0.1, seed=seed), "seed", NO_WHOLES),
    (lambda profile: profiles.scenario(profile, "slow"), "profile", NO_NAMES),
    (lambda cost_model: profiles.scenario("low", cost_model), "cost_model", NO_NAMES),
    (synthetic.ShakenPattern, "duration_s", NO_SHARES),
    (synthetic.joined, "arrays", (None, "x", 5, EVENTS, [5], [np.zeros((2, 2))], [EVENTS[["t"]]])),
    (synthetic.FlightOverChairs, "seed", NO_WHOLES),
    (lambda bin_us: analysis.rate(EVENTS, bin_us), "bin_us", (*NO_SHARES, 0, math.inf)),
    (analysis.describe, "blocks", (None, "x", object(), 1.5, EVENTS)),
    (analysis.PeakCount, "window_us", (*NO_WHOLES, 0)),
    (analysis.PeakCount(9).add, "elapsed_us", (None, "x", [], object(), 1.5, np.ones((2, 2)))),
    (lambda x: analysis.decimate(x, CURVE, 8), "x", (*NO_TABLES[:4], [[1], [1, 2]])),
    (lambda y: analysis.decimate(CURVE, y, 8), "y", (*NO_TABLES[:5], [])),
    (lambda points: analysis.decimate(CURVE, CURVE, points), "points", (*NO_WHOLES, 3)),
    (analysis.time_s, "run", (None, "x", EVENTS)),
    (analysis.diagnose, "run", (None, "x", EVENTS)),
    (analysis.fit_cost, "run", (None, "x", EVENTS)),
    (lambda wanted: analysis.diagnose(RUN, wanted=wanted), "wanted", (*NO_SHARES, 1.5)),
    (lambda run: analysis.median_in_windows(run, "size", 1), "run", (None, "x", EVENTS)),
    (lambda column: analysis.median_in_windows(RUN, column, 1), "column", NO_NAMES),
    (lambda window_ms: analysis.median_in_windows(RUN, "size", window_ms), "window_ms", NO_SHARES),
    (analysis.Cost(1, 1).throughput_hz, "bound_us", NO_SHARES),
    (metrics.gap_ms, "slots", (*NO_TABLES, RUN.slots.reshape(1, -1))),
    (lambda ignore_last: metrics.gap_ms(RUN.slots, ignore_last), "ignore_last", NO_WHOLES),
    (lambda slots: metrics.settle_ms(slots, [1], 9, 1), "slots", NO_TABLES),
    (lambda slots: metrics.recovery_ms(slots, [1], 9, 1), "slots", NO_TABLES),
    (
        lambda steps_ms: metrics.settle_ms(RUN.slots, steps_ms, 9, 1),
        "steps_ms",
        ([1.5], *NO_TABLES[:4]),
    ),
    (lambda phase_ms: metrics.recovery_ms(RUN.slots, [1], phase_ms, 1), "phase_ms", NO_WHOLES),
    (lambda bound_us: metrics.settle_ms(RUN.slots, [1], 9, bound_us), "bound_us", NO_SHARES),
    (metrics.load, "packages", NO_TABLES),
]


@pytest.mark.parametrize(("call", "field", "values"), DOORS)
def test_argument_of_any_kind_is_named(
    call: Callable[..., Any],
    field: str,
    values: tuple[Any, ...],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    for value in values:
        with pytest.raises((TypeError, ValueError), match=rf"^{field} = .+: "):
            call(**{field: value})
    assert not list(tmp_path.iterdir())


def test_a_refusal_of_a_long_value_is_short() -> None:
    for value, opening in (
        (np.zeros((400, 400)), "active = array([[0., 0., "),
        (10**5000, "active = <int>"),
    ):
        call = partial(score, CORNERS, SCENE, active=value)
        refused(call, opening, by=ValueError)
        with pytest.raises(ValueError) as caught:
            call()
        assert len(str(caught.value)) < 400


def test_scene_of_no_kind_is_named_before_an_algorithm_is_made() -> None:
    for scene in (None, "x", 1.5, np.ones(2)):
        refused(partial(keep_curve, nothing, scene), "scene")


def test_masked_events_are_refused_by_every_door() -> None:
    masked = np.ma.masked_array(EVENTS.copy())
    masked["x"][3] = np.ma.masked
    for call in (
        lambda: asap.simulate(masked, cost=COST),
        lambda: asap.simulate([EVENTS, masked], cost=COST),
        lambda: asap.Pipeline().push(masked),
        lambda: asap.check(masked),
        lambda: analysis.rate(masked, 100),
        lambda: analysis.describe([masked]),
        lambda: synthetic.joined([EVENTS, masked]),
        lambda: metrics.load(np.ma.masked_array(RUN.packages, True)),
    ):
        with pytest.raises(ValueError, match=r"^\w+ = masked array: .{10,}"):
            call()
    for call in (CORNERS.process, TRACKER.process):
        refused(partial(call, masked), "events = masked array of shape (5,)", DTYPE)


@pytest.mark.parametrize(
    ("call", "field"),
    [
        (lambda cls: asap.run(EVENTS, algorithm=cls), "algorithm"),
        (lambda cls: asap.simulate(EVENTS, cost=COST, algorithm=cls), "algorithm"),
        (lambda cls: asap.simulate(EVENTS, cost=COST, before=cls), "before"),
        (asap.Pipeline, "algorithm"),
        (lambda cls: asap.Pipeline(before=cls), "before"),
        (lambda cls: score(cls, SCENE), "tracker"),
        (
            lambda cls: score(asap.ClusterTracker(64, 48), SCENE, before=cls),
            "before",
        ),
    ],
)
def test_class_is_no_object_of_it(call: Callable[[type], object], field: str) -> None:
    refused(lambda: call(asap.EFast), f"{field} = {asap.EFast!r}", "EFast(346, 260)")


SOURCES = [
    lambda source: asap.simulate(source, cost=COST),
    lambda source: asap.run(source, algorithm=nothing),
    lambda source: asap.compare(source, cost=COST),
    lambda source: asap.oracle(source, cost=COST, latency_ms=10),
]


@pytest.mark.parametrize("call", SOURCES)
def test_source_is_never_none_but_may_be_empty(call: Callable[[Any], Any]) -> None:
    refused(lambda: call(None), "source = None")
    call([])
    call(EVENTS[:0])


@pytest.mark.parametrize("call", [asap.as_events, *SOURCES])
def test_method_that_was_not_called_is_told_so(call: Callable[[Any], Any]) -> None:
    stream = synthetic.FlightOverChairs(duration_s=0.01)
    refused(lambda: call(stream.events), "source = <bound method ", "events()")
    refused(lambda: call(scenes.A), "source = <function A ", "A()")


@pytest.mark.parametrize(
    ("call", "field"),
    [
        (asap.Pipeline().push, "events"),
        (lambda events: analysis.rate(events, 100), "events"),
        (lambda events: analysis.describe([events]), "blocks"),
        (lambda events: pytest.importorskip("asap.plots").frame(events, 9, 9), "events"),
        (lambda events: pytest.importorskip("asap.plots").rate(events), "events"),
    ],
)
def test_events_are_refused_by_the_name_of_the_argument(
    call: Callable[[Any], object], field: str
) -> None:
    for value, opening, remedy in (
        ("a.npy", " = 'a.npy'", "asap.load"),
        (5, " = 5", "array"),
        (np.zeros(5), " is an array of float64, shape (5,)", "give"),
        (EVENTS[["t", "x"]], "", "no field for y"),
    ):
        refused(partial(call, value), f"{field}{opening}", remedy)
    with pytest.raises(ValueError, match=r"^order = None: "):
        call(np.zeros((5, 4)))


@pytest.mark.parametrize("kind", ["pipe", "device", "socket"])
def test_what_is_no_file_is_refused_and_not_waited_for(kind: str, tmp_path: Path) -> None:
    path = tmp_path / kind
    if kind == "pipe":
        os.mkfifo(path)
        end = os.open(path, os.O_RDWR)  # or whoever opens it waits
        os.write(end, b"1 2 3 1\n" * 6000)
    elif kind == "device":
        path = Path(os.devnull)
    else:
        server = socket.socket(socket.AF_UNIX)
        server.bind(os.path.relpath(path))  # a long one does not fit
    for call in (
        asap.read,
        asap.load,
        asap.check,
        asap.load_run,
        lambda path: asap.run(path, algorithm=nothing),
        lambda path: asap.simulate(path, cost=COST),
        lambda path: asap.compare(path, cost=COST),
    ):
        with pytest.raises(OSError, match=r"no regular file; .{10,}") as caught:
            call(path)
        assert caught.value.filename == str(path)
    if kind == "pipe":
        os.close(end)
    elif kind == "socket":
        server.close()
