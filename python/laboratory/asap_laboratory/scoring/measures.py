"""Scores of a tracker: MOTA, IDF1, HOTA and NEES of its matches, V-measure of its events."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from sklearn.metrics import v_measure_score

from asap_laboratory.scoring.matching import Matched, distances, gates
from asap_laboratory.scoring.trace import Trace

_ROUNDING = 1e-9
_SETTLED_US = 200_000  # events before it do not count


class Mota(NamedTuple):
    """Sums over all samples; NaN where there was nothing to divide by."""

    mota: float  #: 1 - (FN + FP + id switches) / (TP + FN); may be negative
    id_switches: int
    recall: float  #: TP / (TP + FN)
    precision: float  #: TP / (TP + FP)
    true_positives: int
    false_negatives: int
    false_positives: int
    position_rms: float  #: px, over the matches
    velocity_rms: float  #: of the rms speed, over the matches; NaN without velocities


def mota(matches: Sequence[Matched]) -> Mota:
    """Count matches, misses and false clusters.

    Bernardin, Stiefelhagen: Evaluating Multiple Object Tracking Performance, 2008.
    """
    tp = sum(len(one.pairs) for one in matches)
    fn = sum(int(one.sample.active.sum()) - len(one.pairs) for one in matches)
    fp = sum(int(one.counted.sum()) - len(one.pairs) for one in matches)
    switches = sum(one.switches for one in matches)
    squared_px = sum(float(np.sum(one.distances**2)) for one in matches)
    return Mota(
        mota=1 - ratio(fn + fp + switches, tp + fn),
        id_switches=switches,
        recall=ratio(tp, tp + fn),
        precision=ratio(tp, tp + fp),
        true_positives=tp,
        false_negatives=fn,
        false_positives=fp,
        position_rms=math.sqrt(ratio(squared_px, tp)),
        velocity_rms=_velocity_rms(matches),
    )


def ratio(part: float, whole: float) -> float:
    """Divide; NaN where there is nothing to divide by."""
    return part / whole if whole else float("nan")


def _velocity_rms(matches: Sequence[Matched]) -> float:
    error = speed = 0.0
    for one in matches:
        velocities = one.sample.clusters.velocities
        if velocities is None:
            return float("nan")
        rows, columns = one.pairs.T
        true = one.sample.speeds[rows]
        error += _sum_of_squares(velocities[columns] - true)
        speed += _sum_of_squares(true)
    return math.sqrt(ratio(error, speed))


def _sum_of_squares(values: NDArray[np.float64]) -> float:
    return float(np.sum(values**2))


def idf1(matches: Sequence[Matched]) -> float:
    """Score the best one-to-one assignment of ids to objects: 2 IDTP / (2 IDTP + IDFP + IDFN).

    An id and its active object agree in a sample where they are less than the gate of the match
    apart. NaN without any object or cluster. Ristani, Solera, Zou, Cucchiara, Tomasi: Performance
    Measures and a Data Set for Multi-Target, Multi-Camera Tracking, 2016.
    """
    import trackeval

    sequence = _sequence(matches)
    if not sequence["num_gt_dets"] + sequence["num_tracker_dets"]:
        return float("nan")
    # A similarity of just one half is at the gate: that is no agreement.
    metric = trackeval.metrics.Identity({"THRESHOLD": 0.5 + _ROUNDING, "PRINT_CONFIG": False})
    return float(metric.eval_sequence(sequence)["IDF1"])


class Hota(NamedTuple):
    """Means over the thresholds .05, .1 ... .95."""

    hota: float
    detection: float  #: DetA = TP / (TP + FN + FP)
    association: float  #: AssA: mean over the TP of TPA / (TPA + FNA + FPA)


def hota(matches: Sequence[Matched]) -> Hota:
    """Score detection and association of active objects and counted clusters; NaN without any.

    Luiten et al.: HOTA: A Higher Order Metric for Evaluating Multi-Object Tracking, IJCV 2021, with
    the matching of its authors' TrackEval: in each sample the assignment that maximises the sum of
    similarity times the agreement of the two tracks over the whole scene.
    """
    import trackeval

    sequence = _sequence(matches)
    if not sequence["num_gt_dets"] + sequence["num_tracker_dets"]:
        return Hota(*[float("nan")] * 3)
    found = trackeval.metrics.HOTA().eval_sequence(sequence)
    return Hota(*(float(np.mean(found[name])) for name in ("HOTA", "DetA", "AssA")))


def _sequence(matches: Sequence[Matched]) -> dict[str, Any]:
    """Active objects and counted clusters of every sample, as TrackEval's metrics take them.

    Their similarity is max(0, 1 - d / 2 gates): one half at the gate.
    """
    objects: dict[int, int] = {}
    ids: dict[int, int] = {}
    truth, seen, similarities = [], [], []
    for one in matches:
        sample = one.sample
        there, found = sample.objects[sample.active], sample.clusters.ids[one.counted]
        truth.append(np.array([objects.setdefault(o, len(objects)) for o in there.tolist()], int))
        seen.append(np.array([ids.setdefault(i, len(ids)) for i in found.tolist()], int))
        similarity = np.maximum(0.0, 1 - distances(sample) / (2 * gates(sample)))
        similarities.append(similarity[np.ix_(sample.active, one.counted)])
    return {
        "num_timesteps": len(matches),
        "num_gt_ids": len(objects),
        "num_tracker_ids": len(ids),
        "num_gt_dets": sum(map(len, truth)),
        "num_tracker_dets": sum(map(len, seen)),
        "gt_ids": truth,
        "tracker_ids": seen,
        "similarity_scores": similarities,
    }


def nees(matches: Sequence[Matched]) -> float:
    """Compare the errors e of matched positions with the covariances P that the tracker states.

    Mean of e' P^-1 e: 2 where they agree, more where it is too sure of itself; NaN where it states
    none. Bar-Shalom, Li, Kirubarajan: Estimation with Applications to Tracking and Navigation,
    2001, section 5.4.
    """
    total, count = 0.0, 0
    for one in matches:
        covariances = one.sample.clusters.covariances
        if covariances is None:
            return float("nan")
        rows, columns = one.pairs.T
        error = one.sample.clusters.positions[columns] - one.sample.centres[rows]
        weighted = np.linalg.solve(covariances[columns], error[:, :, None])[:, :, 0]
        total += float(np.sum(error * weighted))
        count += len(error)
    return ratio(total, count)


def v_measure(trace: Trace) -> float:
    """Compare the ids of the events after 200 ms with their labels, as two partitions.

    Noise and no id (-1) are classes too; 1 is the same. NaN where the tracker returns no ids.
    Rosenberg, Hirschberg: V-Measure, EMNLP-CoNLL 2007.
    """
    settled = trace.t_us >= _SETTLED_US
    if trace.ids is None or not settled.any():
        return float("nan")
    return float(v_measure_score(trace.labels[settled], trace.ids[settled]))
