"""PlaneFlow against the truth: of a scene, and of recordings where they are."""

from __future__ import annotations

import numpy as np

import asap
from flow_truth import along_velocity, disk, errors, rotating_pipe, slider


def test_on_the_rim_of_a_disk_under_noise() -> None:
    scene = disk(seed=1)
    found = errors(scene)
    assert found["flow"] > 0.1
    assert found["angle"] < 5
    assert found["speed"] < 0.1
    assert found["wrong"] < 0.01
    assert errors(scene, refit=True)["speed"] > 2 * found["speed"]


def test_noise_alone_has_hardly_a_flow() -> None:
    random = np.random.default_rng(3)
    events = np.zeros(20_000, asap.EVENT_DTYPE)
    events["x"], events["y"] = random.integers(0, 80, (2, 20_000))
    events["p"] = random.integers(0, 2, 20_000)
    events["t"] = np.sort(random.integers(0, 200_000, 20_000))
    found = {
        refit: np.isfinite(asap.PlaneFlow(80, 80, refit=refit).process(events)[:, 0]).mean()
        for refit in (None, True)
    }
    assert found[True] > 0.3
    assert found[None] < 0.05


def test_on_a_bar_that_turns() -> None:
    scene = rotating_pipe()
    found = errors(scene)
    assert found["flow"] > 0.8
    assert found["angle"] <= 10
    assert found["speed"] <= 0.15
    assert found["wrong"] < 0.01
    assert errors(scene, refit=True)["speed"] > found["speed"]


def test_on_planes_before_a_slider() -> None:
    scene = slider()
    found = along_velocity(scene)
    assert found["flow"] > 0.2
    assert found["residual"] <= 0.25
    assert found["wrong"] <= 0.03
    assert along_velocity(scene, refit=True)["residual"] > 2 * found["residual"]
