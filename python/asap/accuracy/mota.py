"""MOTA, recall, precision, id switches, and the errors of position and velocity."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from asap.accuracy.matching import Matched


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

    Parameters
    ----------
    matches : sequence of Matched
        As `match` returns them.

    Notes
    -----
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
