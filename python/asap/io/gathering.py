"""One array of events that come in chunks."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from asap.events import EVENT_DTYPE, Events

_RECORD = np.dtype(f"V{EVENT_DTYPE.itemsize}")


def gathered(chunks: Iterable[Events], expected: int) -> Events:
    """One array of all chunks, made for as many events as are expected; it grows if need be."""
    events: Events = np.empty(expected, EVENT_DTYPE)
    count = 0
    for chunk in chunks:
        if count + len(chunk) > len(events):
            larger = np.empty(max(2 * len(events), count + len(chunk)), EVENT_DTYPE)
            _copy(larger[:count], events[:count])
            events = larger
        _copy(events[count : count + len(chunk)], chunk)
        count += len(chunk)
    if count < len(events):
        events.resize(count, refcheck=False)  # gives the rest back, in place
    return events


def _copy(to: Events, source: Events) -> None:
    """Copy memory as it is: NumPy copies structured arrays field by field, six times slower."""
    to.view(_RECORD)[:] = source.view(_RECORD)
