"""FrameTracker: objects tracked by images of events, the usual way before events are taken singly.

One binary image per period, denoised by neighbours; the connected components of its coarse cells; a
Kalman filter of constant velocity for each track, assigned by the Hungarian method. A baseline of
an experiment, no product.

Sources: Acharya et al., EBBIOT, 2019 (binary images, regions of a coarser one); Bewley et al.,
SORT, ICIP 2016 (Kalman filter and Hungarian method).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.optimize import linear_sum_assignment

CLUSTER_DTYPE = np.dtype([("id", "<i8"), *((name, "<f8") for name in ("x", "y", "vx", "vy"))])

_TRACK_DTYPE = np.dtype(
    [
        *CLUSTER_DTYPE.descr,
        ("pp", "<f8"),  # variance of the position, the same in x and y; px^2
        ("pv", "<f8"),  # its covariance with the velocity
        ("vv", "<f8"),  # variance of the velocity
        ("hits", "<i8"),
        ("misses", "<i8"),  # in a row
    ]
)

# Chosen on seed 0 of the scenes A, C, D, E, H bars, I and J, one after the other.
_CELL_PX = 6  # cells with a pixel that touch are one component
_MIN_PX = 20  # of a component
_CONFIRM = 4  # images in which a track has been seen, before it is told
_MISSES = 4  # images in a row without it that end a track
_MEASUREMENT_PX = 6.0  # error of a component's centre
_ACCELERATION = 3000.0  # px/s^2
_SPEED = 400.0  # px/s, spread of the velocity at birth
_GATE = 3.0  # standard deviations

_APART = 1e6  # cost of a pair outside the gate: more than all others together


class FrameTracker:
    """Track the components of binary images of events.

    `period_us`: of the images. `neighbours`: of 8 that a pixel with an event needs, else it is
    noise.
    """

    def __init__(self, width: int, height: int, *, period_us: int, neighbours: int) -> None:
        self._pixels = np.zeros((height, width), np.uint8)
        self._period_us = period_us
        self._neighbours = neighbours
        self._end_us: int | None = None  # of the image that is being filled
        self._tracks = np.empty(0, _TRACK_DTYPE)
        self._next_id = 0

    def process(self, events: NDArray[np.void], labels: bool = False) -> None:
        """Fill images, and take every one that is full; stamps ascend."""
        if not events.size:
            return
        if self._end_us is None:
            self._end_us = int(events["t"][0]) + self._period_us
        while events["t"][-1] >= self._end_us:
            now = int(np.searchsorted(events["t"], self._end_us))
            self._fill(events[:now])
            self._take()
            events = events[now:]
        self._fill(events)

    def clusters_at(self, t_us: int) -> NDArray[np.void]:
        """Return id, x, y, vx, vy of the confirmed tracks at a time, sorted by id; px, px/s.

        The events up to that time are known: an image that ends by then is full.
        """
        if self._end_us is None:
            return np.empty(0, CLUSTER_DTYPE)
        while self._end_us <= t_us:
            self._take()
        told = self._tracks[self._tracks["hits"] >= _CONFIRM]
        table = np.empty(told.size, CLUSTER_DTYPE)
        for name in CLUSTER_DTYPE.names or ():
            table[name] = told[name]
        since_s = (t_us - (self._end_us - self._period_us)) * 1e-6
        table["x"] += since_s * told["vx"]
        table["y"] += since_s * told["vy"]
        return table

    def _fill(self, events: NDArray[np.void]) -> None:
        self._pixels[events["y"], events["x"]] = 1

    def _take(self) -> None:
        """Track the components of the image, and begin the next one."""
        assert self._end_us is not None
        self._end_us += self._period_us
        self._predict(self._period_us * 1e-6)
        centres = components(self._pixels, self._neighbours)
        self._pixels[:] = 0
        rows, columns = self._pairs(centres)
        self._correct(rows, centres[columns])
        missed = np.ones(self._tracks.size, bool)
        missed[rows] = False
        self._tracks["misses"] = np.where(missed, self._tracks["misses"] + 1, 0)
        # A track that is not confirmed ends with the first image without it.
        patience = np.where(self._tracks["hits"] < _CONFIRM, 1, _MISSES)
        kept = self._tracks[self._tracks["misses"] < patience]
        unmatched = np.delete(centres, columns, axis=0)
        self._tracks = np.concatenate([kept, self._born(unmatched)])

    def _predict(self, dt_s: float) -> None:
        tracks = self._tracks
        tracks["x"] += dt_s * tracks["vx"]
        tracks["y"] += dt_s * tracks["vy"]
        noise = _ACCELERATION**2
        tracks["pp"] += dt_s * (2 * tracks["pv"] + dt_s * tracks["vv"]) + noise * dt_s**4 / 4
        tracks["pv"] += dt_s * tracks["vv"] + noise * dt_s**3 / 2
        tracks["vv"] += noise * dt_s**2

    def _pairs(self, centres: NDArray[np.float64]) -> tuple[Any, Any]:
        """Assign tracks to components: the most pairs inside the gate, then the nearest ones."""
        tracks = self._tracks
        away = np.hypot(
            tracks["x"][:, None] - centres[None, :, 0], tracks["y"][:, None] - centres[None, :, 1]
        )
        sigmas = away / np.sqrt(tracks["pp"] + _MEASUREMENT_PX**2)[:, None]
        rows, columns = linear_sum_assignment(np.where(sigmas <= _GATE, sigmas, _APART))
        inside = sigmas[rows, columns] <= _GATE
        return rows[inside], columns[inside]

    def _correct(self, rows: NDArray[np.int64], centres: NDArray[np.float64]) -> None:
        seen = self._tracks[rows]
        total = seen["pp"] + _MEASUREMENT_PX**2
        of_position, of_velocity = seen["pp"] / total, seen["pv"] / total
        for axis, position in enumerate("xy"):
            innovation = centres[:, axis] - seen[position]
            seen[position] += of_position * innovation
            seen["v" + position] += of_velocity * innovation
        seen["vv"] -= of_velocity * seen["pv"]
        seen["pv"] *= 1 - of_position
        seen["pp"] *= 1 - of_position
        seen["hits"] += 1
        self._tracks[rows] = seen

    def _born(self, centres: NDArray[np.float64]) -> NDArray[np.void]:
        tracks = np.zeros(len(centres), _TRACK_DTYPE)
        tracks["id"] = self._next_id + np.arange(len(centres))
        tracks["x"], tracks["y"] = centres.T
        tracks["pp"], tracks["vv"], tracks["hits"] = _MEASUREMENT_PX**2, _SPEED**2, 1
        self._next_id += len(centres)
        return tracks


def components(pixels: NDArray[np.uint8], neighbours: int) -> NDArray[np.float64]:
    """Return the centres of the boxes around an image's components, shape (m, 2), px."""
    padded = np.pad(pixels, 1)
    across = padded[:, :-2] + padded[:, 1:-1] + padded[:, 2:]
    around = across[:-2] + across[1:-1] + across[2:]
    y, x = np.nonzero((pixels > 0) & (around > neighbours))  # itself is one of the nine
    cells = np.zeros([side // _CELL_PX + 1 for side in pixels.shape], bool)
    cells[y // _CELL_PX, x // _CELL_PX] = True
    parts, count = ndimage.label(cells, structure=np.ones((3, 3)))
    part = parts[y // _CELL_PX, x // _CELL_PX] - 1
    centres = np.stack([_middles(x, part, count), _middles(y, part, count)], axis=-1)
    return centres[np.bincount(part, minlength=count) >= _MIN_PX]


def _middles(values: NDArray[np.int64], part: NDArray[np.int64], count: int) -> NDArray[np.float64]:
    """Half of the least and the greatest value of each part."""
    least, greatest = np.full(count, np.inf), np.full(count, -np.inf)
    np.minimum.at(least, part, values)
    np.maximum.at(greatest, part, values)
    middles: NDArray[np.float64] = 0.5 * (least + greatest)
    return middles
