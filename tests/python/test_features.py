"""asap.FeatureTracker: the binding. The rule itself is tested in tests/cpp/algorithms."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import asap
from asap import EVENT_DTYPE, ArcStar, FeatureTracker, as_events
from golden import golden_stream
from threads import turns_meanwhile

TRACK_FIELDS = ["id", "x", "y", "vx", "vy", "size", "t_first", "t_last"]
WIDTH, HEIGHT = 346, 260
DETECTORS = ["arc_star", "e_fast", "e_harris", "fa_harris", "every_event"]


def runner(vx: float, vy: float, t0_us: int = 0) -> np.ndarray:
    """A corner that runs at (vx, vy) px/s for 0.3 s, three pixels wide, once per ms."""
    t = np.repeat(1000 * np.arange(300), 3)
    events = np.zeros(t.size, EVENT_DTYPE)
    events["t"] = t0_us + t
    events["x"] = np.rint(100 + vx * t * 1e-6 + np.tile([-1, 1, 0], 300))
    events["y"] = np.rint(100 + vy * t * 1e-6)
    return events


@pytest.mark.parametrize(("min_neighbours", "golden"), [(1, (11, 1973, 972)), (2, (4, 894, 410))])
def test_golden_vectors(min_neighbours: int, golden: tuple[int, int, int]) -> None:
    tracker = FeatureTracker(WIDTH, HEIGHT, min_neighbours=min_neighbours)
    tracker.process(golden_stream())
    tracks = tracker.tracks
    assert (len(tracks), tracks["x"].sum(), tracks["y"].sum()) == golden


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


def test_velocities_are_px_per_s() -> None:
    tracker = FeatureTracker(WIDTH, HEIGHT, detector="every_event")
    tracker.process(runner(300, -120, t0_us=1_600_000_000_000_000))
    (track,) = tracker.tracks
    assert (track["vx"], track["vy"]) == pytest.approx((300, -120), abs=15)


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


@pytest.mark.parametrize("detector", DETECTORS)
def test_the_stream_may_be_cut_anywhere_and_reset_starts_anew(detector: str) -> None:
    events = golden_stream()[:60_000]
    tracker = FeatureTracker(WIDTH, HEIGHT, detector=detector, min_neighbours=0)
    whole = tracker.process(events)
    tracker.process(np.array([(WIDTH, 0, 0, 10**9)], EVENT_DTYPE))
    assert tracker.rejected == 1
    tracker.reset()
    assert tracker.rejected == 0
    parts = [tracker.process(part) for part in np.array_split(events, 37)]
    assert np.concatenate(parts).tolist() == whole.tolist()
    assert tracker.process(events[:0]).shape == (0,)


def test_detectors_differ() -> None:
    taken = {
        name: np.count_nonzero(
            FeatureTracker(WIDTH, HEIGHT, detector=name).process(golden_stream()) >= 0
        )
        for name in DETECTORS
    }
    assert len(set(taken.values())) == len(DETECTORS)
    assert max(taken, key=lambda name: taken[name]) == "every_event"


@pytest.mark.parametrize("bad", [-0.1, 1.1, float("nan")])
def test_keep_is_checked(bad: float) -> None:
    tracker = FeatureTracker(WIDTH, HEIGHT)
    tracker.set_keep(0)
    with pytest.raises(ValueError, match="gamma = "):
        tracker.set_keep(bad)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: FeatureTracker(0, 10), "width = 0: "),
        (lambda: FeatureTracker(10, 20_000), "height = 20000: "),
        (lambda: FeatureTracker(10, 10, detector="harris"), "detector = 'harris': .*arc_star"),
        (lambda: FeatureTracker(10, 10, window=0), "window = 0: "),
        (lambda: FeatureTracker(10, 10, radius=-1), "radius = -1: "),
        (lambda: FeatureTracker(10, 10, min_neighbours=8), "min_neighbours = 8: "),
        (lambda: FeatureTracker(10, 10, velocity_us=0), "velocity_us = 0: "),
    ],
)
def test_bad_parameters_are_named(make: Callable[[], object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make()


def test_numbers_that_are_not_whole_are_refused() -> None:
    bad: Any = float("nan")
    with pytest.raises(TypeError):
        FeatureTracker(10, 10, radius=bad)
    with pytest.raises(TypeError):
        FeatureTracker(10, 10, "arc_star")  # type: ignore[misc]


def test_parameters_rebuild_the_tracker() -> None:
    parameters = {
        "detector": "e_fast",
        "window": 50,
        "radius": 4,
        "min_neighbours": 0,
        "velocity_us": 5000,
    }
    tracker = FeatureTracker(WIDTH, HEIGHT, **parameters)
    assert (tracker.width, tracker.height, tracker.name) == (WIDTH, HEIGHT, "features")
    assert tracker.parameters == parameters


def test_other_arrays_are_refused() -> None:
    tracker = FeatureTracker(WIDTH, HEIGHT)
    packed = np.zeros(100, [("x", "<u2"), ("y", "<u2"), ("p", "<i2"), ("t", "<i8")])
    with pytest.raises(TypeError, match="as_events"):
        tracker.process(packed)
    tracker.process(as_events(packed))


def test_simulate_drives_it_natively() -> None:
    events = golden_stream()[:60_000]
    tracker = FeatureTracker(WIDTH, HEIGHT)
    run = asap.simulate(events, cost=asap.LinearCost(0, 10), algorithm=tracker)
    assert run.kept == 1
    assert run.algorithm is tracker
    assert run.summary()["algorithm"]["name"] == "features"
    alone = FeatureTracker(WIDTH, HEIGHT)
    alone.process(events)
    assert tracker.tracks.tobytes() == alone.tracks.tobytes()
    assert len(alone.tracks) > 0


def test_other_threads_run_meanwhile() -> None:
    events = np.tile(golden_stream(), 10)
    tracker = FeatureTracker(WIDTH, HEIGHT)
    assert turns_meanwhile(lambda: tracker.process(events)) > 2
