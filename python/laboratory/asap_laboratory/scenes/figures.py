"""Pictures of scenes: the events of some milliseconds and the truth over them.

Needs matplotlib: ``asap-events[report]``.
"""

from __future__ import annotations

from typing import Any

import matplotlib
import numpy as np
from numpy.typing import NDArray

from asap import _checks, plots

_LOOKAHEAD_S = 0.1


def snapshot(
    scene: Any, t_ms: float | None = None, *, window_ms: float = 15.0
) -> plots.NotebookFigure:
    """Draw the events of the window that ends at a moment, and the truth at that moment.

    Dark: the true outlines and the objects' numbers. Green: each one's way in the next 100 ms.
    Without a moment it is the middle of the scene.
    """
    if t_ms is not None:
        remedy = f"give a time from 0 to {scene.duration_us / 1e3:g} ms"
        _checks.number("t_ms", t_ms, 0, scene.duration_us / 1e3, remedy)
    _checks.number("window_ms", window_ms, 0, 1e8, "give 0 ms or more")
    t_us = scene.duration_us / 2 if t_ms is None else t_ms * 1e3
    truth = scene.truth(t_us)
    first, end = np.searchsorted(scene.events["t"], [t_us - window_ms * 1e3, t_us])
    with matplotlib.rc_context(plots.STYLE):
        figure = plots.NotebookFigure(
            figsize=(4.6, 0.5 + 4.2 * scene.height / scene.width), layout="constrained"
        )
        axes = figure.add_subplot()
        plots.frame(scene.events[first:end], scene.width, scene.height, ax=axes)
        axes.images[0].set_interpolation("none")  # as many pixels as the sensor has
        axes.plot(*_joined(_outlines(scene, t_us)), color=plots.INK, linewidth=0.8)
        ways = [
            np.array([[x, y], [x + vx * _LOOKAHEAD_S, y + vy * _LOOKAHEAD_S]])
            for _, x, y, vx, vy in truth.tolist()
        ]
        axes.plot(*_joined(ways), color=plots.GREEN, linewidth=1.0)
        for number, x, y, *_ in truth.tolist():
            axes.text(x, y, str(number), fontsize=8, ha="center", va="center")
        axes.set(xlim=(-0.5, scene.width - 0.5), ylim=(scene.height - 0.5, -0.5))
        axes.set_title(f"{scene.name}: {window_ms:g} ms before {t_us * 1e-6:.3f} s")
    return figure


def _outlines(scene: Any, t_us: float) -> list[NDArray[np.float64]]:
    """Each object's outline as points of shape (n, 2), closed."""
    vertices = scene.vertices(t_us)
    angles = np.linspace(0.0, 2 * np.pi, 25)
    outlines = []
    for thing, reach_px in zip(scene.truth(t_us), scene.reaches_px(t_us), strict=True):
        own = vertices[vertices["id"] == thing["id"]]
        if own.size:
            outline = np.stack([np.append(own[v], own[v][0]) for v in "xy"], axis=1)
        else:
            circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
            outline = [thing["x"], thing["y"]] + reach_px * circle
        outlines.append(outline)
    return outlines


def _joined(lines: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    """All lines as one, with gaps: shape (2, n)."""
    gap = np.full((1, 2), np.nan)
    parts = [part for line in lines for part in (line, gap)]
    points: NDArray[np.float64] = np.concatenate([gap, *parts]).T
    return points
