"""Corner events against exact vertices."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from asap.accuracy.mota import ratio
from asap.accuracy.scene import NOISE, Scene
from asap.accuracy.trace import Feed

__all__ = ["RADIUS_PX", "Corners", "corners"]

RADIUS_PX = 3.5  #: an event this near to a vertex of its own object is a true corner
_STEP_US = 250  # of the truth of asap.scenes


class Corners(NamedTuple):
    """Corner labels against the truth."""

    precision: float  #: share of the events called corners that are corners
    recall: float  #: share of the corners that are called so: true-positive rate
    false_positive_rate: float  #: share of the others that are called corners
    f_measure: float  #: 2 / (1 / precision + 1 / recall)
    corner_events: int  #: events called corners
    true_corners: int  #: events that are


def corners(scene: Scene, feed: Feed) -> Corners:
    """Score a corner detector.

    Parameters
    ----------
    scene : Scene
        With ``vertices(t_us)``: structured array with id, x, y.
    feed : Feed
        With a bool for each event.

    Raises
    ------
    TypeError
        The scene has no vertices.

    Notes
    -----
    True corners are events within 3.5 px of a vertex of their own object at their time. Many events
    in such a disc lie on an edge, so recall is low for the best detector too: compare detectors.
    """
    if not hasattr(scene, "vertices"):
        raise TypeError(
            f"scene: a {type(scene).__name__} without vertices(t_us), which a corner detector needs"
        )
    assert feed.returned is not None
    called = feed.returned.astype(bool)
    labels = np.asarray(scene.labels)[feed.indices].astype(np.int64)
    truth = _near_a_vertex(scene, scene.events[feed.indices], labels)
    hits = int(np.sum(called & truth))
    precision, recall = ratio(hits, int(called.sum())), ratio(hits, int(truth.sum()))
    return Corners(
        precision,
        recall,
        ratio(int(np.sum(called & ~truth)), int(np.sum(~truth))),
        ratio(2 * hits, int(called.sum()) + int(truth.sum())),
        int(called.sum()),
        int(truth.sum()),
    )


def _near_a_vertex(
    scene: Any, events: NDArray[np.void], labels: NDArray[np.int64]
) -> NDArray[np.bool_]:
    near = np.zeros(events.size, bool)
    step = events["t"] // _STEP_US
    bounds = np.flatnonzero(np.diff(step, prepend=-1, append=-1))
    for begin, end in pairwise(bounds.tolist()):
        vertices = scene.vertices(int(step[begin]) * _STEP_US)
        now = slice(begin, end)
        dx = events["x"][now, None] - vertices["x"][None]
        dy = events["y"][now, None] - vertices["y"][None]
        own = (labels[now, None] == vertices["id"][None]) & (labels[now, None] != NOISE)
        near[now] = np.any(own & (dx**2 + dy**2 <= RADIUS_PX**2), axis=1)
    return near
