"""asap.ClusterTracker(engine="compat"): the binding. The rule is tested in tests/cpp/algorithms."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import asap
from asap import EVENT_DTYPE, as_events
from threads import turns_meanwhile

CLUSTER_FIELDS = [
    "id",
    "x",
    "y",
    "vx",
    "vy",
    "cxx",
    "cxy",
    "cyy",
    "size",
    "t_last",
    "pxx",
    "pxy",
    "pyy",
]
WIDTH, HEIGHT = 346, 260
ClusterTracker = partial(asap.ClusterTracker, engine="compat")


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
    tracker = ClusterTracker(WIDTH, HEIGHT, window=4000)
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
    tracker = ClusterTracker(WIDTH, HEIGHT)
    empty = tracker.clusters
    assert empty.shape == (0,)
    tracker.process(two_blobs())
    clusters = tracker.clusters
    assert list(clusters.dtype.names or ()) == CLUSTER_FIELDS
    assert empty.dtype == clusters.dtype
    integers = {"id", "size", "t_last"}
    for name in CLUSTER_FIELDS:
        assert clusters.dtype[name] == (np.int64 if name in integers else np.float64)
    assert np.all(np.diff(clusters["id"]) > 0)
    assert np.all(clusters["size"] >= 15)


def test_clusters_are_not_changed_by_later_events() -> None:
    tracker = ClusterTracker(WIDTH, HEIGHT)
    events = two_blobs()
    tracker.process(events[:3000])
    clusters = tracker.clusters
    before = clusters.copy()
    tracker.process(events[3000:])
    assert np.array_equal(clusters, before)


def test_labels_are_ids() -> None:
    tracker = ClusterTracker(100, 100, radius=5, min_size=3)
    labels = tracker.process(events_at([10, 80, 10, 80, 80, 10, 10], 50, np.arange(7)))
    assert labels.dtype == np.int32
    assert labels.tolist() == [-1, -1, -1, -1, 0, 1, 1]
    assert tracker.clusters["id"].tolist() == [0, 1]
    assert tracker.clusters["x"].tolist() == [80.0, 10.0]
    assert tracker.clusters["t_last"].tolist() == [4, 6]


def test_without_labels_the_state_is_the_same() -> None:
    events = two_blobs()
    labelling, silent = ClusterTracker(WIDTH, HEIGHT), ClusterTracker(WIDTH, HEIGHT)
    labelling.process(events)
    assert silent.process(events, labels=False) is None
    assert np.array_equal(labelling.clusters, silent.clusters)


def test_no_events() -> None:
    tracker = ClusterTracker(WIDTH, HEIGHT)
    labels = tracker.process(np.zeros(0, EVENT_DTYPE))
    assert labels.shape == (0,)
    assert labels.dtype == np.int32


def test_events_outside_the_frame_are_counted() -> None:
    tracker = ClusterTracker(20, 10, min_size=1)
    labels = tracker.process(events_at([20, 0, 65535, 19], [0, 10, 65535, 9], 0))
    assert labels.tolist() == [-1, -1, -1, 0]
    assert tracker.rejected == 3


@settings(max_examples=50, deadline=None)
@given(
    columns=hnp.arrays(np.uint16, st.tuples(st.integers(0, 200), st.just(2))),
    window=st.integers(1, 50),
    radius=st.floats(0, 1e5),
    probes=st.integers(0, 3),
    weight=st.floats(0, 1),
    min_size=st.integers(0, 5),
)
def test_any_events_and_parameters_keep_the_sums(
    columns: np.ndarray, window: int, radius: float, probes: int, weight: float, min_size: int
) -> None:
    tracker = ClusterTracker(
        WIDTH,
        HEIGHT,
        window=window,
        radius=radius,
        probes=probes,
        weight=weight,
        min_size=min_size,
    )
    x, y = columns[:, 0] % 400, columns[:, 1] % 300
    labels = tracker.process(events_at(x, y, np.arange(len(x))))
    inside = (x < WIDTH) & (y < HEIGHT)
    assert tracker.rejected == np.count_nonzero(~inside)
    clusters = tracker.clusters
    live = min(window, np.count_nonzero(inside))
    if min_size <= 1:
        assert clusters["size"].sum() == live
        assert np.all(labels[inside] >= 0)
    assert clusters["size"].sum() <= live
    assert np.all(labels[~inside] == -1)
    assert np.isin(clusters["id"], labels).all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"width": 0}, r"width = 0: "),
        ({"height": -3}, r"height = -3: "),
        ({"window": 0}, r"window = 0: "),
        ({"window": 65536}, r"window = 65536: "),
        ({"radius": -1.0}, r"radius = -1: "),
        ({"radius": float("nan")}, r"radius = nan: "),
        ({"probes": -1}, r"probes = -1: "),
        ({"weight": 1.5}, r"weight = 1\.5: "),
        ({"min_size": -1}, r"min_size = -1: "),
        ({"motion": "mean"}, r"motion = 'mean': must be "),
        ({"motion": None}, r"motion = None: "),
        ({"engine": "slow"}, r"engine = 'slow': must be "),
    ],
)
def test_bad_parameters_are_named(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ClusterTracker(**{"width": WIDTH, "height": HEIGHT, **arguments})


def test_parameters_of_the_other_engine_are_refused_by_name() -> None:
    with pytest.raises(TypeError, match=r'^link_ms = 40.0: engine "compat" has no such parameter'):
        ClusterTracker(WIDTH, HEIGHT, link_ms=40.0)
    with pytest.raises(TypeError, match=r"^window = 1\.5: "):
        ClusterTracker(WIDTH, HEIGHT, window=1.5)


def test_time_alone_changes_nothing() -> None:
    tracker = ClusterTracker(WIDTH, HEIGHT)
    tracker.process(two_blobs())
    before = tracker.clusters
    tracker.advance_to(10**9)
    assert np.array_equal(tracker.clusters_at(2 * 10**9), before)
    assert (tracker.unsupported, tracker.refused) == (0, 0)


def test_parameters_are_keyword_only() -> None:
    with pytest.raises(TypeError):
        asap.ClusterTracker(WIDTH, HEIGHT, "compat")  # type: ignore[call-arg]


def test_parameters_rebuild_the_tracker() -> None:
    tracker = ClusterTracker(WIDTH, HEIGHT, window=300, radius=7.5, seed=2**64 - 1)
    assert (tracker.width, tracker.height, tracker.name) == (WIDTH, HEIGHT, "clusters")
    assert isinstance(tracker, asap.ClusterTracker)
    assert tracker.engine == "compat"
    assert tracker.parameters == {
        "engine": "compat",
        "window": 300,
        "radius": 7.5,
        "probes": 1,
        "weight": 0.9,
        "min_size": 15,
        "seed": 2**64 - 1,
        "motion": "window",
    }
    twin = asap.ClusterTracker(tracker.width, tracker.height, **tracker.parameters)
    assert np.array_equal(tracker.process(two_blobs()), twin.process(two_blobs()))


def test_motion_by_the_filter() -> None:
    window, kalman = ClusterTracker(WIDTH, HEIGHT), ClusterTracker(WIDTH, HEIGHT, motion="kalman")
    assert kalman.parameters == {**window.parameters, "motion": "kalman"}
    events = two_blobs(20_000, start_us=1_600_000_000_000_000)[:19_000]
    assert np.array_equal(window.process(events), kalman.process(events))
    still, moving = np.sort(kalman.clusters, order="y")
    plain = np.sort(window.clusters, order="y")
    assert (moving["vx"], moving["vy"]) == pytest.approx((200, -100), abs=50)
    assert (still["vx"], still["vy"]) == pytest.approx((0, 0), abs=20)
    assert moving["x"] == pytest.approx(59.5 + 200 * 0.95, abs=0.7)  # pixels are rounded down
    assert moving["y"] == pytest.approx(199.5 - 100 * 0.95, abs=0.7)
    assert (plain[1]["cxx"], plain[1]["size"]) == (moving["cxx"], moving["size"])
    ahead = kalman.clusters_at(int(events["t"][-1]) + 20_000)
    step = np.sort(ahead, order="y")[1]["x"] - moving["x"]
    assert step == pytest.approx(0.02 * moving["vx"], abs=1e-6)
    assert np.array_equal(kalman.clusters_at(0), kalman.clusters)
    kalman.advance_to(2**62)
    kalman.set_keep(0.2)
    kalman.reset()
    kalman.process(events)
    assert np.array_equal(np.sort(kalman.clusters, order="y"), np.array([still, moving]))


@pytest.mark.parametrize("bad", [-0.1, 1.1, float("nan")])
def test_keep_is_checked(bad: float) -> None:
    tracker = ClusterTracker(WIDTH, HEIGHT)
    with pytest.raises(ValueError, match="gamma = "):
        tracker.set_keep(bad)


def test_keep_has_no_effect() -> None:
    told, untold = ClusterTracker(WIDTH, HEIGHT), ClusterTracker(WIDTH, HEIGHT)
    told.set_keep(0.2)
    assert np.array_equal(told.process(two_blobs()), untold.process(two_blobs()))


def test_other_arrays_are_refused() -> None:
    tracker = ClusterTracker(WIDTH, HEIGHT)
    events = two_blobs(100)
    packed = np.zeros(100, [("x", "<u2"), ("y", "<u2"), ("p", "<i2"), ("t", "<i8")])
    for bad in (packed, events[::2], events.reshape(10, 10), events["x"]):
        with pytest.raises(TypeError, match="as_events"):
            tracker.process(bad)
    with pytest.raises(TypeError):
        tracker.process([(1, 2, 0, 3)])  # type: ignore[call-overload]
    assert tracker.process(as_events(packed)).shape == (100,)


def test_read_only_events_are_taken() -> None:
    events = two_blobs(100)
    events.flags.writeable = False
    assert ClusterTracker(WIDTH, HEIGHT).process(events).shape == (100,)


def noise(count: int, seed: int = 1) -> np.ndarray:
    random = np.random.default_rng(seed)
    return events_at(
        random.integers(0, WIDTH, count), random.integers(0, HEIGHT, count), range(count)
    )


def test_same_seed_same_results_however_the_stream_is_cut() -> None:
    events = as_events(np.concatenate([two_blobs(), noise(6000)]))
    whole, cut = ClusterTracker(WIDTH, HEIGHT, seed=5), ClusterTracker(WIDTH, HEIGHT, seed=5)
    labels = whole.process(events)
    parts = [cut.process(part) for part in np.array_split(events, 37)]
    assert np.array_equal(labels, np.concatenate(parts))
    assert np.array_equal(whole.clusters, cut.clusters)
    other = ClusterTracker(WIDTH, HEIGHT, seed=6).process(events)
    assert not np.array_equal(labels, other)


def test_reset_is_a_new_tracker() -> None:
    events = as_events(np.concatenate([two_blobs(), noise(6000)]))
    tracker = ClusterTracker(WIDTH, HEIGHT)
    tracker.process(events_at([WIDTH], [0], [0]))
    labels, clusters = tracker.process(events), tracker.clusters
    tracker.reset()
    assert tracker.rejected == 0
    assert len(tracker.clusters) == 0
    assert np.array_equal(tracker.process(events), labels)
    assert np.array_equal(tracker.clusters, clusters)


def test_other_threads_run_meanwhile() -> None:
    events = noise(3_000_000)
    tracker = ClusterTracker(WIDTH, HEIGHT)
    assert turns_meanwhile(lambda: tracker.process(events, labels=False)) > 5
