"""Scores of a tracker from its matches: MOTA, IDF1, HOTA, NEES, and the labels of events."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from asap_laboratory.scoring.matching import Matched, assign, distances, gates
from asap_laboratory.scoring.scene import NOISE
from asap_laboratory.scoring.trace import Trace


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
    """Score detection and association of active objects and counted clusters; NaN without any.

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
    """Where the mean of `count` independent chi-squares of 2 degrees of freedom lies; tails alike.

    Exact: the sum exceeds x where a Poisson variable of mean x / 2 is less than `count`.
    """
    tail = (1 - probability) / 2
    log_factorial = np.concatenate([[0.0], np.cumsum(np.log(np.arange(1, count)))])
    numbers = np.arange(count)

    def exceeds(mean: float) -> float:
        log_rate = math.log(mean * count / _DIMENSIONS)
        logs = numbers * log_rate - mean * count / _DIMENSIONS - log_factorial
        return float(np.exp(np.logaddexp.reduce(logs)))

    return _root(exceeds, 1 - tail), _root(exceeds, tail)


def _root(falling: Callable[[float], float], value: float) -> float:
    low, high = 1e-9, 64.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if falling(middle) > value else (low, middle)
    return (low + high) / 2


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
