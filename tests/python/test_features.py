"""asap.FeatureTracker: the binding. The rule itself is tested in tests/cpp/algorithms."""

from __future__ import annotations

import numpy as np

from asap import ArcStar, FeatureTracker
from golden import golden_stream

TRACK_FIELDS = ["id", "x", "y", "vx", "vy", "size", "t_first", "t_last"]
WIDTH, HEIGHT = 346, 260


def test_tracks_are_a_structured_array_sorted_by_id() -> None:
    tracker = FeatureTracker(WIDTH, HEIGHT)
    assert tracker.tracks.shape == (0,)
    labels = tracker.process(golden_stream())
    tracks = tracker.tracks
    assert list(tracks.dtype.names or ()) == TRACK_FIELDS
    assert np.all(np.diff(tracks["id"]) > 0)
    assert np.all(tracks["t_first"] <= tracks["t_last"])
    for track in tracks:
        taken = golden_stream()[labels == track["id"]]
        assert track["size"] == len(taken)
        assert (track["x"], track["y"]) == (taken["x"][-1], taken["y"][-1])
        assert (track["t_first"], track["t_last"]) == (taken["t"][0], taken["t"][-1])
    before = tracks.copy()
    tracker.reset()
    assert tracks.tobytes() == before.tobytes()


def test_labels_are_on_corners_only_and_optional() -> None:
    labels = FeatureTracker(WIDTH, HEIGHT).process(golden_stream())
    assert labels.dtype == np.int32
    assert labels.max() > 10
    corners = ArcStar(WIDTH, HEIGHT).process(golden_stream())
    assert np.all(labels[~corners] == -1)
    quiet = FeatureTracker(WIDTH, HEIGHT)
    assert quiet.process(golden_stream(), labels=False) is None
    tracker = FeatureTracker(WIDTH, HEIGHT)
    tracker.process(golden_stream())
    assert quiet.tracks.tobytes() == tracker.tracks.tobytes()
