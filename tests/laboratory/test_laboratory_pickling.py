"""Pickles of what the laboratory makes: equal after a round trip."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import asap
from asap_laboratory import _native, keep_curve, profiles, scenes


def again(made: Any) -> Any:
    return pickle.loads(pickle.dumps(made))


@pytest.mark.parametrize(
    "make",
    [
        lambda: profiles.Profile("walk", duration_s=0.2, seed=5),
        lambda: profiles.Profile("high", duration_s=0.1, name="mine", width=20, height=30),
        lambda: profiles.scenario("bursts", "slow", duration_s=0.2).source,
    ],
)
def test_profiles(make: Callable[[], Any]) -> None:
    stream = make()
    twin = again(stream)
    assert (type(twin), twin.name, twin.parameters) == (
        type(stream),
        stream.name,
        stream.parameters,
    )
    assert np.array_equal(twin.events(), stream.events())


@pytest.mark.parametrize(
    "make",
    [
        lambda: scenes.timing(3, 64, 48, 100.0, seed=2, duration_s=0.1),
        lambda: scenes.corners("fast", duration_s=0.1),
        lambda: scenes.stop_and_go(10.0),
        lambda: scenes.occlusion(50.0),
        lambda: scenes.stop_and_go(10.0).thin(0.3, seed=4),
        lambda: scenes.stop_and_go(10.0).thin(0.3, seed=4).thin(0.5),
    ],
)
def test_scenes(make: Callable[[], Any]) -> None:
    scene = make()
    before = again(scene)
    assert scene.events.size  # made once and kept: not in the pickle
    data = pickle.dumps(scene)
    assert len(data) < 2000
    for twin in (before, pickle.loads(data)):
        assert repr(twin) == repr(scene)
        assert np.array_equal(twin.events, scene.events) and np.array_equal(
            twin.labels, scene.labels
        )
        assert np.array_equal(twin.truth(5000.0), scene.truth(5000.0))


def test_a_named_scene() -> None:
    scene = scenes.A(seed=3)
    twin = again(scene)
    assert repr(twin) == repr(scene) and np.array_equal(next(iter(twin)), next(iter(scene)))
    assert np.array_equal(twin.truth(5000.0), scene.truth(5000.0))


def test_a_keep_curve() -> None:
    scene = scenes.stop_and_go(10.0)
    curve = keep_curve(asap.ClusterTracker, scene, gammas=(1.0, 0.5), seeds=(0,))
    twin = again(curve)
    assert twin.summary() == curve.summary() and repr(twin) == repr(curve)


@pytest.mark.parametrize("protocol", range(pickle.HIGHEST_PROTOCOL + 1))
@pytest.mark.parametrize(
    "made",
    [_native.JaerClusterTracker(9, 9), _native.BusyWait(1, 1), _native.SceneLayout.named("A", 0)],
    ids=lambda made: type(made).__name__,
)
def test_objects_of_the_extension_are_refused(made: Any, protocol: int) -> None:
    with pytest.raises(TypeError, match=f"^cannot pickle {type(made).__name__}$"):
        pickle.dumps(made, protocol)
