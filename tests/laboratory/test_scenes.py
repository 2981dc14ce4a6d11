from __future__ import annotations

import itertools
import pickle
import tracemalloc
from typing import Any

import numpy as np
import pytest

import asap
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


def test_noise_has_its_rate_and_share(scene: Scene) -> None:
    noise = np.count_nonzero(scene.labels == -1)
    assert noise == pytest.approx(2.0 * 120 * 90 * 0.5, rel=0.05)
    assert not np.any(small(noise_hz=0.0).labels == -1)


def test_same_seed_same_bytes_another_seed_others(scene: Scene) -> None:
    again = small()
    assert same(again.events, scene.events)
    assert np.array_equal(again.labels, scene.labels)
    assert np.array_equal(again.truth(250_000), scene.truth(250_000))
    assert not same(small(seed=1).events[:1000], scene.events[:1000])


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


def test_events_lie_on_their_objects(scene: Scene) -> None:
    """Within reach of the object's centre; the C++ tests look at the outlines."""
    events, labels = scene.events, scene.labels
    for event, label in itertools.islice(zip(events, labels, strict=True), 0, None, 97):
        if label >= 0:
            thing = scene.truth(event["t"])[label]
            distance = np.hypot(event["x"] - thing["x"], event["y"] - thing["y"])
            assert distance < scene.reaches_px[label] + 0.6


def test_blocks_are_the_whole(scene: Scene) -> None:
    big = small(duration_s=1.5, speed=600.0)
    pieces = list(big.blocks())
    assert len(pieces) > 2
    assert all(len(events) == len(labels) for events, labels in pieces)
    assert same(np.concatenate([events for events, _ in pieces]), big.events)
    assert np.array_equal(np.concatenate([labels for _, labels in pieces]), big.labels)
    assert same(np.concatenate(list(big)), big.events)


def test_streaming_holds_no_more_than_a_few_blocks() -> None:
    scene = small(duration_s=3.0, speed=600.0)
    tracemalloc.start()
    events = sum(len(block) for block in scene)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert events > 300_000
    assert peak < 1_000_000  # NumPy's share: the arrays' memory is the extension's


def test_a_scene_is_a_source_of_runs(scene: Scene) -> None:
    run = asap.simulate(scene, cost=asap.LinearCost(10, 10), latency_ms=10)
    assert run.ledger.received == len(scene.events)
    assert run.ledger.rejected == 0


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
        assert reach[corners["id"] == number] == pytest.approx(scene.reaches_px[number])
    square = corners[corners["id"] == 1]
    side = np.hypot(np.diff(square["x"]), np.diff(square["y"]))
    assert side == pytest.approx(side[0])


def test_events_near_a_turning_square_lie_on_the_sides_between_its_vertices() -> None:
    scene = scenes.corners("slow", duration_s=0.5)
    chosen = np.flatnonzero(scene.labels == 1)[::50]
    on_side = 0
    for event in scene.events[chosen]:
        corners = scene.vertices(event["t"])
        square = corners[corners["id"] == 1]
        points = np.stack([square["x"], square["y"]], axis=1)
        ends = np.roll(points, -1, axis=0) - points
        away = np.array([event["x"], event["y"]]) - points
        part = np.clip((away * ends).sum(axis=1) / (ends**2).sum(axis=1), 0, 1)
        on_side += np.hypot(*(away - part[:, None] * ends).T).min() < 1.0
    assert on_side > 0.97 * len(chosen) > 20


@pytest.mark.parametrize("t_us", [-1, 500_001, float("nan")])
def test_there_is_no_truth_outside_the_scene(scene: Scene, t_us: float) -> None:
    for ask in (scene.truth, scene.vertices):
        with pytest.raises(ValueError, match=r"^t_us = .*: give a time from 0 to 500000 us"):
            ask(t_us)


# ---- the scenes -----------------------------------------------------------------------------


@pytest.mark.parametrize("name", "ABCDEFGHIJK")
def test_named_scenes_say_what_they_are(name: str) -> None:
    scene = getattr(scenes, name)(seed=3)
    assert (scene.name, scene.seed) == (name, 3)
    objects, width, height, duration_us = {
        "A": (20, 346, 260, 1_500_000),
        "B": (20, 346, 260, 1_500_000),
        "C": (8, 346, 260, 2_000_000),
        "D": (20, 346, 260, 1_500_000),
        "E": (8, 240, 180, 2_000_000),
        "F": (8, 346, 260, 2_000_000),
        "G": (30, 640, 480, 2_000_000),
        "H": (6, 240, 180, 2_000_000),
        "I": (6, 346, 260, 2_000_000),
        "J": (2, 346, 260, 2_000_000),
        "K": (3, 240, 180, 1_000_000),
    }[name]
    assert (scene.width, scene.height, scene.duration_us) == (width, height, duration_us)
    assert len(scene.truth(0)) == objects
    assert f"{name}, seed 3, {width} x {height} px, {objects} objects" in repr(scene)


@pytest.mark.parametrize(("kind", "corners"), [("bars", 4), ("angles", 6), ("rings", 0)])
def test_large_shapes_of_one_kind(kind: Any, corners: int) -> None:
    scene = scenes.H(3, kind=kind)
    assert scene.name == f"H_{kind}"
    assert len(scene.vertices(0)) == 6 * corners
    assert scene.reaches_px.min() >= 14
    assert pickle.loads(pickle.dumps(scene)).name == scene.name


def test_a_cluster_may_be_farther_from_the_centre_of_a_large_object() -> None:
    large = scenes.I(1)
    assert large.match_radii_px == pytest.approx(np.maximum(12, 0.7 * large.reaches_px))
    assert large.match_radii_px.max() > 17
    assert np.array_equal(large.thin(0.5).match_radii_px, large.match_radii_px)
    assert np.all(scenes.F(1).match_radii_px == 12)


def test_hands_reach_as_far_as_their_fingers() -> None:
    assert np.all(scenes.J().reaches_px > 45)


def test_stop_and_go_stands_still_and_is_silent() -> None:
    scene = scenes.stop_and_go(gap_ms=200, noise_hz=0.0)
    assert scene.duration_us == 1_600_000
    t = scene.events["t"]
    assert not np.any((t >= 700_000) & (t < 900_000))
    assert np.any(t < 700_000) and np.any(t >= 900_000)
    before, after = scene.truth(700_000), scene.truth(899_999)
    assert before["x"] == after["x"] and before["vx"] == 0
    assert scene.truth(900_000)["vx"] != 0


def test_occlusion_hides_one_object_behind_the_other() -> None:
    scene = scenes.occlusion(gap_ms=250, noise_hz=0.0)
    assert np.diff(scene.events["t"]).max() > 240_000
    hidden = scene.truth(scene.duration_us / 2)
    assert abs(hidden["x"][0] - hidden["x"][1]) < 5
    assert hidden["vx"][1] == 0


@pytest.mark.parametrize(("kind", "rate"), [("slow", 0.30e6), ("fast", 1.15e6), ("noisy", 1.3e6)])
def test_corner_scenes_have_their_rates(kind: Any, rate: float) -> None:
    scene = scenes.corners(kind, duration_s=0.5)
    assert scene.name == f"corners_{kind}"
    assert len(scene.events) / 0.5 == pytest.approx(rate, rel=0.3)


# ---- thinning -------------------------------------------------------------------------------


def test_thinning_keeps_events_and_labels_in_step(scene: Scene) -> None:
    thin = scene.thin(0.2, seed=7)
    mask = asap.GammaFilter(seed=7).mask(scene.events, 0.2)
    assert same(thin.events, scene.events[mask])
    assert np.array_equal(thin.labels, scene.labels[mask])
    assert thin.events.dtype == EVENT_DTYPE
    assert np.array_equal(thin.truth(1000), scene.truth(1000))
    assert np.array_equal(thin.vertices(1000), scene.vertices(1000))
    assert (thin.name, thin.seed, thin.width) == (scene.name, scene.seed, scene.width)


def test_thinning_goes_on_over_blocks_and_again() -> None:
    big = small(duration_s=1.5, speed=600.0)
    assert len(list(big.blocks())) > 1
    mask = asap.GammaFilter(seed=0).mask(big.events, 0.5)
    assert same(big.thin(0.5).events, big.events[mask])
    twice = big.thin(0.5).thin(0.5, seed=1)
    again = asap.GammaFilter(seed=1).mask(big.events[mask], 0.5)
    assert same(twice.events, big.events[mask][again])


def test_thinning_to_nothing_and_to_all(scene: Scene) -> None:
    assert len(scene.thin(0.0).events) == 0
    assert scene.thin(0.0).events.dtype == EVENT_DTYPE
    assert len(scene.thin(0.0).labels) == 0
    assert same(scene.thin(1.0).events, scene.events)


# ---- bad arguments --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: scenes.A(seed=-1), "seed = -1: must"),
        (lambda: small(n=-1), "n = -1: give"),
        (lambda: small(width=8), "width = 8: give"),
        (lambda: small(radius=(7.0, 4.0)), r"radius = \(7.0, 4.0\): give the smaller"),
        (lambda: small(radius=(4.0, 200.0)), "radius_px = 200: give at most"),
        (lambda: small(speed=2001.0), "speed = 2001.0: give"),
        (lambda: small(speed=float("nan")), "speed = nan: give"),
        (lambda: small(noise_hz=200.0), "noise_hz = 200: give"),
        (lambda: small(duration_s=0.0), "duration_s = 0.0: give"),
        (lambda: small(duration_s=0.5001), "duration_us = 500100: give a multiple"),
        (lambda: scenes.corners("quick"), "kind = 'quick': give one of slow, fast, noisy"),
        (lambda: scenes.H(kind="disks"), "kind = 'disks': give one of bars, angles, rings"),
        (lambda: scenes.K(seed=-1), "seed = -1: must"),
        (lambda: scenes.stop_and_go(-1.0), "gap_ms = -1.0: give"),
        (lambda: scenes.stop_and_go(radius=1.0), "radius = 1.0: give"),
        (lambda: scenes.occlusion(2000.0), "gap_us = 2000000: give less"),
        (lambda: scenes.occlusion(speed=1.0), "speed = 1.0: give"),
        (lambda: small().thin(1.1), "gamma = 1.1: give"),
        (lambda: small().thin(0.5, seed=-1), "seed = -1: must"),
    ],
)
def test_bad_arguments_are_named(make: Any, message: str) -> None:
    with pytest.raises(ValueError, match=f"^{message}"):
        make()
