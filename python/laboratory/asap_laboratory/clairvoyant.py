"""EC(L), the exact clairvoyant: what a scheduler that knows every arrival can do at best."""

from __future__ import annotations

from typing import Any

from asap import _core
from asap.io.source import CheckedStream
from asap.synthetic import joined
from asap_laboratory import _native


def exact_oracle(source: Any, *, cost: _core.LinearCost, latency_ms: float) -> int:
    """Count the events that the best scheduler of whole packages finishes within a latency bound.

    Parameters
    ----------
    source : path, Recording, array or iterable of arrays
        Read once.
    cost : LinearCost
        The simulated algorithm. Its mean counts, without drift and outages.
    latency_ms : float
        The latency bound, ms. An event that ends at the bound is in time.

    Returns
    -------
    int
        Events. Unlike the fluid bound of `asap.oracle` it is reached.

    Raises
    ------
    ValueError
        The cost drifts or has outages, or the events are too many; then with the number that fits.

    Notes
    -----
    notebooks/theory.md, section 9. 10^5 events at 300 per bound take seconds; the work grows with
    the events and with the square of the events per bound.
    """
    events = joined(list(CheckedStream(source)))
    return _native.exact_clairvoyant(events, cost, _core.checked_latency_ms(latency_ms) * 1e3)
