"""Order of events in time: late ones sorted into their place, a window of time, and slices."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from asap.events import EVENT_DTYPE, Events

NEW_EPOCH_US = 1_000_000  # so far back is another clock
_MAX_FAR = 1024  # events in a row that are so far back: the clock was set back
_RECORD = np.dtype(f"V{EVENT_DTYPE.itemsize}")  # NumPy copies fields one by one, six times slower


class Slice(NamedTuple):
    """The `events` from `begin_us` until before `end_us`."""

    begin_us: int
    end_us: int
    events: Events


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


def by_time(
    chunks: Iterator[Events], width_us: float, begin_of: Callable[[int], int]
) -> Iterator[Slice]:
    """Cut chunks in order into windows of time; the first begins at `begin_of` the first stamp."""
    first_us, number, held = None, 0, list[Events]()
    for chunk in chunks:
        t = np.ascontiguousarray(chunk["t"])
        first_us = begin_of(int(t[0])) if first_us is None else first_us
        done, last_us = 0, int(t[-1])
        while last_us >= (end_us := first_us + round((number + 1) * width_us)):
            stop = int(t.searchsorted(end_us))
            yield Slice(
                first_us + round(number * width_us), end_us, _joined(held, chunk[done:stop])
            )
            done, number, held = stop, number + 1, []
        held.append(chunk[done:])
    if first_us is not None:
        begin_us, end_us = (first_us + round(k * width_us) for k in (number, number + 1))
        yield Slice(begin_us, end_us, _joined(held))


def by_count(chunks: Iterator[Events], count: int) -> Iterator[Slice]:
    """Cut chunks in order into slices of `count` events; the last one may have fewer."""
    held, waits = list[Events](), 0
    for chunk in chunks:
        done = 0
        while waits + len(chunk) - done >= count:
            stop = done + count - waits
            yield _around(_joined(held, chunk[done:stop]))
            done, held, waits = stop, [], 0
        held.append(chunk[done:])
        waits += len(chunk) - done
    if waits:
        yield _around(_joined(held))


def _around(events: Events) -> Slice:
    return Slice(int(events["t"][0]), int(events["t"][-1]) + 1, events)


def _joined(held: list[Events], *more: Events) -> Events:
    parts = [part for part in (*held, *more) if len(part)]
    if len(parts) == 1:
        return parts[0]
    joined: Events = np.concatenate([np.empty(0, _RECORD), *(part.view(_RECORD) for part in parts)])
    return joined.view(EVENT_DTYPE)
