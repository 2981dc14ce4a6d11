"""IDF1: how long each object is followed under one id, with one assignment for the whole scene."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from asap.accuracy.assignment import assign
from asap.accuracy.matching import Matched, distances, gates
from asap.accuracy.mota import ratio


def idf1(matches: Sequence[Matched]) -> float:
    """Score the best one-to-one assignment of ids to objects.

    Parameters
    ----------
    matches : sequence of Matched
        Only active objects and counted clusters are looked at, not their pairs.

    Returns
    -------
    float
        2 IDTP / (2 IDTP + IDFP + IDFN); an id and its object agree in a sample where they are less
        than the gate of the match apart. NaN without any object or cluster.

    Notes
    -----
    Ristani, Solera, Zou, Cucchiara, Tomasi: Performance Measures and a Data Set for Multi-Target,
    Multi-Camera Tracking, 2016.
    """
    together: Counter[tuple[int, int]] = Counter()
    samples_of_objects = samples_of_ids = 0
    for one in matches:
        sample = one.sample
        near = (distances(sample) < gates(sample)) & sample.active[:, None] & one.counted
        for row, column in zip(*np.nonzero(near), strict=True):
            together[int(sample.objects[row]), int(sample.clusters.ids[column])] += 1
        samples_of_objects += int(sample.active.sum())
        samples_of_ids += int(one.counted.sum())
    true_positives = _most_agreements(together)
    return ratio(2 * true_positives, samples_of_objects + samples_of_ids)


def _most_agreements(together: Counter[tuple[int, int]]) -> int:
    objects = sorted({pair[0] for pair in together})
    ids = sorted({pair[1] for pair in together})
    table = np.zeros((len(objects), len(ids)))
    for (label, id), count in together.items():
        table[objects.index(label), ids.index(id)] = count
    return int(table[assign(-table)].sum())
