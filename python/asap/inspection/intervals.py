"""The histogram of the times between an event and the one before it."""

from __future__ import annotations

import numpy as np

from asap.inspection.door import Passed
from asap.inspection.tally import Integers
from asap.results.inspection import BINS_FROM_US


class Intervals:
    """Counts by octaves; blocks in time order, however they are cut."""

    def __init__(self) -> None:
        self.counts: Integers = np.zeros(BINS_FROM_US.size, np.int64)
        self._last_us: int | None = None

    def add(self, passed: Passed) -> None:
        """See a block, which is not empty; the first event of all has none before it."""
        t: Integers = passed.events["t"]
        times_us = np.diff(t) if self._last_us is None else np.diff(t, prepend=self._last_us)
        bins = np.searchsorted(BINS_FROM_US, times_us, side="right") - 1
        self.counts += np.bincount(bins, minlength=self.counts.size)
        self._last_us = int(t[-1])
