"""What the validator would refuse, event by event: where it was, and how far it was off.

The core's own validator decides about stamps, so that the counts are those of a run. It sees a copy
of the events in whose x each has its place in the block: what comes out tells which ones passed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from asap import _core
from asap.events import EVENT_DTYPE, Events

_LAST_US = 1 << 52
_MAX_STAMP_US = _LAST_US - (1 << 50)  # beyond it the core refuses a stamp


Integers = npt.NDArray[np.int64]


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

    events: Events  #: stamps never go back: after a clock reset time continues; p is 0 or 1
    numbers: Integers  #: number of each in the source
    stamps: Integers  #: as the source has them


class Door:
    """Good events on one side, tallies of the others on the other, block by block.

    A file is looked ahead in for stray stamps, as `read` does.
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

    def check(self, block: Events) -> Passed:
        """Pass a block of at most 65536 events."""
        t: Integers = block["t"]
        numbers: Integers = self.seen + np.arange(len(block))
        self.seen += len(block)
        unreadable = (t > _MAX_STAMP_US) | (t < -_MAX_STAMP_US)
        outside = ~unreadable & ((block["x"] >= self._width) | (block["y"] >= self._height))
        at = np.flatnonzero(~(unreadable | outside))

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
        back = stamps_us <= _LAST_US  # else continued beyond the last stamp that there is
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


def _largest(values: npt.NDArray[np.int64]) -> int:
    return int(values.max(initial=0))
