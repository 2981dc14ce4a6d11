"""What check measures, block by block in flat memory: the validator's refusals, and meters.

Every meter sees the good events in time order, in blocks that may cut a stamp, and tells the same
however they are cut.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from asap import _core
from asap.analysis import PeakCount
from asap.events import EVENT_DTYPE, Events
from asap.events.order import NEW_EPOCH_US
from asap.events.values import HEAD
from asap.inspection.result import BINS_FROM_US

Integers = npt.NDArray[np.int64]

_LAST_US = 1 << 52
_MAX_STAMP_US = _LAST_US - (1 << 50)  # beyond it the core refuses a timestamp

GAP_US = 100_000  # so long without an event is a gap

MAX_SIDE = 4096  # px of the map, which bounds its memory
HOT_EVENTS = 100  # a hot pixel has at least so many events,
HOT_SHARE = 1e-3  # at least this share of all,
HOT_FACTOR = 5  # and so many times those of the second busiest pixel around it

ALONE_US = 20_000  # an event without one at a neighbouring pixel for so long is alone

PIXEL_DTYPE = np.dtype([("x", "<u2"), ("y", "<u2"), ("events", "<i8")])

_REACH = 2  # px around a pixel that are its neighbours


@dataclass
class Tally:
    """A count, and the first occurrence: number of the event in the source, its own stamp in us."""

    count: int = 0
    event: int | None = None
    t_us: int | None = None

    def add(self, numbers: Integers, stamps: Integers) -> None:
        """Count these events, in the order of the source."""
        if self.event is None and numbers.size:
            self.event, self.t_us = int(numbers[0]), int(stamps[0])
        self.count += int(numbers.size)


class Passed(NamedTuple):
    """The good events of a block."""

    events: Events  #: timestamps never go back: after a clock reset time continues; p is 0 or 1
    numbers: Integers  #: number of each in the source
    stamps: Integers  #: as the source has them


class BadEvents:
    """What the validator would refuse, event by event: where it was, and how far it was off.

    The core's own validator decides about stamps, so that the counts are those of a run. It sees a
    copy of the events in whose x each has its place in the block: what comes out tells which ones
    passed. A file is looked ahead in for stray stamps, as `read` does.
    """

    def __init__(self, width: int | None, height: int | None, *, is_file: bool) -> None:
        # With one side alone or none, what is unknown is not checked.
        self._validator = _core.Validator()
        self._width, self._height = width or 1 << 16, height or 1 << 16
        self._is_file = is_file
        self.seen = 0
        self._offset_us = 0
        self.unreadable = Tally()
        self.outside = Tally()
        self.back_steps = Tally()
        self.clock_resets = Tally()
        self.odd_polarity = Tally()
        self.largest_back_step_us = 0
        self.largest_reset_us = 0
        self.late = 0  # events that come after one with a later timestamp, of the same epoch
        self.latest_us = 0  # by at most so much
        self._newest_us: int | None = None  # of all timestamps so far, the clock as it is now
        self._last_us = 0

    def check(self, block: Events) -> Passed:
        """Pass a block of at most 65536 events."""
        t: Integers = block["t"]
        numbers: Integers = self.seen + np.arange(len(block))
        self.seen += len(block)
        unreadable = (t > _MAX_STAMP_US) | (t < -_MAX_STAMP_US)
        outside = ~unreadable & ((block["x"] >= self._width) | (block["y"] >= self._height))
        at = np.flatnonzero(~(unreadable | outside))

        self._measure_disorder(t[at])
        last_us, offset_us = self._validator.last_us, self._offset_us
        carrier: Events = np.zeros(len(at), EVENT_DTYPE)
        carrier["t"] = t[at]
        carrier["x"] = np.arange(len(at))
        if self._is_file:
            passed, _ = self._validator.check_recorded(carrier)
        else:
            passed = self._validator.check(carrier)
        kept = at[passed["x"]]
        # The state that each event met: what passed before it.
        reached = np.concatenate(([last_us], passed["t"]))
        offsets = np.concatenate(([offset_us], passed["t"] - t[kept]))
        self._offset_us = int(offsets[-1])

        refused = np.setdiff1d(at, kept, assume_unique=True)
        before = np.searchsorted(kept, refused)
        stamps_us = t[refused] + offsets[before]
        steps_us = reached[before] - stamps_us
        back = stamps_us <= _LAST_US  # else continued beyond the last timestamp that there is
        unreadable[refused[~back]] = True
        self.largest_back_step_us = max(self.largest_back_step_us, _largest(steps_us))
        resets = np.flatnonzero(np.diff(offsets))
        falls_us = reached[resets] - offsets[resets] - t[kept[resets]]
        self.largest_reset_us = max(self.largest_reset_us, _largest(falls_us))

        p = block["p"][kept]
        for tally, found in (
            (self.unreadable, np.flatnonzero(unreadable)),
            (self.outside, np.flatnonzero(outside)),
            (self.back_steps, refused[back]),
            (self.clock_resets, kept[resets]),
            (self.odd_polarity, kept[(p < 0) | (p > 1)]),
        ):
            tally.add(numbers[found], t[found])

        good: Events = block[kept]
        good["t"] = passed["t"]
        good["p"] = p > 0
        return Passed(good, numbers[kept], t[kept])

    def _measure_disorder(self, t: Integers) -> None:
        """See how far the stamps would have to move in a sort; a clock that is reset ends it."""
        if not t.size:
            return
        if self._newest_us is None or t[0] - self._last_us <= -NEW_EPOCH_US:
            self._newest_us = int(t[0])
        for epoch in np.split(t, np.flatnonzero(np.diff(t) <= -NEW_EPOCH_US) + 1):
            newest_us = np.maximum.accumulate(np.append(self._newest_us, epoch))[1:]
            if epoch is not t and epoch[0] <= newest_us[0] - NEW_EPOCH_US:
                newest_us = np.maximum.accumulate(epoch)
            late_us = newest_us - epoch
            late_us = late_us[(late_us > 0) & (late_us < NEW_EPOCH_US)]
            self.late += late_us.size
            self.latest_us = max(self.latest_us, _largest(late_us))
            self._newest_us = int(newest_us[-1])
        self._last_us = int(t[-1])


def _largest(values: npt.NDArray[np.int64]) -> int:
    return int(values.max(initial=0))


class Steps:
    """Times between events: how many by octaves, and the gaps, told by the event that ends one."""

    def __init__(self) -> None:
        self.counts: Integers = np.zeros(BINS_FROM_US.size, np.int64)
        self.gaps = Tally()
        self.longest_us = 0
        self._last_us: int | None = None

    def add(self, passed: Passed) -> None:
        """See a block, which is not empty; the first event of all has none before it."""
        t: Integers = passed.events["t"]
        steps_us = np.diff(t, prepend=t[0] if self._last_us is None else self._last_us)
        counted_us = steps_us[1:] if self._last_us is None else steps_us
        bins = np.searchsorted(BINS_FROM_US, counted_us, side="right") - 1
        self.counts += np.bincount(bins, minlength=self.counts.size)
        self.longest_us = max(self.longest_us, int(steps_us.max()))
        ends = np.flatnonzero(steps_us >= GAP_US)
        self.gaps.add(passed.numbers[ends], passed.stamps[ends])
        self._last_us = int(t[-1])


class Alone:
    """Events without an earlier one at a neighbouring pixel; its own pixel does not count."""

    def __init__(self, width: int, height: int) -> None:
        self.count = 0
        self._pixels = width * height
        self._filter = _core.BackgroundActivityFilter(width, height, window_us=ALONE_US)

    def add(self, passed: Passed) -> None:
        """See a block."""
        self.count += len(passed.events) - len(self._filter.process(passed.events))

    def at_random(self, events: int, duration_us: int) -> float:
        """Share of the events that would be alone if they came anywhere at any time."""
        per_pixel = events * ALONE_US / max(duration_us, ALONE_US) / self._pixels
        return float(np.exp(-8 * per_pixel))


class PixelMap:
    """Counts of shape (height, width); without a sensor size it grows as far as events go."""

    def __init__(self, width: int | None, height: int | None) -> None:
        self.counts: Integers = np.zeros(
            (min(height or 1, MAX_SIDE), min(width or 1, MAX_SIDE)), np.int64
        )
        self.events = 0
        self.beyond = 0  # events that the map is too small for

    def add(self, passed: Passed) -> None:
        """See a block."""
        events = passed.events
        x, y = events["x"].astype(np.int64), events["y"].astype(np.int64)
        self.events += len(events)
        inside = (x < MAX_SIDE) & (y < MAX_SIDE)
        if not inside.all():
            x, y = x[inside], y[inside]
            self.beyond += int(len(events) - len(x))
        rows, columns = self.counts.shape
        missing = (
            max(0, int(y.max(initial=0)) + 1 - rows),
            max(0, int(x.max(initial=0)) + 1 - columns),
        )
        if any(missing):
            self.counts = np.pad(self.counts, [(0, missing[0]), (0, missing[1])])
        np.add.at(self.counts, (y, x), 1)

    def busiest(self, count: int = 10) -> npt.NDArray[np.void]:
        """Return the pixels with most events, the busiest first; ties in reading order."""
        flat = self.counts.ravel()
        least = np.partition(flat, -count)[-count] if flat.size > count else 0
        at = np.flatnonzero(flat >= max(int(least), 1))
        return self._pixels(at)[:count]

    def hot(self) -> npt.NDArray[np.void]:
        """Return the hot pixels, the busiest first.

        A hot pixel has at least `HOT_EVENTS` events, `HOT_SHARE` of all, and `HOT_FACTOR` times as
        many as the second busiest of the 24 pixels around it. Not the busiest: hot pixels come in
        pairs. A thin track passes at least two of them, even where it ends, so it is not hot.
        """
        limit = max(HOT_EVENTS, HOT_SHARE * self.events)
        candidates = np.flatnonzero(self.counts >= limit)
        if candidates.size == 0:
            return self._pixels(candidates)
        padded = np.pad(self.counts, _REACH)
        y, x = np.divmod(candidates, self.counts.shape[1])
        side = range(2 * _REACH + 1)
        around = np.array(
            [padded[y + dy, x + dx] for dy in side for dx in side if (dy, dx) != (_REACH, _REACH)]
        )
        second = np.sort(around, axis=0)[-2]
        hot = self.counts[y, x] >= HOT_FACTOR * np.maximum(second, 1)
        return self._pixels(candidates[hot])

    def _pixels(self, at: npt.NDArray[np.intp]) -> npt.NDArray[np.void]:
        pixels = np.zeros(at.size, PIXEL_DTYPE)
        pixels["y"], pixels["x"] = np.divmod(at, self.counts.shape[1])
        pixels["events"] = self.counts.ravel()[at]
        return pixels[np.argsort(-pixels["events"], kind="stable")]


class Meters:
    """All that looks at the good events of a source, and what only needs counting."""

    def __init__(self, width: int | None, height: int | None) -> None:
        self.steps = Steps()
        self.pixels = PixelMap(width, height)
        sides = (width or 0, height or 0)
        self.alone = Alone(*sides) if 0 < min(sides) <= max(sides) <= MAX_SIDE else None
        self._windows = {ms: PeakCount(ms * 1000) for ms in (1, 10, 100)}
        self.events = self.on = 0
        self.first_stamp_us: int | None = None
        self.head: Integers = np.empty(0, np.int64)
        self._begin_us = self._end_us = 0

    def add(self, passed: Passed) -> None:
        """See a block, which is not empty."""
        t: Integers = passed.events["t"]
        if self.first_stamp_us is None:
            self.first_stamp_us, self._begin_us = int(passed.stamps[0]), int(t[0])
        self.head = np.concatenate([self.head, t[: HEAD - len(self.head)]])
        self._end_us = int(t[-1])
        self.events += len(t)
        self.on += int(np.count_nonzero(passed.events["p"]))
        self.steps.add(passed)
        self.pixels.add(passed)
        if self.alone is not None:
            self.alone.add(passed)
        for window in self._windows.values():
            window.add(t - self._begin_us)

    @property
    def duration_us(self) -> int:
        """From the first to the last good event."""
        return self._end_us - self._begin_us

    @property
    def peaks_hz(self) -> dict[int, float]:
        """Largest rate in one window, by its length in ms."""
        return {ms: window.rate_hz for ms, window in self._windows.items()}
