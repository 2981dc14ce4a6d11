"""Pictures of scenes: the events of some milliseconds and the truth over them.

Needs matplotlib: ``asap-events[report]``. ``python -m asap.scene_figures FOLDER`` writes the
pictures of notebooks/scenes.md.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib
import numpy as np
from matplotlib.patches import Circle

from asap import plots, scenes

if TYPE_CHECKING:
    from asap.scenes import Scene

__all__ = ["documented", "snapshot"]

_LOOKAHEAD_S = 0.1


def snapshot(
    scene: Scene, t_ms: float | None = None, *, window_ms: float = 15.0
) -> plots.NotebookFigure:
    """Draw the events of the window that ends at a moment, and the truth at that moment.

    A circle is as wide as its object reaches, a line is its way in the next 100 ms, a dot a corner.

    Parameters
    ----------
    scene : Scene
        What is shown.
    t_ms : float, optional
        The moment; by default the middle of the scene.
    window_ms : float
        How far back the events go.

    Returns
    -------
    Figure
    """
    t_us = scene.duration_us / 2 if t_ms is None else t_ms * 1e3
    truth = scene.truth(t_us)
    first, end = np.searchsorted(scene.events["t"], [t_us - window_ms * 1e3, t_us])
    with matplotlib.rc_context(plots.STYLE):
        figure = plots.NotebookFigure(
            figsize=(4.6, 0.5 + 4.2 * scene.height / scene.width), layout="constrained"
        )
        axes = figure.add_subplot()
        plots.frame(scene.events[first:end], scene.width, scene.height, ax=axes)
        for thing, reach_px in zip(truth, scene.reaches_px, strict=True):
            x, y = float(thing["x"]), float(thing["y"])
            axes.add_patch(Circle((x, y), reach_px, fill=False, color=plots.INK, linewidth=0.8))
            ahead_x, ahead_y = (float(thing[v]) * _LOOKAHEAD_S for v in ("vx", "vy"))
            axes.plot([x, x + ahead_x], [y, y + ahead_y], color=plots.GREEN, linewidth=1.0)
            axes.text(x, y, str(thing["id"]), fontsize=6, ha="center", va="center")
        vertices = scene.vertices(t_us)
        axes.plot(vertices["x"], vertices["y"], ".", color=plots.INK, markersize=1.5)
        axes.set(xlim=(-0.5, scene.width - 0.5), ylim=(scene.height - 0.5, -0.5))
        axes.set_title(f"{scene.name}: {window_ms:g} ms before {t_us * 1e-6:.3f} s")
    return figure


def documented() -> list[tuple[Scene, float | None]]:
    """Scenes of the documentation, each with the moment that is shown, ms."""
    return [
        *((make(), None) for make in (scenes.A, scenes.B, scenes.C, scenes.D, scenes.E)),
        *((make(), None) for make in (scenes.F, scenes.G)),
        (scenes.timing(20, 346, 260, 600), None),
        (scenes.corners("slow"), None),
        (scenes.stop_and_go(), 690.0),
        (scenes.occlusion(), 600.0),
    ]


if __name__ == "__main__":
    for pictured, moment_ms in documented():
        picture = plots.svg(snapshot(pictured, moment_ms))
        Path(sys.argv[1], f"scene_{pictured.name}.svg").write_text(picture, encoding="utf-8")
