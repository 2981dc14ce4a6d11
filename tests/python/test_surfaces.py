"""The bindings of surfaces, flow, images and hot-pixel mask; tests/cpp tests the rules."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import asap
import streams
from asap import (
    EVENT_DTYPE,
    EventImage,
    HotPixelMask,
    PlaneFlow,
    SpeedInvariantTimeSurface,
    ThresholdOrdinalSurface,
)
from asap._core import is_native
from golden import golden_stream
from threads import turns_meanwhile

WIDTH, HEIGHT = 346, 260


def make(algorithm: Any, width: int = WIDTH, height: int = HEIGHT) -> Any:
    parameters = {"count": 1000} if algorithm is EventImage else {}
    return algorithm(width, height, **parameters)


SURFACES = [ThresholdOrdinalSurface, SpeedInvariantTimeSurface]
ALL = [*SURFACES, PlaneFlow, EventImage, HotPixelMask]
OLDER = [
    asap.ClusterTracker,
    asap.BackgroundActivityFilter,
    asap.EFast,
    asap.ArcStar,
    asap.EHarris,
    asap.FAHarris,
]


@pytest.mark.parametrize(
    ("kind", "dtype", "total", "fired"),
    [
        (ThresholdOrdinalSurface, np.uint8, 3_701_507, 14_803),
        (SpeedInvariantTimeSurface, np.uint16, 3_538_452, 32_952),
    ],
)
def test_golden_vectors(kind: Any, dtype: Any, total: int, fired: int) -> None:
    one = kind(WIDTH, HEIGHT)
    assert one.process(golden_stream()) is None
    surface = one.surface
    assert surface.dtype == dtype
    assert surface.shape == (HEIGHT, WIDTH)
    assert (surface.sum(), np.count_nonzero(surface)) == (total, fired)
    x, y = golden_stream()[-1][["x", "y"]]
    assert surface[y, x] == surface.max()


@pytest.mark.parametrize("kind", SURFACES)
def test_a_surface_is_a_copy(kind: Any) -> None:
    one = kind(9, 5)
    before = one.surface
    one.process(streams.make([0], x=8, y=4))
    assert before.sum() == 0
    assert np.argwhere(one.surface).tolist() == [[4, 8]]


def test_flow_of_an_edge() -> None:
    y, x = np.divmod(np.arange(1200), 40)
    t = 400 * x + 300 * y
    order = np.argsort(t, kind="stable")
    flow = PlaneFlow(40, 30).process(streams.make(t[order], x[order], y[order], 1))
    assert flow.dtype == np.float32
    assert flow.shape == (1200, 2)
    found = np.isfinite(flow).all(axis=1)
    assert found.sum() > 900
    assert np.isnan(flow[~found]).all()
    np.testing.assert_allclose(flow[found], [[1600.0, 1200.0]] * found.sum(), rtol=1e-5)


def test_images_by_count() -> None:
    events = golden_stream()[:2500]
    image = EventImage(WIDTH, HEIGHT, count=1000, channels=("on", "off", "sum", "count", "time"))
    images, spans = image.process(events)
    assert (images.dtype, images.shape) == (np.float32, (2, 5, HEIGHT, WIDTH))
    assert spans.tolist() == [[10, 10_001], [10_010, 20_001]]
    for number, (on, off, signed, count, time) in enumerate(images):
        part = events[1000 * number : 1000 * (number + 1)]
        expected = np.zeros((2, HEIGHT, WIDTH))
        np.add.at(expected, (part["p"], part["y"], part["x"]), 1)
        assert np.array_equal([off, on], expected)
        assert np.array_equal(signed, on - off)
        assert np.array_equal(count, on + off)
        assert np.array_equal(time > 0, count > 0)
        assert time.max() == 1
    assert np.array_equal(image.image, images[-1])
    assert image.span == (10_010, 20_001)
    assert image.flush()
    assert image.image[3].sum() == 500
    assert not image.flush()


def test_images_by_period() -> None:
    image = EventImage(9, 5, period_us=100)
    images, spans = image.process(streams.make([7, 99, 100, 950], x=8, y=4, p=[1, 0, 1, 1]))
    assert spans.tolist() == [[0, 100], [100, 200]]
    assert images[:, :, 4, 8].tolist() == [[1, 1], [0, 1]]
    nothing, none = image.process(streams.make([]))
    assert (nothing.shape, none.shape) == ((0, 2, 5, 9), (0, 2))


def test_an_image_behind_a_discarder_holds_as_much() -> None:
    image = EventImage(WIDTH, HEIGHT, count=1000)
    image.set_keep(0.25)
    images, _ = image.process(golden_stream()[:500])
    assert images.sum(axis=(1, 2, 3)).tolist() == [1000, 1000]


def test_the_mask_drops_given_and_learned_pixels() -> None:
    hot = streams.make(np.arange(200), x=7, y=3)
    calm = golden_stream()[:2000]
    given = HotPixelMask(WIDTH, HEIGHT, pixels=[(7, 3)], learn_events=0)
    assert len(given.process(hot)) == 0
    assert given.process(calm).tolist() == calm.tolist()

    learned = HotPixelMask(WIDTH, HEIGHT)
    assert learned.learn(np.concatenate([calm, hot])) == 1
    assert learned.pixels == given.pixels == [(7, 3)]

    on_the_way = HotPixelMask(WIDTH, HEIGHT, learn_events=200)
    assert len(on_the_way.process(hot)) == 200
    assert len(on_the_way.process(hot)) == 0
    on_the_way.reset()
    assert on_the_way.pixels == []


def test_the_mask_agrees_with_check() -> None:
    events = np.concatenate(
        [golden_stream(), streams.make(np.arange(900), x=[70, 71, 200] * 300, y=3)]
    )
    events["t"] = np.arange(len(events))
    mask = HotPixelMask(WIDTH, HEIGHT)
    mask.learn(events)
    found = asap.check(events, width=WIDTH, height=HEIGHT).hot_pixels[["x", "y"]].tolist()
    assert mask.pixels == sorted(found, key=lambda pixel: pixel[::-1])
    assert HotPixelMask(WIDTH, HEIGHT, pixels=found).pixels == mask.pixels


@pytest.mark.parametrize("algorithm", ALL)
@pytest.mark.parametrize("bad", [-0.1, 1.1, float("nan")])
def test_keep_is_checked(algorithm: Any, bad: float) -> None:
    one = make(algorithm)
    one.set_keep(0)
    one.set_keep(1)
    with pytest.raises(ValueError, match="gamma = "):
        one.set_keep(bad)


@pytest.mark.parametrize("algorithm", ALL)
def test_events_outside_the_frame_are_counted(algorithm: Any) -> None:
    one = make(algorithm, 20, 10)
    one.process(np.array([(20, 0, 0, 0), (0, 10, 0, 0), (65535, 65535, 0, 0)], EVENT_DTYPE))
    assert one.rejected == 3
    one.reset()
    assert one.rejected == 0


@pytest.mark.parametrize(
    ("make_one", "message"),
    [
        (lambda: ThresholdOrdinalSurface(0, 10), "width = 0: "),
        (lambda: ThresholdOrdinalSurface(10, 10, side=8), "side = 8: "),
        (lambda: SpeedInvariantTimeSurface(10, 10, radius=0), "radius = 0: "),
        (lambda: PlaneFlow(10, 10, window_us=0), "window_us = 0: "),
        (lambda: PlaneFlow(10, 10, min_points=26), "min_points = 26: "),
        (lambda: EventImage(10, 10), "count = 0: give either"),
        (lambda: EventImage(10, 10, count=5, period_us=5), "count = 5: give either"),
        (lambda: EventImage(10, 10, count=5, channels=("on", "red")), "channels = 'red': "),
        (lambda: EventImage(10, 10, count=5, channels=()), r"channels.size\(\) = 0: "),
        (lambda: HotPixelMask(10, 10, pixels=[(3, 10)]), "pixels: y = 10: "),
        (lambda: HotPixelMask(10, 10, learn_events=-1), "learn_events = -1: "),
    ],
)
def test_bad_parameters_are_named(make_one: Callable[[], object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make_one()


@pytest.mark.parametrize(
    ("algorithm", "name", "parameters"),
    [
        (ThresholdOrdinalSurface, "threshold_ordinal_surface", {"side": 5}),
        (SpeedInvariantTimeSurface, "speed_invariant_time_surface", {"radius": 2}),
        (PlaneFlow, "plane_flow", {"window_us": 700, "min_points": 4, "refit": False}),
        (PlaneFlow, "plane_flow", {"window_us": 700, "min_points": 4, "refit": None}),
        (EventImage, "event_image", {"count": 0, "period_us": 9, "channels": ("time",)}),
        (HotPixelMask, "hot_pixels", {"pixels": ((3, 4),), "learn_events": 0}),
    ],
)
def test_parameters_rebuild_the_algorithm(
    algorithm: Any, name: str, parameters: dict[str, Any]
) -> None:
    one = algorithm(WIDTH, HEIGHT, **parameters)
    assert (one.width, one.height, one.name) == (WIDTH, HEIGHT, name)
    assert one.parameters == parameters
    with pytest.raises(TypeError):
        algorithm(WIDTH, HEIGHT, 5)


@pytest.mark.parametrize("algorithm", ALL)
def test_other_arrays_are_refused(algorithm: Any) -> None:
    one = make(algorithm)
    events = golden_stream()[:100]
    packed = np.zeros(100, [("x", "<u2"), ("y", "<u2"), ("p", "<i2"), ("t", "<i8")])
    methods = [one.process, one.learn] if algorithm is HotPixelMask else [one.process]
    for bad in (packed, events[::2], events.reshape(10, 10), events["x"]):
        for method in methods:
            with pytest.raises(TypeError, match="as_events"):
                method(bad)


@pytest.mark.parametrize("algorithm", ALL)
def test_other_threads_run_meanwhile(algorithm: Any) -> None:
    events = np.tile(golden_stream(), 20)
    one = algorithm(WIDTH, HEIGHT, count=100_000) if algorithm is EventImage else make(algorithm)
    assert turns_meanwhile(lambda: one.process(events)) > 2


@pytest.mark.parametrize("algorithm", [*OLDER, *ALL])
def test_it_runs_natively_and_is_told_what_is_kept(algorithm: Any) -> None:
    one = make(algorithm)
    assert is_native(one)
    run = asap.simulate(golden_stream()[:20_000], cost=asap.LinearCost(10, 2), algorithm=one)
    assert run.ledger["delivered"] == 20_000
    assert run.algorithm is one
    outside = streams.make([0], x=[998])
    asap.simulate(outside, cost=asap.LinearCost(10, 2), algorithm=one)
    assert one.rejected == 1


@pytest.mark.parametrize("algorithm", SURFACES)
def test_packages_make_the_same_surface(algorithm: Any) -> None:
    packages, whole = make(algorithm), make(algorithm)
    asap.simulate(golden_stream()[:20_000], cost=asap.LinearCost(10, 2), algorithm=packages)
    whole.process(golden_stream()[:20_000])
    assert np.array_equal(packages.surface, whole.surface)


def test_packages_make_images_that_know_what_was_discarded() -> None:
    image = make(EventImage)
    cost = asap.LinearCost(100, 30_000)  # a third of the events fits
    run = asap.simulate(golden_stream(), cost=cost, algorithm=image, latency_ms=10)
    assert run.kept < 0.5
    assert image.image.sum() == pytest.approx(1000, abs=4)
    begin, end = image.span
    assert end - begin == pytest.approx(10_000, rel=0.3)  # as without a discarder


def test_a_derived_class_is_not_native() -> None:
    class Corners(asap.EFast):
        found = 0

        def process(self, events: Any) -> Any:
            labels = super().process(events)
            self.found += int(labels.sum())
            return labels

    corners = Corners(WIDTH, HEIGHT)
    assert not is_native(corners)
    asap.simulate(golden_stream(), cost=asap.LinearCost(1, 1), algorithm=corners)
    assert corners.found == 694


def test_the_mask_in_front() -> None:
    events = golden_stream()[:20_000]
    x, y = events[0][["x", "y"]].tolist()
    masked = int(((events["x"] == x) & (events["y"] == y)).sum())

    class Double(HotPixelMask):
        calls = 0

        def process(self, events: Any) -> Any:
            self.calls += 1
            return super().process(events)

    mask, double = (kind(WIDTH, HEIGHT, pixels=[(x, y)]) for kind in (HotPixelMask, Double))
    cost = asap.LinearCost(10, 2)
    runs = [asap.simulate(events, cost=cost, before=before) for before in (mask, double)]
    assert [run.ledger["filtered"] for run in runs] == [masked, masked]
    assert double.calls > 0
