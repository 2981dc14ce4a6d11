"""The matching protocol: which cluster is which object, sample by sample."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from asap_laboratory.scoring.trace import Sample

GATE_PX = 12.0  #: a cluster farther from a centre than this is not the object, unless said else


class Matched(NamedTuple):
    """One sample with its matches."""

    sample: Sample
    pairs: NDArray[np.int64]  #: (tp, 2): row of the object, row of the cluster; the nearest first
    distances: NDArray[np.float64]  #: px, of each pair
    counted: NDArray[np.bool_]  #: clusters that no inactive object excuses: matched or false
    switches: int  #: objects matched to another id than before
    memory: dict[int, int]  #: id last matched to each object, this sample included


def match(samples: Iterable[Sample]) -> list[Matched]:
    """Match clusters to objects in every sample, in time order.

    Candidates are pairs of a cluster and an active object less than 12 px apart, or less than the
    gate that the scene gives for the object. They are taken greedily, one to one: pairs that repeat
    the id that the object had last, then the others, each by ascending distance. A cluster left
    over is false unless it is within the gate of an inactive object. The memory of an object's id
    survives misses.
    """
    memory: dict[int, int] = {}
    return [_match(sample, memory) for sample in samples]


def _match(sample: Sample, memory: dict[int, int]) -> Matched:
    ids = sample.clusters.ids
    distance = distances(sample)
    near = distance < gates(sample)
    rows, columns = np.nonzero(near & sample.active[:, None])
    last = np.array([memory.get(one, -1) for one in sample.objects.tolist()], np.int64)
    repeats = ids[columns] == last[rows]
    taken_objects: set[int] = set()
    taken_clusters: set[int] = set()
    pairs = []
    switches = 0
    for candidate in np.lexsort((distance[rows, columns], ~repeats)):
        row, column = int(rows[candidate]), int(columns[candidate])
        if row in taken_objects or column in taken_clusters:
            continue
        taken_objects.add(row)
        taken_clusters.add(column)
        pairs.append((row, column))
        label, id = int(sample.objects[row]), int(ids[column])
        switches += memory.get(label, id) != id
        memory[label] = id
    excused = np.any(near & ~sample.active[:, None], axis=0)
    matched = np.isin(np.arange(ids.size), list(taken_clusters))
    table = np.array(pairs, np.int64).reshape(-1, 2)
    return Matched(
        sample, table, distance[table[:, 0], table[:, 1]], matched | ~excused, switches, {**memory}
    )


def distances(sample: Sample) -> NDArray[np.float64]:
    """Return the distances of every object to every cluster, shape (k, m), px."""
    between = sample.centres[:, None] - sample.clusters.positions[None]
    return np.asarray(np.hypot(between[..., 0], between[..., 1]))


def gates(sample: Sample) -> NDArray[np.float64]:
    """Return how near a cluster has to be to each object, shape (k, 1), px."""
    if sample.gates_px is None:
        return np.full((sample.objects.size, 1), GATE_PX)
    return sample.gates_px[:, None]
