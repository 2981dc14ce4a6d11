"""Which events a filter lets pass, found from what it returns, so that labels can follow."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

_COORDINATE_BITS = 16


def passed(returned: Any, events: NDArray[np.void]) -> NDArray[np.int64]:
    """Find the indices of the events that a filter let pass.

    Parameters
    ----------
    returned : ndarray
        What its ``process(events)`` gave: the events that pass, in their order and unchanged, or a
        bool for each event (a corner detector in front of a tracker).
    events : ndarray, shape (n,), EVENT_DTYPE
        That went in; in time order, of less than 1000 s.

    Returns
    -------
    ndarray of int64, shape (m,)
        Ascending. Of several events that are alike in every field, the first ones pass.

    Raises
    ------
    ValueError
        Events came out that did not go in, or in another order.
    """
    found = np.asarray(returned)
    if found.dtype == np.bool_ and found.shape == events.shape:
        return np.flatnonzero(found)
    if found.dtype != events.dtype or found.ndim != 1:
        raise ValueError(
            f"before.process returned {found.dtype} of shape {found.shape}: must be the events "
            "that pass, or a bool for each event"
        )
    if found.size == 0:
        return np.empty(0, np.int64)
    keys, order = _sorted_keys(events, events)
    wanted, back = _sorted_keys(found, events)
    # The k-th of the events that came out alike is the k-th of those that went in.
    place = np.searchsorted(keys, wanted)
    place += np.arange(wanted.size) - np.searchsorted(wanted, wanted)
    if place.max() >= keys.size or not np.array_equal(keys[place], wanted):
        raise ValueError("before.process returned events that were not handed to it")
    indices = np.empty(found.size, np.int64)
    indices[back] = order[place]
    if np.any(np.diff(indices) < 0):
        raise ValueError("before.process returned the events in another order")
    return indices


def _sorted_keys(
    events: NDArray[np.void], among: NDArray[np.void]
) -> tuple[NDArray[np.int64], NDArray[np.intp]]:
    """Every field of an event in one number, in ascending order, and where each stood."""
    since = events["t"] - among["t"][0]
    key = since << 2 * _COORDINATE_BITS + 1
    key |= events["x"].astype(np.int64) << _COORDINATE_BITS + 1
    key |= events["y"].astype(np.int64) << 1
    key |= events["p"].astype(np.int64) & 1
    order = np.argsort(key, kind="stable")
    return key[order], order
