"""Corner events against exact vertices."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from asap_laboratory.scoring.measures import ratio
from asap_laboratory.scoring.scene import NOISE, Scene
from asap_laboratory.scoring.trace import Feed

RADIUS_PX = 3.5  #: an event this near to a vertex of its own object is a true corner
_STEP_US = 250  # of the truth of asap_laboratory.scenes


class Corners(NamedTuple):
    """Corner labels against the truth."""

    precision: float  #: share of the events called corners that are corners
    recall: float  #: share of the corners that are called so: true-positive rate
    false_positive_rate: float  #: share of the others that are called corners
    f_measure: float  #: 2 / (1 / precision + 1 / recall)
    corner_events: int  #: events called corners
    true_corners: int  #: events that are


def corners(scene: Scene, feed: Feed) -> Corners:
    """Score a corner detector on a scene with ``vertices(t_us)`` by the bools that it returned.

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
    truth = near_a_vertex(scene, scene.events[feed.indices], labels)
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


def near_a_vertex(
    scene: Any, events: NDArray[np.void], labels: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Return which events, in time order, are true corners; `labels` are their objects.

    Fast where the scene names its vertices in the same order at all times.
    """
    near = np.zeros(events.size, bool)
    if events.size == 0:
        return near
    steps, at = np.unique(events["t"] // _STEP_US, return_inverse=True)
    ids, places = _at_each(scene, steps.tolist())
    for label in np.unique(ids[ids != NOISE]):
        mine = np.flatnonzero(labels == label)
        columns = np.flatnonzero(np.any(ids == label, axis=0))
        now = at[mine, None], columns[None]
        dx = events["x"][mine, None] - places[now][..., 0]
        dy = events["y"][mine, None] - places[now][..., 1]
        near[mine] = np.any((ids[now] == label) & (dx**2 + dy**2 <= RADIUS_PX**2), axis=1)
    return near


def _at_each(scene: Any, steps: list[int]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return object and place of the vertices, one row for each step; what is missing is noise."""
    found = [scene.vertices(step * _STEP_US) for step in steps]
    most = max(len(vertices) for vertices in found)
    ids = np.full((len(steps), most), NOISE, np.int64)
    places = np.full((len(steps), most, 2), np.inf)
    for row, vertices in enumerate(found):
        ids[row, : len(vertices)] = vertices["id"]
        places[row, : len(vertices), 0] = vertices["x"]
        places[row, : len(vertices), 1] = vertices["y"]
    return ids, places
