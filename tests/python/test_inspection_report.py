"""An inspection as figure and as page."""

import numpy as np
import pytest

import asap
import corrupt

pytest.importorskip("matplotlib")


EVENTS = corrupt.clean_events(20_000)


def inspect(events):
    return asap.check(events, width=corrupt.WIDTH, height=corrupt.HEIGHT)


@pytest.fixture(scope="module")
def inspection():
    bad = corrupt.back_steps(EVENTS, 30)
    bad["x"][::50], bad["y"][::50] = 30, 40
    bad["x"][1::50], bad["y"][1::50] = 300, 200
    return inspect(bad)


def circles(axes):
    return [tuple(place) for one in axes.collections for place in one.get_offsets()]


def test_the_rate_is_that_of_the_inspection(inspection):
    rate, *_ = inspection.plot().axes
    (line,) = rate.lines
    time_s, mean_hz, _ = inspection.rate_curve.T
    np.testing.assert_array_equal(line.get_xdata(), time_s)
    np.testing.assert_allclose(line.get_ydata(), mean_hz / 1e3)
    assert rate.get_ylabel() == "kev/s" and line.get_label() == "in 1 ms"


def test_hot_pixels_have_circles(inspection):
    pixels = inspection.plot().axes[2]
    assert sorted(circles(pixels)) == [(30, 40), (300, 200)]
    assert pixels.get_title(loc="left") == "hot pixels: 2, with 4.0 % of the events"
    (picture,) = pixels.images
    np.testing.assert_array_equal(picture.get_array().filled(0), inspection.pixel_counts)
    assert pixels.get_ylim() == (259.5, -0.5)  # y down
