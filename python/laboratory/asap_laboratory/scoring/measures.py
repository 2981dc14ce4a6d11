"""Scores of a tracker from its matches: MOTA, IDF1, HOTA, NEES, and the labels of events."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from asap_laboratory.scoring.matching import Matched, distances, gates
from asap_laboratory.scoring.scene import NOISE
from asap_laboratory.scoring.trace import Trace

_ROUNDING = 1e-9


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


_DIMENSIONS = 2


class Nees(NamedTuple):
    """Normalised estimation error squared, mean over the matches, and where it should lie.

    NaN where the tracker states no covariance of its positions, or nothing was matched.
    """

    nees: float  #: mean of e' P^-1 e; above the interval: too sure of itself, below: too modest
    nees_low: float  #: 95 % interval of a consistent tracker with independent errors
    nees_high: float


def nees(matches: Sequence[Matched]) -> Nees:
    """Compare the errors of matched positions with the covariances that the tracker states.

    Bar-Shalom, Li, Kirubarajan: Estimation with Applications to Tracking and Navigation, 2001,
    section 5.4. Errors 5 ms apart are not independent: a consistent tracker may leave the interval.
    """
    total, count = 0.0, 0
    for one in matches:
        covariances = one.sample.clusters.covariances
        if covariances is None:
            return Nees(*[float("nan")] * 3)
        rows, columns = one.pairs.T
        error = one.sample.clusters.positions[columns] - one.sample.centres[rows]
        weighted = np.linalg.solve(covariances[columns], error[:, :, None])[:, :, 0]
        total += float(np.sum(error * weighted))
        count += len(error)
    if count == 0:
        return Nees(*[float("nan")] * 3)
    return Nees(total / count, *mean_chi_square_interval(count))


def mean_chi_square_interval(count: int, probability: float = 0.95) -> tuple[float, float]:
    """Where the mean of `count` chi-squares of 2 degrees of freedom lies; both tails alike."""
    tail = (1 - probability) / 2
    low, high = chi2.ppf((tail, 1 - tail), _DIMENSIONS * count) / count
    return float(low), float(high)


SETTLED_US = 200_000  #: events before it do not count


class Confirmation(NamedTuple):
    """How soon objects get their first id."""

    time_to_confirm_ms: float  #: median over the objects that got one; NaN if none did
    confirmed: float  #: share of the objects that got one


def event_accuracy(trace: Trace, matches: Sequence[Matched]) -> float:
    """Share of the object events after 200 ms that were returned with the object's matched id.

    That is the id that the object was matched to in the newest sample not after the event, or, if
    it was missed there, before. NaN where the tracker returns no ids.
    """
    if trace.ids is None:
        return float("nan")
    correct = total = 0
    bounds = np.searchsorted(trace.t_us, [one.sample.t_us for one in matches]).tolist()
    for one, (begin, end) in zip(matches, pairwise([*bounds, trace.t_us.size]), strict=True):
        if one.sample.t_us < SETTLED_US:
            continue
        labels, ids = trace.labels[begin:end], trace.ids[begin:end]
        for label in np.unique(labels[labels != NOISE]).tolist():
            of_object = labels == label
            total += int(of_object.sum())
            if label in one.memory:
                correct += int(np.sum(ids[of_object] == one.memory[label]))
    return ratio(correct, total)


def noise_leak(trace: Trace) -> float:
    """Share of the noise events after 200 ms that were returned with any id; NaN without ids."""
    if trace.ids is None:
        return float("nan")
    noise = (trace.labels == NOISE) & (trace.t_us >= SETTLED_US)
    return ratio(int(np.sum(trace.ids[noise] >= 0)), int(noise.sum()))


def time_to_confirm(trace: Trace, matches: Sequence[Matched]) -> Confirmation:
    """Time from the first event of an object to the first that is returned with an id of its own.

    Ids of its own are those that it was ever matched to: an event that a neighbour took does not
    count.
    """
    if trace.ids is None:
        return Confirmation(float("nan"), float("nan"))
    own: defaultdict[int, set[int]] = defaultdict(set)
    for one in matches:
        for label, id in one.memory.items():
            own[label].add(id)
    waited_us = [
        _first_us(trace, label, own[label]) - first_us for label, first_us in trace.first_us.items()
    ]
    found = [us for us in waited_us if np.isfinite(us)]
    return Confirmation(
        float(np.median(found)) * 1e-3 if found else float("nan"),
        ratio(len(found), len(trace.first_us)),
    )


def _first_us(trace: Trace, label: int, ids: set[int]) -> float:
    assert trace.ids is not None
    hits = np.flatnonzero((trace.labels == label) & np.isin(trace.ids, list(ids)))
    return float(trace.t_us[hits[0]]) if hits.size else float("inf")
