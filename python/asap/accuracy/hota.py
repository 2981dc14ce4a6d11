"""HOTA: detection and association in one figure, over all strictnesses of the match."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from asap.accuracy.assignment import assign
from asap.accuracy.matching import Matched, distances, gates

_THRESHOLDS = np.arange(0.05, 0.99, 0.05)
_ROUNDING = 1e-9  # a similarity of just the threshold is enough


class Hota(NamedTuple):
    """Means over the thresholds .05, .1 ... .95."""

    hota: float
    detection: float  #: DetA = TP / (TP + FN + FP)
    association: float  #: AssA: mean over the TP of TPA / (TPA + FNA + FPA)


class _Frame(NamedTuple):
    """Active objects and counted clusters of a sample, as rows and columns of the whole scene."""

    rows: NDArray[np.int64]
    columns: NDArray[np.int64]
    similarity: NDArray[np.float64]  # max(0, 1 - d / 2 gates): one half at the gate


def hota(matches: Sequence[Matched]) -> Hota:
    """Score detection and association of objects and ids.

    Parameters
    ----------
    matches : sequence of Matched
        Only active objects and counted clusters are looked at, not their pairs.

    Returns
    -------
    Hota
        NaN without any object or cluster.

    Notes
    -----
    Luiten et al.: HOTA: A Higher Order Metric for Evaluating Multi-Object Tracking, IJCV 2021, with
    the matching of its authors' TrackEval: in each sample the assignment that maximises the sum of
    similarity times the agreement of the two tracks over the whole scene.
    """
    frames, objects, ids = _frames(matches)
    samples_of_object, samples_of_id = np.zeros(objects), np.zeros(ids)
    agreement = np.zeros((objects, ids))
    for frame in frames:
        samples_of_object[frame.rows] += 1
        samples_of_id[frame.columns] += 1
        similar = frame.similarity
        either = similar.sum(0)[None, :] + similar.sum(1)[:, None] - similar
        agreement[np.ix_(frame.rows, frame.columns)] += _share(similar, either)
    both = samples_of_object[:, None] + samples_of_id[None, :]
    agreement = _share(agreement, both - agreement)

    together = np.zeros((_THRESHOLDS.size, objects, ids))
    for frame in frames:
        worth = agreement[np.ix_(frame.rows, frame.columns)] * frame.similarity
        row, column = assign(-worth)
        enough = frame.similarity[row, column] >= _THRESHOLDS[:, None] - _ROUNDING
        together[:, frame.rows[row], frame.columns[column]] += enough
    true_positives = together.sum((1, 2))
    detection = _share(true_positives, _united(samples_of_object, samples_of_id, true_positives))
    association = _share((together * _share(together, both - together)).sum((1, 2)), true_positives)
    if objects == 0 and ids == 0:
        return Hota(*[float("nan")] * 3)
    return Hota(
        float(np.sqrt(detection * association).mean()),
        float(detection.mean()),
        float(association.mean()),
    )


def _united(
    objects: NDArray[np.float64], ids: NDArray[np.float64], shared: NDArray[np.float64]
) -> NDArray[np.float64]:
    """TP + FN + FP: all samples of objects and ids, the shared ones once."""
    return np.asarray(objects.sum() + ids.sum() - shared)


def _frames(matches: Sequence[Matched]) -> tuple[list[_Frame], int, int]:
    objects: dict[int, int] = {}
    ids: dict[int, int] = {}
    frames = []
    for one in matches:
        sample = one.sample
        similarity = np.maximum(0.0, 1 - distances(sample) / (2 * gates(sample)))
        seen, found = sample.objects[sample.active], sample.clusters.ids[one.counted]
        frames.append(
            _Frame(
                np.array([objects.setdefault(o, len(objects)) for o in seen.tolist()], np.int64),
                np.array([ids.setdefault(i, len(ids)) for i in found.tolist()], np.int64),
                similarity[np.ix_(sample.active, one.counted)],
            )
        )
    return frames, len(objects), len(ids)


def _share(part: NDArray[np.float64], whole: NDArray[np.float64]) -> NDArray[np.float64]:
    """Divide; 0 of nothing is 0."""
    return np.divide(part, whole, out=np.zeros_like(part), where=whole > 0)
