"""The bindings of surfaces, corners, filters and images; tests/cpp tests the rules."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import asap
import streams
from asap import (
    EventImage,
    HotPixelMask,
    SpeedInvariantTimeSurface,
    ThresholdOrdinalSurface,
)
from golden import golden_stream

WIDTH, HEIGHT = 346, 260


def make(algorithm: Any, width: int = WIDTH, height: int = HEIGHT) -> Any:
    parameters = {"count": 1000} if algorithm is EventImage else {}
    return algorithm(width, height, **parameters)


SURFACES = [ThresholdOrdinalSurface, SpeedInvariantTimeSurface]


@pytest.mark.parametrize(
    ("kind", "dtype"),
    [(ThresholdOrdinalSurface, np.uint8), (SpeedInvariantTimeSurface, np.uint16)],
)
def test_a_surface_has_a_row_for_each_y(kind: Any, dtype: Any) -> None:
    one = kind(WIDTH, HEIGHT)
    assert one.process(golden_stream()) is None
    surface = one.surface
    assert (surface.dtype, surface.shape) == (dtype, (HEIGHT, WIDTH))
    x, y = golden_stream()[-1][["x", "y"]]
    assert surface[y, x] == surface.max()


def test_a_corner_or_not_and_the_events_that_pass() -> None:
    corners = asap.EFast(WIDTH, HEIGHT).process(golden_stream())
    assert corners.dtype == np.bool_ and np.count_nonzero(corners) == 694
    events = np.array([(5, 5, 1, 0), (30, 7, 0, 10), (6, 4, 1, 20)], asap.EVENT_DTYPE)
    passed = asap.BackgroundActivityFilter(WIDTH, HEIGHT).process(events)
    assert passed.tolist() == [(6, 4, 1, 20)] and passed.flags.writeable


@pytest.mark.parametrize("kind", SURFACES)
def test_a_surface_is_a_copy(kind: Any) -> None:
    one = kind(9, 5)
    before = one.surface
    one.process(streams.make([0], x=8, y=4))
    assert before.sum() == 0
    assert np.argwhere(one.surface).tolist() == [[4, 8]]


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
