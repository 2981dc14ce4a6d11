from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

from asap import EVENT_DTYPE
from asap_laboratory import scenes
from asap_laboratory.scenes import CORNER_DTYPE, TRUTH_DTYPE, Scene
from test_synthetic import fingerprint, same

SMALL = {"n": 6, "width": 120, "height": 90, "speed": 200.0, "radius": (4.0, 7.0)}


def small(seed: int = 0, **parameters: Any) -> Scene:
    return scenes.timing(**{**SMALL, "noise_hz": 2.0, "duration_s": 0.5, **parameters}, seed=seed)


@pytest.fixture(scope="module")
def scene() -> Scene:
    return small()


# ---- events and labels ----------------------------------------------------------------------


def test_events_and_labels_are_in_order_inside_and_read_only(scene: Scene) -> None:
    events, labels = scene.events, scene.labels
    assert events.dtype == EVENT_DTYPE and labels.dtype == np.int32
    assert len(events) == len(labels) > 10_000
    assert np.all(np.diff(events["t"]) >= 0)
    assert events["t"][0] >= 0
    assert events["t"][-1] < scene.duration_us == 500_000
    assert events["x"].max() < scene.width == 120
    assert events["y"].max() < scene.height == 90
    assert set(np.unique(events["p"])) == {0, 1}
    assert set(np.unique(labels)) == set(range(-1, 6))
    assert not events.flags.writeable and not labels.flags.writeable
    assert scene.events is events and scene.labels is labels


GOLDEN = {
    "A": (8834247836951532315, 193243989),
    "B": (14639644259146866180, 213955789),
    "C": (17430852049800540927, 54480396),
    "D": (13328698138732269182, 65967145),
    "E": (3086124862900649718, 64970273),
    "F": (1058985133502029977, 88620045),
    "G": (6700979935084270644, 223461325),
}


# A change of the streams changes published figures: say so in the changelog.
@pytest.mark.parametrize("name", GOLDEN)
def test_first_events_and_labels_are_golden(name: str) -> None:
    events, labels = next(getattr(scenes, name)().blocks())
    place = np.arange(50_000) % 997
    assert (fingerprint(events[:50_000]), int((labels[:50_000] * place).sum())) == GOLDEN[name]


def test_blocks_are_the_whole(scene: Scene) -> None:
    big = small(duration_s=1.5, speed=600.0)
    pieces = list(big.blocks())
    assert len(pieces) > 2
    assert all(len(events) == len(labels) for events, labels in pieces)
    assert same(np.concatenate([events for events, _ in pieces]), big.events)
    assert np.array_equal(np.concatenate([labels for _, labels in pieces]), big.labels)
    assert same(np.concatenate(list(big)), big.events)


# ---- truth ----------------------------------------------------------------------------------


def test_truth_is_that_of_the_step(scene: Scene) -> None:
    truth = scene.truth(1000.0)
    assert truth.dtype == TRUTH_DTYPE
    assert truth["id"].tolist() == list(range(6))
    assert np.array_equal(scene.truth(1249.9), truth)
    assert not np.array_equal(scene.truth(1250), truth)
    assert scene.truth(scene.duration_us).shape == (6,)


@pytest.mark.parametrize("make", [scenes.A, scenes.B, scenes.C, scenes.F, scenes.G])
def test_velocity_is_the_derivative_of_the_position(make: Any) -> None:
    scene = make(seed=5)
    times = np.arange(0, scene.duration_us, 10_000)
    jumps = 0
    for t_us in times:
        now, then = scene.truth(t_us), scene.truth(t_us + 250)
        for v, x in (("vx", "x"), ("vy", "y")):
            jumps += np.count_nonzero(np.abs((then[x] - now[x]) / 250e-6 - now[v]) > 2.0)
    assert jumps <= 2  # the steps of a bounce


def test_vertices_turn_with_their_objects(scene: Scene) -> None:
    corners = scene.vertices(100_000)
    assert corners.dtype == CORNER_DTYPE
    counts = np.bincount(corners["id"], minlength=6)
    assert counts.tolist() == [0, 4, 4, 3, 10, 0]  # disk, square, rectangle, triangle, star, disk
    truth = scene.truth(100_000)
    reach = np.hypot(
        corners["x"] - truth["x"][corners["id"]], corners["y"] - truth["y"][corners["id"]]
    )
    for number in (1, 2, 3):
        assert reach[corners["id"] == number] == pytest.approx(scene.reaches_px(100_000)[number])
    square = corners[corners["id"] == 1]
    side = np.hypot(np.diff(square["x"]), np.diff(square["y"]))
    assert side == pytest.approx(side[0])


@pytest.mark.parametrize("t_us", [-1, 500_001, float("nan")])
def test_there_is_no_truth_outside_the_scene(scene: Scene, t_us: float) -> None:
    for ask in (scene.truth, scene.vertices):
        with pytest.raises(ValueError, match=r"^t_us = .*: give a time from 0 to 500000 us"):
            ask(t_us)


# ---- the scenes -----------------------------------------------------------------------------


@pytest.mark.parametrize(("kind", "corners"), [("bars", 4), ("angles", 6), ("rings", 0)])
def test_large_shapes_of_one_kind(kind: Any, corners: int) -> None:
    scene = scenes.H(3, kind=kind)
    assert scene.name == f"H_{kind}"
    assert len(scene.vertices(0)) == 6 * corners
    assert scene.reaches_px(0).min() >= 14
    assert pickle.loads(pickle.dumps(scene)).name == scene.name


def test_a_cluster_may_be_farther_from_the_centre_of_a_large_object() -> None:
    large = scenes.I(1)
    assert large.match_radii_px(0) == pytest.approx(np.maximum(12, 0.7 * large.reaches_px(0)))
    assert large.match_radii_px(0).max() > 17
    assert np.all(scenes.F(1).match_radii_px(0) == 12)


@pytest.mark.parametrize("make", [scenes.L, scenes.M, scenes.N, scenes.O])
def test_scenes_of_recordings_vary_with_their_seed_and_pickle(make: Any) -> None:
    scene, other = make(1), make(2)
    again = pickle.loads(pickle.dumps(scene))
    assert again.name == scene.name == make.__name__
    assert same(next(again.blocks())[0], next(scene.blocks())[0])
    assert not np.array_equal(scene.reaches_px(0)[:2], other.reaches_px(0)[:2])


@pytest.mark.parametrize("seed", [0, 7, 1003])
def test_large_sparse_objects_fire_2_to_10_kev_per_second(seed: int) -> None:
    scene = scenes.L(seed)
    counts = np.bincount(scene.labels + 1, minlength=4) / (scene.duration_us * 1e-6)
    noise_hz = counts[0] / (scene.width * scene.height)
    assert 0.1 < noise_hz < 0.5
    assert np.all((counts[1:] > 2_000) & (counts[1:] < 10_000))
    assert np.all((scene.reaches_px(0) > 20) & (scene.reaches_px(0) < 65))


@pytest.mark.parametrize("seed", [1, 2])  # a disk, a square
def test_what_comes_near_grows_from_10_to_100_px(seed: int) -> None:
    scene = scenes.M(seed)
    near = len(scene.truth(0)) - 1
    times = np.arange(0, scene.duration_us, 50_000)
    reach = np.array([scene.reaches_px(t)[near] for t in times])
    assert np.all(np.diff(reach) >= 0)
    assert reach[-1] == pytest.approx(10 * reach[0])
    corners = [scene.vertices(t)[scene.vertices(t)["id"] == near] for t in times]
    assert 2 * reach[0] == pytest.approx(10 if not corners[0].size else 10 * np.sqrt(2))
    assert 1e6 <= times[np.argmax(reach == reach[-1])] <= 1.85e6
    assert [scene.match_radii_px(t)[near] for t in times] == pytest.approx(
        np.maximum(12, 0.7 * reach).tolist()
    )
    for t_us in (500_000, int(times[-1])):
        where = scene.truth(t_us)[near]
        own = corners[t_us // 50_000]
        size = np.hypot(own["x"] - where["x"], own["y"] - where["y"])
        assert size == pytest.approx(scene.reaches_px(t_us)[near])
        now = (scene.labels == near) & (np.abs(scene.events["t"] - t_us) < 10_000)
        away = np.hypot(scene.events["x"][now] - where["x"], scene.events["y"][now] - where["y"])
        assert 0.6 < away.max() / scene.reaches_px(t_us)[near] < 1.2


def test_lamps_of_50_100_and_1000_hz_and_hot_pixels_are_noise() -> None:
    scene = scenes.N(3)
    assert scene.truth(0).size == 4
    noise = scene.events[scene.labels < 0]
    counts = np.zeros((scene.height, scene.width), int)
    np.add.at(counts, (noise["y"], noise["x"]), 1)
    for hz in (50, 100, 1000):
        y, x = np.nonzero(np.abs(counts - 2 * hz * 2) <= 15)
        assert 25 <= y.size <= 257
        events = noise[(noise["y"] == y[0]) & (noise["x"] == x[0])]
        assert np.mean(np.diff(events["p"].astype(int)) != 0) > 0.95
        assert np.median(np.diff(events["t"])) == pytest.approx(5e5 / hz, rel=0.05)
    y, x = np.nonzero(np.abs(counts - 2000) <= 20)  # 1000 events per second
    assert y.size == 4
    assert np.all(np.diff(x.reshape(-1, 2)) == 1) and np.all(np.diff(y.reshape(-1, 2)) == 0)


def test_a_fence_hides_stripes_of_the_ball() -> None:
    scene = scenes.O(3)  # vertical wires
    columns = np.unique(scene.events["x"][scene.labels == 0])
    gaps = np.diff(columns) - 1
    wires = gaps[gaps > 0]
    assert 5 <= wires.size <= 30
    assert np.all((wires >= 2) & (wires <= 6))
    begins = columns[:-1][gaps > 0]
    assert np.all((np.diff(begins) >= 10) & (np.diff(begins) <= 20))
    assert scene.truth(0).size == 1


@pytest.mark.parametrize(("kind", "rate"), [("slow", 0.30e6), ("fast", 1.15e6), ("noisy", 1.3e6)])
def test_corner_scenes_have_their_rates(kind: Any, rate: float) -> None:
    scene = scenes.corners(kind, duration_s=0.5)
    assert scene.name == f"corners_{kind}"
    assert len(scene.events) / 0.5 == pytest.approx(rate, rel=0.3)
