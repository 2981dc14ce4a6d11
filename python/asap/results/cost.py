"""What the algorithm of a run costs, as far as the run tells; and the bound that this rules out."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from asap import _checks

Floats = NDArray[np.float64]

BOUND_KEPT = 1.01  # times the bound
MIN_BOUND = 2.5  # fixed costs
RATE_SHARE = 0.9  # of what a cost can do within the bound: the rate bound that keeps a queue short

_FITTED = 8192  # packages; of more, so many are drawn at random
_OF_NORMAL = 1.4826  # standard deviation over median absolute deviation
_OF_MEDIAN = 1.25  # standard error of a median over that of a mean
_CLAIMED = 3.0  # standard errors
_PLACE = 1e-6  # precision of the fixed share, as the argument of a logistic function
_SURE = 0.05  # standard error of the fixed share at which alpha and beta are told apart


@dataclass(frozen=True)
class Cost:
    """A package of n events takes ``(alpha_us + beta_ns n / 1000) X`` us.

    X is lognormal of mean 1 with sigma = `noise`, as in `LinearCost`. `one_size` is None unless the
    packages were too few, or too alike in size, to tell alpha from beta: then it is their typical
    size, and the cost is known for packages like them. `beta_error_ns` is three standard errors of
    the slope; where they exceed it, none is claimed: `beta_ns` is 0, and the error what an event
    costs at most.
    """

    alpha_us: float
    beta_ns: float
    noise: float = 0.0
    one_size: int | None = None
    beta_error_ns: float = 0.0

    def throughput_hz(self, bound_us: float) -> float:
        """Largest event rate whose latency stays below the bound at full load.

        a* = (1 - 2 alpha / L) / beta: notebooks/theory.md, T6.
        """
        bound_us = _checks.number("bound_us", bound_us, 0, sys.float_info.max, "give 0 us or more")
        share = max(0.0, 1 - 2 * self.alpha_us / bound_us) if bound_us > 0 else 0.0
        if self.beta_ns > 0:
            return share / self.beta_ns * 1e9
        return np.inf if share > 0 else 0.0

    @property
    def dearest(self) -> Cost:
        """The same with the largest slope that the error allows."""
        return replace(self, beta_ns=self.beta_ns + self.beta_error_ns)

    @property
    def least_bound_us(self) -> float:
        """Shortest latency bound that can be promised: 2.5 fixed costs, or two single events.

        An event that just misses a package waits for its end, and one of 1.25 fixed costs is the
        shortest that is worth its while (theory, section 6). Where the fixed cost is not known, two
        events at their share of a package.
        """
        if self.one_size is not None:
            return 2 * (self.alpha_us / self.one_size + self.beta_ns / 1e3)
        return max(MIN_BOUND * self.alpha_us, 2 * (self.alpha_us + self.beta_ns / 1e3))


def fit(packages: NDArray[np.void], learned: Cost | None, execution: str) -> Cost:
    """Fit the cost that explains the packages of a run; no packages cost nothing.

    `learned` is what the scheme has learned, `execution` how the algorithm took packages.

    Notes
    -----
    The line has the least mean absolute deviation of log c from log(alpha + beta n), alpha >= 0 and
    beta >= 0. It is fitted twice, the second time without the packages more than three sigma above:
    a pause meets long packages more often and would pass for a slope. The noise is the median
    absolute deviation, as that of a normal distribution; a mean is exp(noise^2 / 2) medians.

    A scheme with a budget ends an anytime package by the clock: its size follows from its cost and
    tells nothing of the line. There the fixed share is that of the packages that were not thinned
    or, where these are few, the one that the scheme has learned from the parts of its packages.
    """
    rows = packages
    if rows.size > _FITTED:
        rows = rows[np.random.default_rng(0).integers(0, rows.size, _FITTED)]
    rows = rows[(rows["size"] > 0) & (rows["processing_us"] > 0)]
    if rows.size == 0:
        return Cost(0.0, 0.0)
    for _ in range(2):
        typical = float(np.exp(np.log(rows["size"]).mean()))
        size, log_cost = rows["size"] / typical, np.log(rows["processing_us"])
        whole = rows["size"] == rows["offered"]
        share, error = _fixed_share(
            None if execution == "whole" else learned, size, log_cost, whole, typical
        )
        off = log_cost - np.log(share + (1 - share) * size)
        noise, middle = _noise(off), float(np.median(off))
        rows = rows[off - middle <= 3 * noise + 1e-6]
    mean_us = float(np.exp(middle + min(noise, 1.0) ** 2 / 2))
    one_size = None if error <= _SURE else round(typical)
    mean_error = _OF_MEDIAN * noise / off.size**0.5
    error = float(np.hypot(min(_CLAIMED * error, share), _CLAIMED * (1 - share) * mean_error))
    error *= error > _PLACE
    is_flat = share > 0 and 1 - share < error
    slope, error = (0.0, 1 - share + error) if is_flat else (1 - share, error)
    per_event_ns = mean_us / typical * 1e3
    return Cost(
        alpha_us=_rounded((1.0 if is_flat else share) * mean_us),
        beta_ns=_rounded(slope * per_event_ns),
        noise=_rounded(noise),
        one_size=one_size,
        beta_error_ns=_rounded(error * per_event_ns),
    )


def _rounded(value: float) -> float:
    """Keep the digits that the search for the share finds; the others differ between machines."""
    return float(f"{value:.7g}")


def _fixed_share(
    learned: Cost | None, size: Floats, log_cost: Floats, whole: NDArray[np.bool_], typical: float
) -> tuple[float, float]:
    """Find the share of alpha in the cost of a package of the typical size, and its error."""
    if learned is None:
        return _fitted_share(size, log_cost)
    if 2 * np.count_nonzero(whole) >= whole.size:
        return _fitted_share(size[whole], log_cost[whole])
    events_us = learned.beta_ns / 1e3 * typical
    share = learned.alpha_us / max(learned.alpha_us + events_us, sys.float_info.min)
    return share, _SURE * (1 - share)


def _fitted_share(size: Floats, log_cost: Floats) -> tuple[float, float]:
    """Find the share whose line has the least deviation, and its standard error."""

    def off(share: float) -> Floats:
        return log_cost - np.log(share + (1 - share) * size)

    def deviation(share: float) -> float:
        found = off(share)
        return float(np.abs(found - np.median(found)).mean())

    def at(place: float) -> float:
        return float(1 / (1 + np.exp(-place)))

    grid, golden = np.arange(-18.0, 20.0, 2.0), (5**0.5 - 1) / 2
    centre = float(min(grid, key=lambda place: deviation(at(place))))
    low, high = centre - 2, centre + 2
    while high - low > _PLACE:
        left, right = high - golden * (high - low), low + golden * (high - low)
        low, high = (low, right) if deviation(at(left)) <= deviation(at(right)) else (left, high)
    # One coefficient alone, where that explains the packages as well.
    share = min(0.0, 1.0, at((low + high) / 2), key=lambda share: round(deviation(share), 9))
    tilt = (1 - size) / (share + (1 - share) * size)
    spread = float(tilt.std()) * size.size**0.5 if size.size > 2 else 0.0
    return share, _OF_MEDIAN * _noise(off(share)) / spread if spread > 0 else np.inf


def _noise(off: Floats) -> float:
    """Return the sigma of deviations from a line, which passes through two packages."""
    away = np.sort(np.abs(off - np.median(off)))[2:]
    return _OF_NORMAL * float(np.median(away)) if away.size else 0.0


def keeps(latency_us: float, bound_us: float) -> bool:
    """Whether a latency is within the bound, but for one stratum of a package."""
    return latency_us <= BOUND_KEPT * bound_us


def bound_needed_us(cost: Cost, bound_us: float, largest_us: float) -> float | None:
    """Return the shortest bound that the cost allows, us, where the bound of the run was shorter.

    None where the largest latency kept the bound, or missed it for another reason.
    """
    is_short = cost.least_bound_us > bound_us and not keeps(largest_us, bound_us)
    return cost.least_bound_us if is_short else None
