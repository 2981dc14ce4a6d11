"""asap.MotionSegmenter: the binding. The rule itself is tested in tests/cpp/algorithms."""

from __future__ import annotations

import numpy as np

import asap
from asap_laboratory import scenes

FIELDS = (
    *("id", "x", "y", "vx", "vy", "left", "top", "width", "height"),
    *("size", "t_last", "age_us", "independent"),
)


def test_objects_and_camera_motion_of_a_moving_camera() -> None:
    scene = scenes.K(seed=2)
    segmenter = asap.MotionSegmenter(scene.width, scene.height)
    assert segmenter.objects.size == 0 and segmenter.camera_motion is None
    events = scene.events[scene.events["t"] < 500_000]
    segmenter.process(events)
    found, truth = segmenter.objects, scene.truth(500_000)
    assert found.dtype.names == FIELDS and found.size
    assert np.all(found["independent"] == 1)
    away = np.hypot(found["x"] - truth["x"][:, None], found["y"] - truth["y"][:, None])
    assert np.all(away.min(axis=0) < scene.match_radii_px(500_000).max())
    ahead = segmenter.objects_at(510_000)
    passed_s = (510_000 - int(events["t"][-1])) * 1e-6
    assert np.allclose(ahead["x"] - found["x"], found["vx"] * passed_s)
    assert segmenter.objects_at(10**9).size == 0
    camera = segmenter.camera_motion
    assert camera is not None
    assert camera.dtype.names == ("t", "vx", "vy", "turn", "zoom", "covariance")
    assert np.all(np.linalg.eigvalsh(camera["covariance"]) > 0)
    assert np.all(np.isfinite(camera["covariance"]))
