"""How many events every pixel had, and which pixels are hot."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from asap.events import Events

MAX_SIDE = 4096  # px of the map, which bounds its memory
HOT_EVENTS = 100  # a hot pixel has at least so many events,
HOT_SHARE = 1e-3  # at least this share of all,
HOT_FACTOR = 5  # and so many times those of the second busiest pixel around it

PIXEL_DTYPE = np.dtype([("x", "<u2"), ("y", "<u2"), ("events", "<i8")])

Counts = npt.NDArray[np.int64]
Pixels = npt.NDArray[np.void]

_REACH = 2  # px around a pixel that are its neighbours


class PixelMap:
    """Counts of shape (height, width); without a sensor size it grows as far as events go."""

    def __init__(self, width: int | None, height: int | None) -> None:
        self.counts: Counts = np.zeros(
            (min(height or 1, MAX_SIDE), min(width or 1, MAX_SIDE)), np.int64
        )
        self.events = 0
        self.beyond = 0  # events that the map is too small for

    def add(self, events: Events) -> None:
        """Count the events of a block."""
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

    def busiest(self, count: int = 10) -> Pixels:
        """Return the pixels with most events, the busiest first; ties in reading order."""
        flat = self.counts.ravel()
        least = np.partition(flat, -count)[-count] if flat.size > count else 0
        at = np.flatnonzero(flat >= max(int(least), 1))
        return self._pixels(at)[:count]

    def hot(self) -> Pixels:
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

    def _pixels(self, at: npt.NDArray[np.intp]) -> Pixels:
        pixels = np.zeros(at.size, PIXEL_DTYPE)
        pixels["y"], pixels["x"] = np.divmod(at, self.counts.shape[1])
        pixels["events"] = self.counts.ravel()[at]
        return pixels[np.argsort(-pixels["events"], kind="stable")]
