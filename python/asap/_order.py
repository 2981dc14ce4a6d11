"""Order of events in time: late ones sorted into their place, and a window of time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from asap.events import EVENT_DTYPE, Events

NEW_EPOCH_US = 1_000_000  # so far back is another clock
_MAX_FAR = 1024  # events in a row that are so far back: the clock was set back


def sorted_within(
    chunks: Iterator[Events], tolerance_us: int, count: Callable[[int], None]
) -> Iterator[Events]:
    """Sort events that come up to `tolerance_us` late, stably; tell `count` how many came late.

    What comes later than that stays in its place, for the validator. Events wait until none that
    is older can come: memory holds those within the tolerance.
    """
    held: Events = np.empty(0, EVENT_DTYPE)
    newest: int | None = None
    for chunk in chunks:
        waits = len(held)
        block: Events = np.concatenate([held, chunk])
        t = block["t"]
        before = np.maximum.accumulate(np.append(t[:1] if newest is None else newest, t))[:-1]
        before[:waits] = t[:waits]  # they are in order
        late_us = before - t
        far = late_us > tolerance_us
        if len(chunk) > _MAX_FAR and bool((late_us[-_MAX_FAR:] >= NEW_EPOCH_US).all()):
            yield from (part for part in (held, chunk) if len(part))
            held, newest = block[:0], None
            continue
        count(int(np.count_nonzero((late_us > 0) & ~far)))
        key = np.where(far, before, t)
        newest = int(max(before[-1], t[-1])) if len(t) else newest
        order = np.argsort(key, kind="stable")
        block, key = block[order], key[order]
        ready = int(np.searchsorted(key, (newest or 0) - tolerance_us, side="left"))
        held = block[ready:]
        if ready:
            yield block[:ready]
    if len(held):
        yield held


def within(chunks: Iterator[Events], begin_us: int, end_us: int) -> Iterator[Events]:
    """Yield the events from `begin_us` up to `end_us` of chunks in order; read no further."""
    for chunk in chunks:
        t: Any = chunk["t"]
        first = int(np.searchsorted(t, begin_us))
        stop = int(np.searchsorted(t, end_us))
        if first < stop:
            yield chunk[first:stop]
        if stop < len(t):
            return
