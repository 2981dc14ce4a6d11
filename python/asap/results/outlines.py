"""What an algorithm has found in the image, in outline."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from asap import _core
from asap.events import EVENT_DTYPE

CORNERS = 24
OUTLINE_DTYPE = np.dtype(
    [("id", "<i8"), ("x", "<f4"), ("y", "<f4"), ("outline", "<f4", (CORNERS, 2))]
)

_TURN = np.linspace(0, 2 * np.pi, CORNERS)
_CIRCLE = np.stack([np.cos(_TURN), np.sin(_TURN)], axis=1)
_BOX = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]])[np.arange(CORNERS) // 5]
_RADIUS_PX = 4.0  # of what has no size


def found_by(algorithm: Any) -> NDArray[np.void]:
    """Return the objects or the clusters that an algorithm has now, if it has any, in outline."""
    for name in ("objects", "clusters"):
        found = getattr(algorithm, name, None)
        if isinstance(found, np.ndarray) and {"id", "x", "y"} <= set(found.dtype.names or ()):
            return outlines_of(found)
    return np.empty(0, OUTLINE_DTYPE)


def shown_by(tracks: Any, begin_us: int, end_us: int) -> tuple[NDArray[np.void], ...]:
    """Return events and outlines of a stretch of the time that `Tracks` has noted."""
    if tracks is None:
        return np.empty(0, EVENT_DTYPE), np.empty(0, OUTLINE_DTYPE)
    seen, rows = tracks.seen, tracks.tracks
    rows = rows[slice(*np.searchsorted(rows["t"], (begin_us, end_us)))]
    last = rows[rows["t"] == rows["t"][-1]] if len(rows) else rows
    return seen[slice(*np.searchsorted(seen["t"], (begin_us, end_us)))], outlines_of(last)


def outlines_of(found: NDArray[np.void]) -> NDArray[np.void]:
    """Draw a box where there is one, an ellipse of two standard deviations, or a small circle."""
    names = set(found.dtype.names or ())
    drawn = np.empty(len(found), OUTLINE_DTYPE)
    for name in ("id", "x", "y"):
        drawn[name] = found[name]
    for one, outline in zip(found, drawn["outline"], strict=True):
        if {"left", "top"} <= names:
            outline[:] = (one["left"], one["top"]) + _BOX * (one["width"], one["height"])
        elif "cxx" in names:
            ellipse = _core.outline_of(*(one[name] for name in ("x", "y", "cxx", "cxy", "cyy")))
            cos, sin = np.cos(ellipse["angle"]), np.sin(ellipse["angle"])
            axes = _CIRCLE * (ellipse["major"], ellipse["minor"])
            outline[:] = (one["x"], one["y"]) + axes @ [[cos, sin], [-sin, cos]]
        else:
            outline[:] = (one["x"], one["y"]) + _CIRCLE * _RADIUS_PX
    return drawn
