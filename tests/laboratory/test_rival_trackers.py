"""The rivals of the cluster tracker, behind its face. Each rule is tested natively."""

import numpy as np
import pytest

import asap
import streams
from asap_laboratory import _native


@pytest.fixture
def tracker():
    return _native.JaerClusterTracker(120, 80)


@pytest.fixture(scope="module")
def events():
    """A square of 9 px that moves by 100 px/s, one event every 50 us."""
    count = 4000
    i = np.arange(count)
    made = streams.make(50 * i)
    made["x"] = np.round(20 + 100 * 50e-6 * i + (5 * i) % 9 - 4)
    made["y"] = 40 + (7 * i) % 9 - 4
    return made


def test_it_has_the_face_of_the_tracker(tracker, events):
    ids = tracker.process(events)
    assert ids.dtype == np.int32 and set(ids[1000:].tolist()) == {0}
    ours = asap.ClusterTracker(120, 80)
    assert tracker.clusters.dtype == ours.clusters.dtype
    (row,) = tracker.clusters
    assert (row["id"], row["t_last"]) == (0, events["t"][-1])
    assert row["x"] == pytest.approx(40, abs=2) and row["vx"] == pytest.approx(100, rel=0.3)
    (later,) = tracker.clusters_at(int(events["t"][-1]) + 1000)
    assert later["x"] == pytest.approx(row["x"] + 0.001 * row["vx"], abs=0.01)
    assert (tracker.width, tracker.height, tracker.rejected) == (120, 80, 0)
    assert tracker.name == "jaer-type core" and not hasattr(tracker, "set_gamma")


def test_reset_begins_anew_and_labels_are_not_made_unasked(tracker, events):
    ids = tracker.process(events)
    tracker.reset()
    assert tracker.clusters.size == 0
    assert tracker.process(events, labels=False) is None
    assert tracker.clusters["id"].tolist() == [0]
    tracker.reset()
    np.testing.assert_array_equal(tracker.process(events), ids)
