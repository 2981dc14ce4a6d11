"""Tracks: what an algorithm with objects or clusters found, kept over the time of a run."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from asap import _checks, _core
from asap.events import EVENT_DTYPE, Events
from asap.io.writers import replacing

_COLUMNS = ("id", "t", "x", "y", "vx", "vy", "size")
_SHAPE = ("left", "top", "width", "height", "cxx", "cxy", "cyy")  # px, px^2, not in the file
_MAX_SEEN = 1 << 20  # events that are kept for pictures; more thin each other out


class Tracks:
    """An algorithm with ``.objects``, or ``.clusters``, that notes where they are.

    The algorithm gets every package as a whole, and what the notes cost is measured with it.

    Parameters
    ----------
    algorithm
        A `ClusterTracker`, or an instance with process(events) and ``.objects`` or ``.clusters``, a
        structured array with the fields id, x, y and, where it has them, vx, vy and size.
    every_ms : float, optional
        Time of the events between two notes, ms. Default: after every package with a new timestamp.

    Attributes
    ----------
    tracks : ndarray
        A row for each object, or cluster of an algorithm without objects, at each note: id, t (us,
        the last event of the package), x, y, vx, vy, size, and its box (left, top, width, height)
        or covariance (cxx, cxy, cyy); of these what the algorithm has. px, px/s, px^2, events.

    Raises
    ------
    TypeError
        The algorithm lacks ``process`` or an array of objects or clusters.
    ValueError
        `every_ms` is out of range.

    Examples
    --------
    >>> scene = asap.synthetic.FlightOverChairs(duration_s=0.2)
    >>> tracks = asap.Tracks(asap.ClusterTracker(scene.width, scene.height), every_ms=10)
    >>> run = asap.simulate(scene, cost=asap.LinearCost(2, 70), algorithm=tracks, latency_ms=10)
    >>> tracks.tracks.dtype.names[:4]
    ('id', 't', 'x', 'y')
    """

    def __init__(self, algorithm: Any, *, every_ms: float | None = None) -> None:
        self._name = "objects" if hasattr(algorithm, "objects") else "clusters"
        fields = _fields(getattr(algorithm, self._name, None))
        if not (hasattr(algorithm, "process") and {"id", "x", "y"} <= set(fields)):
            remedy = "give one with process(events) and objects or clusters, an array with id, x, y"
            raise TypeError(_checks.named("algorithm", algorithm, remedy))
        self.algorithm = algorithm
        remedy = "give 0.001 ms or more, or None for every package"
        least = 1e-3 if every_ms is None else every_ms
        self._every_us = round(_checks.number("every_ms", least, 1e-3, 1e9, remedy) * 1e3)
        own = isinstance(algorithm, _core.ClusterTracker)
        self._options: dict[str, Any] = {"labels": False} if own else {}  # not needed here
        self._forget()

    def _forget(self) -> None:
        self._next_us = -(2**62)
        self._rows: list[NDArray[np.void]] = [self._now(0)[:0]]
        self._seen: list[Events] = []
        self._noted = self._seen_count = 0
        self._seen_every = 1

    def _now(self, t_us: int) -> NDArray[np.void]:
        return _rows_of(getattr(self.algorithm, self._name), t_us)

    def __getattr__(self, name: str) -> Any:
        if name == "algorithm":  # not made yet, as where a pickle is read
            raise AttributeError(name)
        return getattr(self.algorithm, name)

    def process(self, events: Events) -> None:
        """Let the algorithm process a package, and note what it found when it is time."""
        self.algorithm.process(events, **self._options)
        now_us = int(events["t"][-1]) if len(events) else self._next_us - 1
        if now_us < self._next_us:
            return
        self._next_us = (now_us // self._every_us + 1) * self._every_us
        self._rows.append(self._now(now_us))
        self._seen.append(events[-self._noted % self._seen_every :: self._seen_every].copy())
        self._noted += len(events)
        self._seen_count += len(self._seen[-1])
        if self._seen_count > _MAX_SEEN:
            self._seen = [self.seen[::2].copy()]
            self._seen_count, self._seen_every = len(self._seen[0]), 2 * self._seen_every

    def reset(self) -> None:
        """Forget the tracks, and let the algorithm forget."""
        self.algorithm.reset()
        self._forget()

    @property
    def tracks(self) -> NDArray[np.void]:
        """All notes so far."""
        self._rows = [np.concatenate(self._rows)]
        return self._rows[0]

    @property
    def seen(self) -> Events:
        """Some events of the notes, for a picture."""
        return np.concatenate([np.empty(0, EVENT_DTYPE), *self._seen])

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the tracks as CSV with a line of names, and return the path."""
        file = _checks.new_file("path", path)
        _checks.ending("path", file, (".csv",), "give a name that ends in .csv")
        tracks = self.tracks
        names = [name for name in _COLUMNS if name in (tracks.dtype.names or ())]
        whole = [np.issubdtype(tracks.dtype[name], np.integer) for name in names]
        formats = ["%d" if is_whole else "%.6g" for is_whole in whole]
        how: Any = {"delimiter": ",", "header": ",".join(names), "comments": ""}
        with replacing(file) as opened:
            np.savetxt(opened, tracks[names], formats, **how)
        return file


def _rows_of(found: NDArray[np.void], t_us: int) -> NDArray[np.void]:
    kinds = {"t": np.dtype("<i8"), **{name: kind for name, (kind, *_) in _fields(found).items()}}
    names = [name for name in (*_COLUMNS, *_SHAPE) if name in kinds]
    rows = np.empty(len(found), [(name, kinds[name]) for name in names])
    for name in rows.dtype.names or ():
        rows[name] = t_us if name == "t" else found[name]
    return rows


def _fields(found: Any) -> Mapping[str, Any]:
    return getattr(getattr(found, "dtype", None), "fields", None) or {}
