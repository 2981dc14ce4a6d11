"""asap.PublishedClusterTracker: the binding. The rule is tested in tests/cpp/algorithms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from asap import EVENT_DTYPE, PublishedClusterTracker
from test_cluster_tracker import FIELDS

WIDTH, HEIGHT = 346, 260


def events_at(x: Any, y: Any, t: Any) -> np.ndarray:
    """Events in EVENT_DTYPE from columns."""
    x, y, t = np.broadcast_arrays(x, y, t)
    events = np.zeros(len(t), EVENT_DTYPE)
    events["x"], events["y"], events["t"] = x, y, t
    return events


def two_blobs(count: int = 6000, seed: int = 0, start_us: int = 0) -> np.ndarray:
    """Two blobs of uniform events, 50 us apart: one moves at (200, -100) px/s, one stands still."""
    random = np.random.default_rng(seed)
    t = 50 * np.arange(count)
    first = random.random(count) < 0.5
    offset = random.uniform(-5, 5, (2, count))
    x = np.where(first, 60 + 200e-6 * t, 280) + offset[0]
    y = np.where(first, 200 - 100e-6 * t, 60) + offset[1]
    return events_at(x.astype(np.uint16), y.astype(np.uint16), t + start_us)


def test_finds_two_blobs_with_their_motion() -> None:
    tracker = PublishedClusterTracker(WIDTH, HEIGHT, window=4000)
    tracker.process(two_blobs(start_us=1_600_000_000_000_000))
    moving, still = np.sort(tracker.clusters, order="x")
    # The window's 4000 events are the last 0.2 s of 0.3 s: their middle lies at 0.2 s.
    assert moving["x"] == pytest.approx(60 + 200 * 0.2, abs=1)
    assert moving["y"] == pytest.approx(200 - 100 * 0.2, abs=1)
    assert (moving["vx"], moving["vy"]) == pytest.approx((200, -100), abs=10)
    assert (still["vx"], still["vy"]) == pytest.approx((0, 0), abs=10)
    assert still["cxx"] == pytest.approx(100 / 12, rel=0.1)  # uniform over 10 px
    assert still["cyy"] == pytest.approx(100 / 12, rel=0.1)
    assert moving["size"] + still["size"] == 4000
    assert moving["cxy"] < -10  # smeared along its path


def test_clusters_are_a_structured_array_sorted_by_id() -> None:
    tracker = PublishedClusterTracker(WIDTH, HEIGHT)
    empty = tracker.clusters
    assert empty.shape == (0,)
    tracker.process(two_blobs())
    clusters = tracker.clusters
    assert list(clusters.dtype.names or ()) == FIELDS
    assert empty.dtype == clusters.dtype
    integers = {"id", "size", "t_last"}
    for name in FIELDS:
        assert clusters.dtype[name] == (np.int64 if name in integers else np.float64)
    assert np.all(np.diff(clusters["id"]) > 0)
    assert np.all(clusters["size"] >= 15)
