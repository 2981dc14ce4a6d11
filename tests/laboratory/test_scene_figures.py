from __future__ import annotations

import numpy as np
import pytest

from asap_laboratory import scenes
from asap_laboratory.scenes import Scene

pytest.importorskip("matplotlib")

from asap_laboratory.scenes import figures as scene_figures


@pytest.fixture(scope="module")
def scene() -> Scene:
    return scenes.timing(3, 120, 90, 100.0, duration_s=0.2)


def test_snapshot_shows_the_window_and_the_truth(scene: Scene) -> None:
    axes = scene_figures.snapshot(scene, 150.0, window_ms=10.0).axes[0]
    t = scene.events["t"]
    shown = scene.events[(t >= 140_000) & (t < 150_000)]
    pixels = np.any(np.asarray(axes.images[0].get_array()) != 255, axis=2)
    assert pixels.sum() == len(np.unique(shown[["x", "y"]]))
    assert [text.get_text() for text in axes.texts] == ["0", "1", "2"]
    for text, thing in zip(axes.texts, scene.truth(150_000), strict=True):
        assert text.get_position() == pytest.approx((thing["x"], thing["y"]))
    outlines, ways = axes.lines
    points = np.array(outlines.get_data()).T
    distances = np.hypot(*(points - [scene.truth(150_000)[v][0] for v in "xy"])[1:26].T)
    assert distances == pytest.approx(scene.reaches_px[0])  # the disk
    way = np.array(ways.get_data()).T[1:3]
    assert np.diff(way, axis=0)[0] == pytest.approx(
        [scene.truth(150_000)[v][0] * 0.1 for v in ("vx", "vy")]
    )
    assert axes.get_title(loc="left") == "timing: 10 ms before 0.150 s"
