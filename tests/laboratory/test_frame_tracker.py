"""The rival that tracks images of events: its components, its tracks, its clock."""

from __future__ import annotations

import numpy as np
import pytest

import streams
from fake_scene import FakeScene

pytest.importorskip("scipy", reason="the images are scipy's")

from asap_laboratory.rivals import frames
from asap_laboratory.rivals.frames import FrameTracker

MS = 1000


def components(pixels: np.ndarray, neighbours: int = 1) -> np.ndarray:
    return frames.components(pixels, neighbours)


def tracker_of(width: int = 80, height: int = 60) -> FrameTracker:
    return FrameTracker(width, height, period_us=10 * MS, neighbours=1)


def image(*squares: tuple[int, int, int]) -> np.ndarray:
    """Full squares, each by its left top corner and its side."""
    pixels = np.zeros((60, 80), np.uint8)
    for x, y, side in squares:
        pixels[y : y + side, x : x + side] = 1
    return pixels


def square(t_us: int, x: int, y: int = 20, side: int = 5) -> np.ndarray:
    """Every pixel of a square, one event each, at one time."""
    columns, rows = np.meshgrid(np.arange(x, x + side), np.arange(y, y + side))
    return streams.make(np.full(side * side, t_us), columns.ravel(), rows.ravel(), 1)


# ---- components -----------------------------------------------------------------------------


def test_pixels_without_neighbours_are_noise() -> None:
    pixels = image((10, 20, 5))
    pixels[21, 16] = pixels[23, 16] = pixels[5, 5] = 1
    assert components(pixels).tolist() == [[12, 22]]
    pixels[22, 16] = 1  # three in a column: the middle one has two neighbours, the others one
    assert components(pixels).tolist() == [[13, 22]]
    assert components(pixels, 2).tolist() == [[13, 22]]
    assert components(pixels, 3).tolist() == [[12, 22]]


def test_what_is_near_is_one_component_and_what_is_small_is_none() -> None:
    for x in range(10, 10 + frames._CELL_PX):
        near, far = x + 5 + frames._CELL_PX - 1, x + 5 + 2 * frames._CELL_PX
        assert len(components(image((x, 20, 5), (near, 20, 5)))) == 1
        assert len(components(image((x, 20, 5), (far, 20, 5)))) == 2
    assert components(image((10, 20, 3))).size == 0


# ---- tracks ---------------------------------------------------------------------------------


def test_a_track_is_told_when_it_was_seen_often_enough_and_moves_on() -> None:
    tracker = tracker_of()
    for step in range(8):
        tracker.process(square(step * 10 * MS, 10 + step))  # 100 px/s
        seen = tracker.clusters_at((step + 1) * 10 * MS - 1)
        assert seen.size == (step > frames._CONFIRM - 1)  # the image of this step is not full
    (one,) = tracker.clusters_at(80 * MS)
    assert (one["id"], one["y"], one["vy"]) == (0, 22, 0)
    assert one["x"] == pytest.approx(19, abs=0.5) and one["vx"] == pytest.approx(100, rel=0.1)
    later = tracker.clusters_at(85 * MS)[0]
    assert later["x"] - one["x"] == pytest.approx(5e-3 * one["vx"])


def test_an_id_outlives_a_gap_and_ends_after_it() -> None:
    tracker = tracker_of()
    ids = []
    for step in range(30):
        if step < 10 or 10 + frames._MISSES <= step + 1 < 20:
            tracker.process(square(step * 10 * MS, 10))
        ids.append(tracker.clusters_at((step + 1) * 10 * MS)["id"].tolist())
    assert ids[9] == ids[10] == ids[18] == [0]
    assert ids[19 + frames._MISSES] == []


def test_two_that_come_near_keep_their_ids() -> None:
    """The Hungarian method: the nearest pair first would leave one without a component."""
    tracker = tracker_of()
    for step in range(8):
        left, right = square(step * 10 * MS, 10 + step), square(step * 10 * MS, 40 - step)
        tracker.process(np.concatenate([left, right]))
    told = tracker.clusters_at(80 * MS)
    assert told["id"].tolist() == [0, 1] and told["x"][0] < told["x"][1]
    assert told["vx"] == pytest.approx([100, -100], rel=0.2)


def test_packages_do_not_matter_and_asking_only_closes_full_images() -> None:
    scene = FakeScene([(50, 50, 200, 0)], end_us=200_001, step_us=50)
    events = scene.events.copy()
    i = np.arange(events.size)
    events["x"] += (7 * i % 9).astype(np.uint16)
    events["y"] += (5 * i % 8).astype(np.uint16)

    def told(size: int, ask: bool) -> np.ndarray:
        tracker = tracker_of(346, 260)
        for begin in range(0, events.size, size):
            tracker.process(events[begin : begin + size])
            if ask:
                tracker.clusters_at(int(events["t"][min(begin + size, events.size) - 1]))
        return tracker.clusters_at(200 * MS)

    whole = told(events.size, False)
    assert whole.size == 1
    for size, ask in ((1, True), (333, False), (1000, True)):
        np.testing.assert_array_equal(told(size, ask), whole)
