"""Pictures of events, and what an algorithm has found in them, in outline."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from asap import _core
from asap.events import EVENT_DTYPE, Events

CORNERS = 24
OUTLINE_DTYPE = np.dtype(
    [("id", "<i8"), ("x", "<f4"), ("y", "<f4"), ("outline", "<f4", (CORNERS, 2))]
)

COLOURS = [  # of a painted picture: none, OFF and ON, each from older to newer
    (14, 17, 22),
    *((27, 62, 107), (44, 111, 196), (94, 173, 255)),
    *((110, 38, 30), (205, 70, 52), (255, 122, 92)),
]
BRIGHT = [(255, 209, 82), (94, 230, 166), (214, 140, 255), (255, 255, 255), (92, 220, 255)]

FRAME_US = 40_000

_NONE = np.empty(0, [("id", "<i8"), ("t", "<i8"), ("x", "<f8"), ("y", "<f8")])  # found
_TURN = np.linspace(0, 2 * np.pi, CORNERS)
_CIRCLE = np.stack([np.cos(_TURN), np.sin(_TURN)], axis=1)
_BOX = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]])[np.arange(CORNERS) // 5]
_RADIUS_PX = 4.0  # of what has no size


def painted(events: Events, size: tuple[int, int]) -> NDArray[np.uint8]:
    """Paint events by their numbers in COLOURS, the newest on top; larger, where they reach out."""
    x, y, t = events["x"], events["y"], events["t"]
    image = np.zeros(
        [max(side, int(at.max(initial=0)) + 1) for side, at in zip(size, (y, x), strict=True)],
        np.uint8,
    )
    if len(events):
        age = (t[-1] - t) / max(int(t[-1] - t[0]), 1)
        image[y, x] = np.clip(3 - (age * 3).astype(np.uint8), 1, 3) + 3 * (events["p"] > 0)
    return image


def found_by(algorithm: Any) -> NDArray[np.void]:
    """Return the objects or the clusters that an algorithm has now, if it has any."""
    for name in ("objects", "clusters"):
        found = getattr(algorithm, name, None)
        if isinstance(found, np.ndarray) and {"id", "x", "y"} <= set(found.dtype.names or ()):
            return found
    return _NONE


def frames(run: Any, rows: NDArray[np.void]) -> Iterator[tuple[Any, ...]]:
    """Cut a run into `FRAME_US`: time, s, rows of its log, events and what `Tracks` found last."""
    begin, end = (rows["t_first"][0], rows["t_last"][-1] + 1) if len(rows) else (0, 1)
    seen, noted = np.empty(0, EVENT_DTYPE), _NONE
    if hasattr(run.algorithm, "seen"):
        seen, noted = run.algorithm.seen, run.algorithm.tracks
    for start in range(begin, end, FRAME_US):
        log, events, found = (
            some[slice(*np.searchsorted(some[stamp], (start, start + FRAME_US)))]
            for some, stamp in ((rows, "t_last"), (seen, "t"), (noted, "t"))
        )
        found = found[found["t"] == found["t"].max(initial=0)]
        yield (start - begin) * 1e-6, log, events, found


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
