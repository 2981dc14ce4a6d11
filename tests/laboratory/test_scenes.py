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


@pytest.mark.parametrize(("kind", "rate"), [("slow", 0.30e6), ("fast", 1.15e6), ("noisy", 1.3e6)])
def test_corner_scenes_have_their_rates(kind: Any, rate: float) -> None:
    scene = scenes.corners(kind, duration_s=0.5)
    assert scene.name == f"corners_{kind}"
    assert len(scene.events) / 0.5 == pytest.approx(rate, rel=0.3)
