"""Meters on the stream of good events: silence, crowded stamps, duplicates. Flat memory.

Every meter sees blocks in time order that may cut a stamp, and tells the same however they are cut.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from asap.inspection.door import Integers, Passed, Tally
from asap.results.data import BINS_FROM_US
from asap.results.numbers import PeakCount

GAP_US = 100_000  # so long without an event is a gap
CROWD = 100  # events on one stamp; sound recordings have up to 94
STUCK_US = 1_000  # a crowded stamp after which time jumps by so much: the clock stood
BAND = 4  # events on one stamp ...
BAND_GAP_US = 10  # ... and none for so long: a band; sound recordings have 0.1 % of events in bands


class Gaps:
    """Times without an event; a gap is told by the event that ends it."""

    def __init__(self) -> None:
        self.tally = Tally()
        self.longest_us = 0
        self._last_us: int | None = None

    def add(self, passed: Passed) -> None:
        """See a block, which is not empty."""
        t: Integers = passed.events["t"]
        before = t[0] if self._last_us is None else self._last_us
        silent_us = np.diff(t, prepend=before)
        self.longest_us = max(self.longest_us, int(silent_us.max()))
        ends = np.flatnonzero(silent_us >= GAP_US)
        self.tally.add(passed.numbers[ends], passed.stamps[ends])
        self._last_us = int(t[-1])


class Stamps:
    """Runs of events on one stamp; a run is told by its first event."""

    def __init__(self) -> None:
        self.crowded = Tally()
        self.stuck = Tally()
        self.bands = Tally()
        self.banded_events = 0
        self.most = 0
        self.stuck_us = 0
        self._open: tuple[int, int, int, int] | None = None  # stamp, size, number, own stamp

    def add(self, passed: Passed) -> None:
        """See a block, which is not empty."""
        t: Integers = passed.events["t"]
        begins = np.flatnonzero(np.diff(t, prepend=t[0] - 1))
        stamps, numbers, own = t[begins], passed.numbers[begins], passed.stamps[begins]
        sizes = np.diff(begins, append=len(t))
        if self._open is not None:
            stamp, size, number, own_stamp = self._open
            if stamp == stamps[0]:
                sizes[0] += size
                numbers[0], own[0] = number, own_stamp
            else:
                stamps, sizes = np.append(stamp, stamps), np.append(size, sizes)
                numbers, own = np.append(number, numbers), np.append(own_stamp, own)
        self._close(sizes[:-1], np.diff(stamps), numbers[:-1], own[:-1])
        self._open = (int(stamps[-1]), int(sizes[-1]), int(numbers[-1]), int(own[-1]))

    def finish(self) -> None:
        """Close the last run: no time passes after it."""
        if self._open is not None:
            _, *last = self._open
            size, number, own = (np.array([value]) for value in last)
            self._close(size, np.zeros(1, np.int64), number, own)
            self._open = None

    def _close(self, sizes: Integers, jumps_us: Integers, numbers: Integers, own: Integers) -> None:
        self.most = max(self.most, int(sizes.max(initial=0)))
        crowded = sizes > CROWD
        stuck = crowded & (jumps_us >= STUCK_US)
        band = (sizes >= BAND) & (jumps_us >= BAND_GAP_US)
        self.crowded.add(numbers[crowded], own[crowded])
        self.stuck.add(numbers[stuck], own[stuck])
        self.bands.add(numbers[band], own[band])
        self.banded_events += int(sizes[band].sum())
        self.stuck_us += int(jumps_us[stuck].sum())


class Duplicates:
    """Events that equal an earlier one in x, y, p and t.

    Equal stamps are neighbours, so that only the distinct events of the open stamp are remembered.
    """

    def __init__(self) -> None:
        self.tally = Tally()
        self._open_us: int | None = None
        self._remembered = np.empty(0, np.int64)

    def add(self, passed: Passed) -> None:
        """See a block, which is not empty."""
        events = passed.events
        t: Integers = events["t"]
        if self._open_us != t[0]:
            self._remembered = np.empty(0, np.int64)
        # 33 bits for pixel and polarity, above them the number of the stamp in the block.
        stamp = np.cumsum(np.diff(t, prepend=t[0]) > 0)
        pixel = events["y"].astype(np.int64) << 16 | events["x"]
        keys = np.append(self._remembered, stamp << 33 | pixel << 1 | events["p"])
        order = np.argsort(keys, kind="stable")
        ascending = keys[order]
        again = order[1:][ascending[1:] == ascending[:-1]] - self._remembered.size
        again.sort()
        self.tally.add(passed.numbers[again], passed.stamps[again])
        last = ascending[np.searchsorted(ascending, stamp[-1] << 33) :]
        self._remembered = np.unique(last & ((1 << 33) - 1))
        self._open_us = int(t[-1])


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


_BINS = 1 << 14  # of the curve; even

Floats = npt.NDArray[np.float64]


class RateMeter:
    """Rates of a stream; windows are aligned to the first event."""

    def __init__(self) -> None:
        self.curve = RateCurve()
        self._windows = {ms: PeakCount(ms * 1000) for ms in (1, 10, 100)}

    @property
    def peaks_hz(self) -> dict[int, float]:
        """Largest rate in one window, by its length in ms."""
        return {ms: window.rate_hz for ms, window in self._windows.items()}

    def add(self, elapsed_us: npt.NDArray[np.int64]) -> None:
        """See the times of a block, which is not empty."""
        for window in self._windows.values():
            window.add(elapsed_us)
        self.curve.add(elapsed_us)


class RateCurve:
    """The rate in every ms, while they fit; then mean and largest of 2, 4, 8 ... ms."""

    def __init__(self) -> None:
        self.bin_ms = 1
        self._counts = np.zeros(_BINS, np.int64)
        self._peaks = np.zeros(_BINS, np.int64)
        self._open_ms, self._open_count = 0, 0

    def add(self, elapsed_us: npt.NDArray[np.int64]) -> None:
        """See the times of a block, which is not empty."""
        windows, counts = np.unique(elapsed_us // 1000, return_counts=True)
        if windows[0] == self._open_ms:
            counts[0] += self._open_count
        else:
            self._book(np.array([self._open_ms]), np.array([self._open_count]))
        self._book(windows[:-1], counts[:-1])
        self._open_ms, self._open_count = int(windows[-1]), int(counts[-1])

    def finish(self) -> None:
        """Book the last ms."""
        self._book(np.array([self._open_ms]), np.array([self._open_count]))
        self._open_count = 0

    def curves(self) -> tuple[Floats, Floats, Floats]:
        """Begin of each window in s from the first event; mean and largest 1-ms rate in ev/s."""
        length = self._open_ms // self.bin_ms + 1
        time_s = np.arange(length, dtype=np.float64) * (self.bin_ms / 1e3)
        mean_hz = self._counts[:length].astype(np.float64) * (1e3 / self.bin_ms)
        return time_s, mean_hz, self._peaks[:length].astype(np.float64) * 1e3

    def _book(self, windows: npt.NDArray[np.int64], counts: npt.NDArray[np.int64]) -> None:
        if windows.size == 0:
            return
        while windows[-1] >= _BINS * self.bin_ms:
            self._fold()
        at = windows // self.bin_ms
        np.add.at(self._counts, at, counts)
        np.maximum.at(self._peaks, at, counts)

    def _fold(self) -> None:
        half = _BINS // 2
        self._counts[:half] = self._counts.reshape(-1, 2).sum(axis=1)
        self._peaks[:half] = self._peaks.reshape(-1, 2).max(axis=1)
        self._counts[half:] = self._peaks[half:] = 0
        self.bin_ms *= 2
