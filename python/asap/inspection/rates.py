"""Event rate over time: peaks in windows of 1, 10 and 100 ms, and a curve of bounded length."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from asap.analysis import PeakCount

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
