"""asap.ClusterTracker: the binding. The tracker is tested in tests/cpp/algorithms."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import asap
from asap import EVENT_DTYPE, ClusterTracker, synthetic

WIDTH, HEIGHT = 346, 260
FIELDS = ["id", "x", "y", "vx", "vy", "cxx", "cxy", "cyy", "size", "t_last", "pxx", "pxy", "pyy"]


def disk(start_s: float, end_s: float, *, vx: float = 100.0, seed: int = 0) -> np.ndarray:
    """The outline of a disk at (60 + vx t, 80), radius 8, 10 000 events per second."""
    random = np.random.default_rng(seed)
    t = np.arange(start_s, end_s, 1e-4)
    angle = random.uniform(0, 2 * np.pi, len(t))
    radius = 8 + random.uniform(-0.5, 0.5, len(t))
    events = np.zeros(len(t), EVENT_DTYPE)
    events["x"] = np.round(60 + vx * t + radius * np.cos(angle))
    events["y"] = np.round(80 + radius * np.sin(angle))
    events["p"] = np.cos(angle) > 0
    events["t"] = np.round(1e6 * t)
    return events


def test_follows_a_disk() -> None:
    tracker = ClusterTracker(WIDTH, HEIGHT)
    labels = tracker.process(disk(0, 0.5))
    assert labels.dtype == np.int32
    assert set(labels[-1000:].tolist()) <= {-1, 0}
    clusters = tracker.clusters
    assert list(clusters.dtype.names or ()) == FIELDS
    (cluster,) = clusters
    assert cluster["id"] == 0
    assert (cluster["x"], cluster["y"]) == pytest.approx((110, 80), abs=1)
    assert (cluster["vx"], cluster["vy"]) == pytest.approx((100, 0), abs=20)
    assert cluster["t_last"] == pytest.approx(499_900, abs=500)


OBJECT_FIELDS = ["id", "x", "y", "vx", "vy", "left", "top", "width", "height", "size", "t_last"]


def test_a_disk_is_one_object() -> None:
    tracker = ClusterTracker(WIDTH, HEIGHT)
    nothing = tracker.objects
    assert nothing.size == 0 and list(nothing.dtype.names or ())[:-2] == OBJECT_FIELDS
    labels = tracker.process(disk(0, 0.5))
    (found,) = tracker.objects
    assert found.dtype == nothing.dtype
    assert (found["x"], found["y"]) == pytest.approx((110, 80), abs=1)
    assert (found["vx"], found["vy"]) == pytest.approx((100, 0), abs=20)
    assert (found["left"], found["top"]) == pytest.approx((100, 70), abs=2)
    assert (found["width"], found["height"]) == pytest.approx((20, 20), abs=3)
    assert found["age_us"] == pytest.approx(495_000, abs=4_000)
    assert found["independent"] == -1
    (member,) = tracker.members(found["id"])
    assert np.mean(labels[-1000:] == member) > 0.8
    (ahead,) = tracker.objects_at(510_000)
    assert ahead["x"] == pytest.approx(found["x"] + 0.01 * found["vx"], abs=0.1)
    assert tracker.objects_at(10**9).size == 0


def test_an_id_that_is_gone_is_a_key_error() -> None:
    tracker = ClusterTracker(WIDTH, HEIGHT)
    tracker.process(disk(0, 0.5), labels=False)
    (id,) = tracker.objects["id"]
    tracker.advance_to(1_000_000)
    for ask in (tracker.members, tracker.outline):
        with pytest.raises(KeyError, match=f"id = {id}: no object"):
            ask(id)


def test_an_id_names_one_thing() -> None:
    scene = synthetic.FlightOverChairs(duration_s=2, seed=0)
    events = scene.events()
    tracker = ClusterTracker(scene.width, scene.height)
    founded = others = refused = 0
    for start in range(0, len(events), 5_000):
        labels = tracker.process(events[start : start + 5_000])
        objects, clusters = tracker.objects["id"], tracker.clusters["id"]
        for id in objects:
            members = tracker.members(id)
            founded += id in members
            others += id not in members and id in clusters
            assert set(tracker.to_objects(members.astype(np.int32))) == {id}
        for id in np.setdiff1d(clusters, objects):
            refused += 1
            for ask in (tracker.members, tracker.outline):
                with pytest.raises(KeyError, match=f"id = {id}: a cluster, no object"):
                    ask(id)
        assert set(tracker.to_objects(labels)) >= set(objects) & set(labels)
    assert (founded > 1_000, others, refused > 100) == (True, 0, True)


def test_an_outline_lies_around_its_cluster() -> None:
    tracker = ClusterTracker(WIDTH, HEIGHT)
    tracker.process(disk(0, 0.5), labels=False)
    (cluster,), (id,) = tracker.clusters, tracker.objects["id"]
    outline = tracker.outline(id)
    assert outline.dtype.names == ("x", "y", "major", "minor", "angle")
    assert (outline["x"], outline["y"]) == (cluster["x"], cluster["y"])
    major, minor = outline["major"], outline["minor"]
    assert major**2 + minor**2 == pytest.approx(4 * (cluster["cxx"] + cluster["cyy"]))
    assert major >= minor > 3
    assert pickle.loads(pickle.dumps(outline)) == outline


def test_counters() -> None:
    tracker = ClusterTracker(WIDTH, HEIGHT)
    events = np.zeros(3, EVENT_DTYPE)
    events["x"] = [0, 100, WIDTH]
    tracker.process(events)
    assert (tracker.rejected, tracker.unsupported, tracker.refused) == (1, 2, 0)
    full = ClusterTracker(WIDTH, HEIGHT, slots=1)
    events = np.concatenate([disk(0, 0.5), disk(0, 0.5, vx=400.0, seed=1)])
    events = events[np.argsort(events["t"], kind="stable")]
    run = asap.run(events, algorithm=full, latency_ms=100)
    assert full.refused > 0
    assert "give it more slots" in str(run)
