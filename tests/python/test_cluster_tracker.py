"""asap.ClusterTracker, engine "fast": the binding. The engine is tested in tests/cpp/algorithms."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import asap
from asap import EVENT_DTYPE, ClusterTracker

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


def test_is_the_default_engine() -> None:
    tracker = ClusterTracker(WIDTH, HEIGHT)
    assert tracker.engine == "fast"
    assert (tracker.width, tracker.height, tracker.name) == (WIDTH, HEIGHT, "clusters")


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


@pytest.mark.parametrize("engine", ["fast", "compat"])
def test_an_outline_is_the_ellipse_of_the_covariance(engine: str) -> None:
    tracker = ClusterTracker(WIDTH, HEIGHT, engine=engine)
    tracker.process(disk(0, 0.5), labels=False)
    for cluster in tracker.clusters:
        outline = tracker.outline(cluster["id"])
        assert outline is not None
        assert outline.dtype.names == ("x", "y", "major", "minor", "angle")
        assert (outline["x"], outline["y"]) == (cluster["x"], cluster["y"])
        turn = np.array([np.cos(outline["angle"]), np.sin(outline["angle"])])
        axes = np.stack([turn * outline["major"], turn[::-1] * (-1, 1) * outline["minor"]], 1) / 2
        (cxx, cxy), (_, cyy) = axes @ axes.T
        assert (cxx, cxy, cyy) == pytest.approx(
            (cluster["cxx"], cluster["cxy"], cluster["cyy"]), abs=1e-9
        )
        assert outline["major"] >= outline["minor"] > 3
        assert pickle.loads(pickle.dumps(outline)) == outline
    assert len(tracker.clusters) > 0
    assert tracker.outline(10**6) is None


def test_clusters_at_looks_ahead_and_silence_hides() -> None:
    tracker = ClusterTracker(WIDTH, HEIGHT)
    tracker.process(disk(0, 0.5), labels=False)
    (now,), (then,) = tracker.clusters, tracker.clusters_at(501_000)
    assert then["x"] == pytest.approx(now["x"] + now["vx"] * 1.1e-3, abs=0.05)
    assert len(tracker.clusters_at(700_000)) == 0
    tracker.process(disk(0.7, 1.0, vx=0.0), labels=False)
    tracker.advance_to(2_000_000)
    assert len(tracker.clusters) == 0


@settings(max_examples=30, deadline=None)
@given(
    engine=st.sampled_from(["fast", "compat"]),
    kept=st.sampled_from([0.05, 0.2, 1.0]),
    seed=st.integers(0, 2**32 - 1),
)
def test_asking_changes_nothing(engine: str, kept: float, seed: int) -> None:
    random = np.random.default_rng(seed)
    events = np.concatenate([disk(0, 0.2, seed=1), disk(0.25, 0.4, vx=120.0, seed=2)])
    events = events[random.random(events.size) < kept]
    silent, asked = (ClusterTracker(WIDTH, HEIGHT, engine=engine) for _ in range(2))
    cuts = np.sort(random.integers(0, events.size, 40))
    for part in np.split(events, cuts):
        labels = silent.process(part)
        assert np.array_equal(asked.process(part), labels)
        last_us = int(part["t"][-1]) if part.size else 0
        for ahead_us in random.integers(-10_000, 100_000, 2).tolist():
            asked.clusters_at(last_us + ahead_us)
        assert np.array_equal(asked.clusters, silent.clusters)
        if random.random() < 0.3:
            gamma = float(random.random())
            silent.set_keep(gamma)
            asked.set_keep(gamma)
    assert len(silent.clusters_at(10**9)) == (0 if engine == "fast" else len(silent.clusters))


def test_without_labels_the_state_is_the_same() -> None:
    events = disk(0, 0.5)
    labelling, silent = ClusterTracker(WIDTH, HEIGHT), ClusterTracker(WIDTH, HEIGHT)
    labelling.process(events)
    assert silent.process(events, labels=False) is None
    assert np.array_equal(labelling.clusters, silent.clusters)


def test_results_do_not_depend_on_the_cut() -> None:
    events = disk(0, 0.5)
    whole, cut = ClusterTracker(WIDTH, HEIGHT), ClusterTracker(WIDTH, HEIGHT)
    labels = whole.process(events)
    parts = [cut.process(part) for part in np.array_split(events, 37)]
    assert np.array_equal(labels, np.concatenate(parts))
    assert np.array_equal(whole.clusters, cut.clusters)
    cut.reset()
    assert len(cut.clusters) == 0
    assert np.array_equal(cut.process(events), labels)


def test_counters() -> None:
    tracker = ClusterTracker(WIDTH, HEIGHT)
    events = np.zeros(3, EVENT_DTYPE)
    events["x"] = [0, 100, WIDTH]
    tracker.process(events)
    assert (tracker.rejected, tracker.unsupported, tracker.refused) == (1, 2, 0)
    full = ClusterTracker(WIDTH, HEIGHT, slots=1)
    events = np.concatenate([disk(0, 0.5), disk(0, 0.5, vx=400.0, seed=1)])
    full.process(events[np.argsort(events["t"], kind="stable")])
    assert full.refused > 0


def test_keep_is_told_and_checked() -> None:
    tracker = ClusterTracker(WIDTH, HEIGHT)
    for bad in (-0.1, 1.1, float("nan")):
        with pytest.raises(ValueError, match="gamma = "):
            tracker.set_keep(bad)
    told = ClusterTracker(WIDTH, HEIGHT)
    told.set_keep(0.2)
    told.set_keep(0.0, filter_upstream=True)
    told.set_keep(1.0)
    assert np.array_equal(told.process(disk(0, 0.3)), tracker.process(disk(0, 0.3)))


def test_parameters_rebuild_the_tracker() -> None:
    tracker = ClusterTracker(WIDTH, HEIGHT, link_ms=30, slots=20, support="estimate")
    parameters = tracker.parameters
    assert parameters["engine"] == "fast"
    assert (parameters["link_ms"], parameters["slots"]) == (30.0, 20)
    assert parameters["support"] == "estimate"
    assert parameters["birth_radius_px"] == 18.0
    twin = ClusterTracker(WIDTH, HEIGHT, **parameters)
    assert twin.parameters == parameters


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"width": 0}, r"width = 0: "),
        ({"height": 20_000}, r"height = 20000: "),
        ({"link_ms": 0}, r"link_ms = 0: must be "),
        ({"link_ms": float("nan")}, r"link_ms = nan: must be "),
        ({"birth_radius_px": float("inf")}, r"birth_radius_px = inf: must be "),
        ({"slots": 257}, r"slots = 257: must be 1 to 256"),
        ({"cell_px": 3}, r"cell_px = 3: must be a power of two"),
        ({"min_radius_px": 30}, r"min_radius_px = 30: must be at most birth_radius_px = 18"),
        ({"support": "maybe"}, r"support = 'maybe': must be "),
        ({"engine": "slow"}, r"engine = 'slow': must be "),
    ],
)
def test_bad_parameters_are_named(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ClusterTracker(**{"width": WIDTH, "height": HEIGHT, **arguments})


def test_parameters_of_the_other_engine_are_refused_by_name() -> None:
    with pytest.raises(TypeError, match=r'^window = 800: engine "fast" has no such parameter'):
        ClusterTracker(WIDTH, HEIGHT, window=800)
    with pytest.raises(TypeError, match=r"^slots = 1\.5: "):
        ClusterTracker(WIDTH, HEIGHT, slots=1.5)
    with pytest.raises(TypeError, match=r"^link_ms = 'x': "):
        ClusterTracker(WIDTH, HEIGHT, link_ms="x")


def test_a_runner_takes_it_as_native_and_tells_it_what_is_kept() -> None:
    events = disk(0, 0.3)
    cost = asap.LinearCost(alpha_us=100.0, beta_ns=300.0)
    tracker = ClusterTracker(WIDTH, HEIGHT)
    run = asap.simulate(events, cost=cost, algorithm=tracker, width=WIDTH, height=HEIGHT)
    assert run.algorithm is tracker
    assert len(tracker.clusters) == 1
