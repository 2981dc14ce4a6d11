"""The bindings of the corner detectors and BackgroundActivityFilter; tests/cpp tests the rules."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from asap import (
    EVENT_DTYPE,
    ArcStar,
    BackgroundActivityFilter,
    EFast,
    EHarris,
    FAHarris,
    as_events,
)
from golden import fnv, golden_stream
from threads import turns_meanwhile

WIDTH, HEIGHT = 346, 260
DETECTORS = [EFast, ArcStar, EHarris, FAHarris]
ALL = [BackgroundActivityFilter, *DETECTORS]


@pytest.mark.parametrize(
    ("detector", "corners", "hash_value"),
    [
        (EFast, 694, 0x61CE6DCB),
        (ArcStar, 7354, 0x287F6925),
        (FAHarris, 71, 0x9A2DAB8E),
        (EHarris, 724, 0x6DF63B99),
    ],
)
def test_golden_vectors(detector: Any, corners: int, hash_value: int) -> None:
    labels = detector(WIDTH, HEIGHT).process(golden_stream())
    assert labels.dtype == np.bool_
    assert np.count_nonzero(labels) == corners
    assert fnv(labels) == hash_value


@pytest.mark.parametrize(("window_us", "passed"), [(5000, 98_269), (1000, 38_473)])
def test_golden_filter(window_us: int, passed: int) -> None:
    events = golden_stream()
    kept = BackgroundActivityFilter(WIDTH, HEIGHT, window_us=window_us).process(events)
    assert kept.dtype == EVENT_DTYPE
    assert kept.shape == (passed,)
    assert np.isin(kept["t"], events["t"]).all()
    assert np.all(np.diff(kept["t"]) > 0)
    assert kept.flags.writeable


def test_the_filter_returns_whole_events() -> None:
    events = np.array([(5, 5, 1, 0), (30, 7, 0, 10), (6, 4, 1, 20)], EVENT_DTYPE)
    assert BackgroundActivityFilter(WIDTH, HEIGHT).process(events).tolist() == [(6, 4, 1, 20)]


def test_the_filter_widens_its_window_behind_a_discarder() -> None:
    events = np.array([(5, 5, 1, 0), (6, 4, 1, 20_000)], EVENT_DTYPE)
    kept = {}
    for gamma in (1, 0.3, 0.2, 0):
        background = BackgroundActivityFilter(WIDTH, HEIGHT)
        background.set_keep(gamma)
        kept[gamma] = len(background.process(events))
    assert kept == {1: 0, 0.3: 0, 0.2: 1, 0: 1}


@pytest.mark.parametrize("detector", DETECTORS)
def test_detectors_are_told_the_kept_fraction_without_effect(detector: Any) -> None:
    told = detector(WIDTH, HEIGHT)
    told.set_keep(0.2)
    events = golden_stream()[:60_000]
    assert np.array_equal(told.process(events), detector(WIDTH, HEIGHT).process(events))


@pytest.mark.parametrize("algorithm", ALL)
@pytest.mark.parametrize("bad", [-0.1, 1.1, float("nan")])
def test_keep_is_checked(algorithm: Any, bad: float) -> None:
    with pytest.raises(ValueError, match="gamma = "):
        algorithm(WIDTH, HEIGHT).set_keep(bad)


@pytest.mark.parametrize("algorithm", ALL)
def test_the_stream_may_be_cut_anywhere_and_reset_starts_anew(algorithm: Any) -> None:
    events = golden_stream()[:60_000]
    one = algorithm(WIDTH, HEIGHT)
    whole = one.process(events)
    assert 0 < np.count_nonzero(whole) <= len(events)
    one.process(np.array([(WIDTH, 0, 0, 10**9)], EVENT_DTYPE))
    assert one.rejected == 1
    one.reset()
    assert one.rejected == 0
    parts = [one.process(part) for part in np.array_split(events, 37)]
    assert np.concatenate(parts).tolist() == whole.tolist()
    assert one.process(events[:0]).shape == (0,)


@pytest.mark.parametrize("algorithm", ALL)
def test_events_outside_the_frame_are_counted(algorithm: Any) -> None:
    one = algorithm(20, 10)
    events = np.array([(20, 0, 0, 0), (0, 10, 0, 0), (65535, 65535, 0, 0)], EVENT_DTYPE)
    assert np.count_nonzero(one.process(events)) == 0
    assert one.rejected == 3


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: EFast(0, 10), "width = 0: "),
        (lambda: ArcStar(10, -3), "height = -3: "),
        (lambda: EHarris(20_000, 10), "width = 20000: "),
        (lambda: BackgroundActivityFilter(10, 0), "height = 0: "),
        (lambda: BackgroundActivityFilter(10, 10, window_us=-1), "window_us = -1: "),
        (lambda: BackgroundActivityFilter(10, 10, window_us=10**9), "window_us = 1000000000: "),
        (lambda: ArcStar(10, 10, filter_us=-1), "filter_us = -1: "),
        (lambda: FAHarris(10, 10, filter_us=-1), "filter_us = -1: "),
        (lambda: FAHarris(10, 10, threshold=float("nan")), "threshold = nan: "),
        (lambda: EHarris(10, 10, threshold=float("inf")), "threshold = inf: "),
    ],
)
def test_bad_parameters_are_named(make: Callable[[], object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.parametrize("algorithm", [BackgroundActivityFilter, ArcStar, EHarris, FAHarris])
def test_parameters_are_keyword_only(algorithm: Any) -> None:
    with pytest.raises(TypeError):
        algorithm(WIDTH, HEIGHT, 1000)


@pytest.mark.parametrize(
    ("algorithm", "name", "parameters"),
    [
        (BackgroundActivityFilter, "background_activity", {"window_us": 700}),
        (EFast, "e_fast", {}),
        (ArcStar, "arc_star", {"filter_us": 0}),
        (EHarris, "e_harris", {"threshold": 2.5}),
        (FAHarris, "fa_harris", {"filter_us": 0, "threshold": 2.5}),
    ],
)
def test_parameters_rebuild_the_algorithm(
    algorithm: Any, name: str, parameters: dict[str, Any]
) -> None:
    one = algorithm(WIDTH, HEIGHT, **parameters)
    assert (one.width, one.height, one.name) == (WIDTH, HEIGHT, name)
    assert one.parameters == parameters
    events = golden_stream()[:60_000]
    labels = one.process(events)
    if parameters:  # they arrive
        assert labels.tolist() != algorithm(WIDTH, HEIGHT).process(events).tolist()


@pytest.mark.parametrize("algorithm", ALL)
def test_other_arrays_are_refused(algorithm: Any) -> None:
    one = algorithm(WIDTH, HEIGHT)
    events = golden_stream()[:100]
    packed = np.zeros(100, [("x", "<u2"), ("y", "<u2"), ("p", "<i2"), ("t", "<i8")])
    for bad in (packed, events[::2], events.reshape(10, 10), events["x"]):
        with pytest.raises(TypeError, match="as_events"):
            one.process(bad)
    one.process(as_events(packed))


@pytest.mark.parametrize("algorithm", ALL)
def test_other_threads_run_meanwhile(algorithm: Any) -> None:
    events = np.tile(golden_stream(), 20)
    one = algorithm(WIDTH, HEIGHT)
    assert turns_meanwhile(lambda: one.process(events)) > 2
