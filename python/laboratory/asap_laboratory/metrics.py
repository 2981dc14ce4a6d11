"""Metrics that a row per package cannot give: gaps, how long a disturbance lasts, load.

Plain NumPy on ``run.slots`` (one row per 1 ms slot of the stamps that holds an event: slot,
received, delivered, latency_max_us) and ``run.packages``. Source: notebooks/theory.md,
section 10.
"""

from __future__ import annotations

import sys
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from asap import _checks, _core

_LATE = 1.1  # of the bound
_KEPT = 0.98
_LAST_MS = 4  # of a phase: too late to count as settled


def gap_ms(slots: npt.NDArray[np.void], ignore_last: int = 60) -> int:
    """Longest time without any result although events came in, in 1 ms slots.

    `Run.gap_us` is the exact measure; this one leaves out what is shorter than a slot.

    Parameters
    ----------
    slots : ndarray, shape (n,), SLOT_DTYPE
        In time order, as ``run.slots``.
    ignore_last : int
        The last so many ms of the stamps do not count: their events may be on their way.

    Returns
    -------
    int
        The longest run of 1 ms slots with input but nothing delivered. A slot without events ends
        a run.
    """
    _check_slots(slots)
    _checks.whole("ignore_last", ignore_last, 0, 2**62, "give 0 ms or more")
    if slots.size == 0:
        return 0
    counted = slots["slot"] <= slots["slot"][-1] - ignore_last
    silent = slots["slot"][counted & (slots["delivered"] == 0)]
    begins = np.flatnonzero(np.diff(silent, prepend=silent[:1] - 2) != 1)
    return int(np.diff(begins, append=silent.size).max(initial=0))


def settle_ms(
    slots: npt.NDArray[np.void], steps_ms: npt.ArrayLike, phase_ms: int, bound_us: float
) -> float:
    """Mean time until the latency bound holds again after steps up of the event rate.

    Parameters
    ----------
    slots : ndarray, shape (n,), SLOT_DTYPE
        In time order, as ``run.slots``.
    steps_ms : array_like of int, shape (steps,)
        When the rate steps up, ms of the stamps.
    phase_ms : int
        How long it stays, ms.
    bound_us : float
        The latency bound L, us.

    Returns
    -------
    float
        ms to the end of the last slot of the phase that is later than 1.1 L, mean over the steps.
        phase_ms - 4 (496 of 500): never settled. 0 without steps.
    """
    _check_phases(slots, phase_ms, bound_us)
    late = _is_late(slots, bound_us)
    return _mean_disturbance_ms(slots["slot"][late], steps_ms, phase_ms)


def recovery_ms(
    slots: npt.NDArray[np.void], steps_ms: npt.ArrayLike, phase_ms: int, bound_us: float
) -> float:
    """Mean time until nothing is late or lost any more after steps down of the event rate.

    Parameters
    ----------
    slots, steps_ms, phase_ms, bound_us
        As in `settle_ms`; the steps go down.

    Returns
    -------
    float
        ms to the end of the last slot of the phase that is later than 1.1 L or keeps less than
        98 %, mean over the steps. phase_ms - 4: never recovered. 0 without steps.
    """
    _check_phases(slots, phase_ms, bound_us)
    lossy = slots["delivered"] < _KEPT * slots["received"]
    return _mean_disturbance_ms(
        slots["slot"][_is_late(slots, bound_us) | lossy], steps_ms, phase_ms
    )


class Load(NamedTuple):
    """How busy the packages keep the algorithm; H = processing time, D = since the last start."""

    mean: float  #: of H / D
    within: float  #: share of the packages with H <= D


def load(packages: npt.NDArray[np.void]) -> Load:
    """Relate the processing time of packages to the interval between them.

    Parameters
    ----------
    packages : ndarray, shape (n,), PACKAGE_DTYPE
        As ``run.packages``, of a run at the speed of the recording.

    Returns
    -------
    Load
        Over all packages but the first, which has no interval; (0, 1) where there is no other.
    """
    remedy = "give run.packages"
    _require_rows("packages", packages, _core.PACKAGE_DTYPE, remedy)
    if packages.size < 2:
        return Load(0.0, 1.0)
    interval_us = np.maximum(np.diff(packages["start_us"]), 1e-3)
    ratio = packages["processing_us"][1:] / interval_us
    return Load(float(ratio.mean()), float(np.mean(ratio <= 1.0)))


def _check_slots(slots: npt.NDArray[np.void]) -> None:
    _require_rows("slots", slots, _core.SLOT_DTYPE, "give run.slots of a run in virtual time")


def _check_phases(slots: npt.NDArray[np.void], phase_ms: int, bound_us: float) -> None:
    _check_slots(slots)
    _checks.whole("phase_ms", phase_ms, _LAST_MS, 2**31, f"give at least {_LAST_MS} ms")
    _checks.number("bound_us", bound_us, 0, sys.float_info.max, "give 0 us or more")


def _is_late(slots: npt.NDArray[np.void], bound_us: float) -> npt.NDArray[Any]:
    return np.asarray(slots["latency_max_us"] > _LATE * float(bound_us))


def _mean_disturbance_ms(
    disturbed: npt.NDArray[np.int64], steps_ms: npt.ArrayLike, phase_ms: int
) -> float:
    given = _checks.column("steps_ms", steps_ms)
    is_whole = bool(np.all((np.abs(given) < 2**53) & (given == np.floor(given))))
    _checks.require(is_whole, "steps_ms", steps_ms, "give whole ms")
    steps = given.astype(np.int64)
    if steps.size == 0:
        return 0.0
    last = np.searchsorted(disturbed, steps + phase_ms) - 1
    end = np.append(disturbed, -(2**60))[last] + 1  # last = -1: none at all
    return float(np.clip(end - steps, 0, phase_ms - _LAST_MS).mean())


def _require_rows(field: str, value: Any, dtype: np.dtype[Any], remedy: str) -> None:
    """Refuse what is no one-dimensional array with the fields of a table."""
    _checks.unmasked(field, value)
    found = getattr(getattr(value, "dtype", None), "names", None) or ()
    if np.ndim(value) != 1 or not set(dtype.names or ()) <= set(found):
        raise TypeError(_checks.named(field, value, remedy))
