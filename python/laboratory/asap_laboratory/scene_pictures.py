"""Pictures of the page of scenes."""

from __future__ import annotations

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
        *((make(), None, 15.0) for make in (scenes.L, scenes.M, scenes.N, scenes.O)),
    ]


def write(folder: Path) -> list[Path]:
    """Write a picture of each scene, and return the paths."""
    paths = []
    for pictured, moment_ms, before_ms in documented():
        paths.append(folder / f"scene_{pictured.name}.svg")
        drawn = plots.svg(snapshot(pictured, moment_ms, window_ms=before_ms))
        paths[-1].write_text(drawn, encoding="utf-8")
    return paths
