"""The figure of a recording: events, objects and boxes at labelled times, picture by picture."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.patches import Rectangle

from asap import plots
from asap_laboratory.rivals.recordings import Followed

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MAX_PICTURES = 12
_COLUMNS = 3
_WINDOW_US = 30_000  # of the events that are shown
_TAIL_S = 0.15


def draw(followed: Followed) -> plots.NotebookFigure:
    """Draw up to twelve labelled times, evenly apart.

    Coloured: an object's box, its id and its way in the last 150 ms; dashed, where no box goes with
    it. Thin: the boxes, vermilion where missed. Shaded: nothing is judged there.
    """
    last = len(followed.matches) - 1
    shown = sorted({round(index) for index in np.linspace(0, last, _MAX_PICTURES).tolist()})
    rows = math.ceil(len(shown) / _COLUMNS)
    height = rows * (0.3 + 3.2 * followed.scene.height / followed.scene.width)
    with matplotlib.rc_context(plots.STYLE):
        figure = plots.NotebookFigure(figsize=(9.6, 0.3 + height), layout="constrained")
        panels = figure.subplots(rows, _COLUMNS, squeeze=False).ravel()
        for axes in panels:
            axes.set_axis_off()
        for axes, index in zip(panels, shown, strict=False):
            _draw(axes, followed, index)
        figure.suptitle(followed.scene.name, x=0.005, ha="left", fontweight="bold")
    return figure


def _draw(axes: Axes, followed: Followed, index: int) -> None:
    scene, match = followed.scene, followed.matches[index]
    t_us = int(match.frame["t_us"][0])
    first, end = np.searchsorted(scene.events["t"], [t_us - _WINDOW_US, t_us])
    seen = np.zeros((scene.height, scene.width), bool)
    seen[scene.events["y"][first:end], scene.events["x"][first:end]] = True
    axes.imshow(np.where(seen, 0.6, 1.0), cmap="gray", vmin=0, vmax=1, interpolation="none")
    for x0, x1, y0, y1, from_us, to_us in scene.ignore.tolist():
        if from_us <= t_us < to_us:
            axes.add_patch(Rectangle((x0, y0), x1 - x0, y1 - y0, color=plots.FAINT, alpha=0.3))
    matched = {row for row, _ in match.pairs}
    for row, (x, y, w, h) in enumerate(match.frame[["x", "y", "w", "h"]].tolist()):
        colour = plots.INK if row in matched else plots.VERMILION
        axes.add_patch(Rectangle((x, y), w, h, fill=False, edgecolor=colour, linewidth=0.8))
    _draw_objects(axes, followed, index)
    axes.set(xlim=(-0.5, scene.width - 0.5), ylim=(scene.height - 0.5, -0.5))
    axes.set_title(_caption(followed, index), fontsize=8)


def _draw_objects(axes: Axes, followed: Followed, index: int) -> None:
    match, since_s = followed.matches[index], followed.times_s[index] - _TAIL_S
    recent = followed.matches[int(np.searchsorted(followed.times_s, since_s)) : index + 1]
    for row, id in enumerate(match.found.ids.tolist()):
        colour = f"C{id % 10}"
        ways = [one.found.positions[one.found.ids == id] for one in recent]
        axes.plot(*np.concatenate(ways).T, color=colour, linewidth=1.0)
        dashed = followed.scene.background_labelled and row in match.false
        style: dict[str, Any] = {
            "fill": False,
            "edgecolor": colour,
            "linestyle": "--" if dashed else "-",
        }
        left, top = match.found.positions[row]
        if match.found.boxes is not None:
            left, top, width, height = match.found.boxes[row]
            axes.add_patch(Rectangle((left, top), width, height, **style))
        axes.text(left, top, str(id), color=colour, fontsize=7, va="bottom", clip_on=True)


def _caption(followed: Followed, index: int) -> str:
    match = followed.matches[index]
    missed = len(match.frame) - len(match.pairs)
    parts = [f"{len(match.pairs)} of {len(match.frame)} hit"]
    parts += [f"{missed} missed"] if missed else []
    if match.false and followed.scene.background_labelled:
        parts.append(f"{len(match.false)} false")
    parts += [f"{len(match.switched)} with a new id"] if match.switched else []
    return f"{followed.times_s[index]:.3f} s: {', '.join(parts)}"
