"""NEES: whether the errors of the positions are as large as the tracker says that they are."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from asap.accuracy.matching import Matched

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

    Parameters
    ----------
    matches : sequence of Matched
        With covariances in their snapshots.

    Notes
    -----
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
    """Where the mean of `count` independent chi-squares of 2 degrees of freedom lies.

    Parameters
    ----------
    count : int
        At least 1.
    probability : float
        Of the interval, its tails alike.

    Returns
    -------
    low, high : float

    Notes
    -----
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
