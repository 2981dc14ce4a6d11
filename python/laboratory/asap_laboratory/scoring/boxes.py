"""Clusters against the boxes of a labelled recording: hit, precision, switches, error, IoU."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator
from itertools import pairwise
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from asap_laboratory.scoring.measures import ratio
from asap_laboratory.scoring.trace import Snapshot

PADDING_PX = 2.0  #: a centre counts as inside so far beyond the edge of a box

# Costs of a pair that put the number of pairs first, then the ids that go on, then the distance.
_APART = 1e12
_NEW_ID = 1e6


class BoxScene(Protocol):
    """Anything with these attributes, such as an `asap_laboratory.scenes.LabelledScene`."""

    @property
    def events(self) -> NDArray[np.void]: ...  # noqa: D102
    @property
    def boxes(self) -> NDArray[np.void]:
        """t_us, id, x, y, w, h of every box, in time order."""
        ...

    @property
    def ignore(self) -> NDArray[np.void]:
        """x0, x1, y0, y1, from_us, to_us of every zone that is not judged."""
        ...

    @property
    def background_labelled(self) -> bool: ...  # noqa: D102


class BoxScore(NamedTuple):
    """Sums over all labelled times; NaN where there was nothing to divide by."""

    hit: float  #: matched boxes / all boxes
    precision: float  #: matched / (matched + false); NaN: not judged
    switches: int  #: changes of an object's id
    longest: float  #: share of an object's boxes that its best id matched, mean over the objects
    error: float  #: px, median distance of the matched centres
    iou: float  #: area shared by matched boxes / area of both, mean; NaN: clusters without extent
    mota: float  #: 1 - (misses + false + switches) / all boxes; NaN: not judged


class BoxMatch(NamedTuple):
    """A labelled time with its matches."""

    frame: NDArray[np.void]  #: its boxes
    found: Snapshot  #: the clusters at that time
    pairs: list[tuple[int, int]]  #: rows of the boxes and of the clusters that go together
    distances: list[float]  #: px, between the centres of each pair
    overlaps: list[float]  #: intersection over union of each pair; NaN: a cluster without extent
    switched: list[int]  #: rows of the boxes whose object had another id when it was matched last
    false: list[int]  #: rows of the clusters without a box, those in ignore zones left out


def frames(boxes: NDArray[np.void]) -> Iterator[NDArray[np.void]]:
    """Yield the boxes of each labelled time."""
    begins = np.flatnonzero(np.diff(boxes["t_us"], prepend=boxes["t_us"][0] - 1))
    for begin, end in pairwise([*begins.tolist(), boxes.size]):
        yield boxes[begin:end]


def box_matches(scene: BoxScene, snapshots: list[Snapshot]) -> list[BoxMatch]:
    """Match clusters to boxes at every labelled time; `snapshots` are those of its `frames`.

    Candidates are pairs whose cluster has its centre in the box or up to 2 px beyond. The one to
    one assignment matches the most boxes, then repeats the most ids that the objects had last, then
    has the least total distance (Hungarian method). A cluster left over is false unless it lies in
    an ignore zone.
    """
    last: dict[int, int] = {}
    return [
        _matches(scene.ignore, frame, found, last)
        for frame, found in zip(frames(scene.boxes), snapshots, strict=True)
    ]


def box_score(scene: BoxScene, matches: list[BoxMatch]) -> BoxScore:
    """Count matches, misses and false clusters.

    Where the background is not labelled, a false cluster cannot be told from a right one: precision
    and mota are NaN.
    """
    carried: defaultdict[int, Counter[int]] = defaultdict(Counter)
    for one in matches:
        for row, column in one.pairs:
            carried[int(one.frame["id"][row])][int(one.found.ids[column])] += 1
    labels, lives = np.unique(scene.boxes["id"], return_counts=True)
    best = [max(carried[label].values(), default=0) for label in labels.tolist()]
    distances = [distance for one in matches for distance in one.distances]
    overlaps = [overlap for one in matches for overlap in one.overlaps]
    switches = sum(len(one.switched) for one in matches)
    false = sum(len(one.false) for one in matches)
    hits, boxes = len(distances), scene.boxes.size
    judged = scene.background_labelled
    return BoxScore(
        hit=ratio(hits, boxes),
        precision=ratio(hits, hits + false) if judged else float("nan"),
        switches=switches,
        longest=float(np.mean(np.array(best) / lives)),
        error=float(np.median(distances)) if distances else float("nan"),
        iou=float(np.mean(overlaps)) if overlaps else float("nan"),
        mota=1 - ratio(boxes - hits + false + switches, boxes) if judged else float("nan"),
    )


def _matches(
    ignore: NDArray[np.void], frame: NDArray[np.void], found: Snapshot, last: dict[int, int]
) -> BoxMatch:
    distance = _distances(frame, found)
    pairs = _matched(distance, frame["id"], found.ids, last)
    switched = []
    for row, column in pairs:
        label, id = int(frame["id"][row]), int(found.ids[column])
        if last.get(label, id) != id:
            switched.append(row)
        last[label] = id
    false = ~_in_a_zone(ignore, int(frame["t_us"][0]), found.positions)
    false[[column for _, column in pairs]] = False
    return BoxMatch(
        frame,
        found,
        pairs,
        [float(distance[pair]) for pair in pairs],
        [_overlap(frame[row], found, column) for row, column in pairs],
        switched,
        np.flatnonzero(false).tolist(),
    )


def _distances(frame: NDArray[np.void], found: Snapshot) -> NDArray[np.float64]:
    """From the centre of each box to each cluster, px; infinite from a cluster outside the box."""
    half = 0.5 * np.stack([frame["w"], frame["h"]], axis=-1)
    centres = np.stack([frame["x"], frame["y"]], axis=-1) + half
    away = np.abs(found.positions - centres[:, None])
    inside = np.all(away <= half[:, None] + PADDING_PX, axis=2)
    return np.where(inside, np.hypot(away[..., 0], away[..., 1]), np.inf)


def _overlap(box: np.void, found: Snapshot, column: int) -> float:
    if found.boxes is None:
        return float("nan")
    left, top, width, height = found.boxes[column].tolist()
    shared = _shared(box["x"], box["w"], left, width) * _shared(box["y"], box["h"], top, height)
    return float(ratio(shared, box["w"] * box["h"] + width * height - shared))


def _shared(a: float, a_length: float, b: float, b_length: float) -> float:
    return max(0.0, min(a + a_length, b + b_length) - max(a, b))


def _matched(
    distance: NDArray[np.float64],
    labels: NDArray[np.int64],
    ids: NDArray[np.int64],
    last: dict[int, int],
) -> list[tuple[int, int]]:
    """Rows of the boxes and of the clusters that go together."""
    ids_before = np.array([last.get(label, -1) for label in labels.tolist()])
    cost = np.minimum(distance + _NEW_ID * (ids != ids_before[:, None]), _APART)
    pairs = zip(*(side.tolist() for side in linear_sum_assignment(cost)), strict=True)
    return [(row, column) for row, column in pairs if np.isfinite(distance[row, column])]


def _in_a_zone(zones: Any, t_us: int, positions: NDArray[np.float64]) -> NDArray[np.bool_]:
    x, y = positions.T[..., None]
    now = (zones["from_us"] <= t_us) & (t_us < zones["to_us"])
    inside = (zones["x0"] <= x) & (x < zones["x1"]) & (zones["y0"] <= y) & (y < zones["y1"])
    return np.asarray(np.any(inside & now, axis=1))
