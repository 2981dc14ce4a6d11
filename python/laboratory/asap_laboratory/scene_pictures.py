"""Pictures of the page of scenes: ``python -m asap_laboratory.scene_pictures FOLDER``."""

from __future__ import annotations

import sys
from pathlib import Path

from asap import plots
from asap_laboratory import scenes
from asap_laboratory.scenes import Scene
from asap_laboratory.scenes.figures import snapshot


def documented() -> list[tuple[Scene, float | None, float]]:
    """Scenes of the documentation, each with the moment that is shown and its window, ms."""
    return [
        *((make(), None, 15.0) for make in (scenes.A, scenes.B, scenes.C, scenes.D, scenes.E)),
        (scenes.F(), None, 15.0),
        (scenes.G(), None, 5.0),
        (scenes.corners("slow"), None, 15.0),
        (scenes.stop_and_go(), 690.0, 15.0),
        (scenes.occlusion(), 600.0, 15.0),
    ]


if __name__ == "__main__":
    for pictured, moment_ms, before_ms in documented():
        picture = plots.svg(snapshot(pictured, moment_ms, window_ms=before_ms))
        Path(sys.argv[1], f"scene_{pictured.name}.svg").write_text(picture, encoding="utf-8")
