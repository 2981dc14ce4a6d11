"""NaiveClusterer: the published clustering rule as one writes it first, in a Python loop.

The top of the ladder: the rule of `asap.PublishedClusterTracker(probes=0)`, a few thousand times
slower than a filter. For an experiment, no product.
"""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np
from numpy.typing import NDArray

_DTYPE = np.dtype([("id", "<i8"), ("x", "<f8"), ("y", "<f8")])


class _Cluster:
    """A centre that follows the events, and what is needed for the mean of those that live."""

    def __init__(self, id: int, x: float, y: float) -> None:
        self.id, self.x, self.y = id, x, y
        self.size, self.sum_x, self.sum_y = 0, 0.0, 0.0
        self.merged_into: _Cluster | None = None

    def root(self) -> _Cluster:
        cluster = self
        while cluster.merged_into is not None:
            cluster = cluster.merged_into
        return cluster

    def add(self, x: float, y: float, count: int = 1) -> None:
        self.size += count
        self.sum_x += x
        self.sum_y += y


class NaiveClusterer:
    """Link an event to every cluster within a radius, merge those, forget beyond a count of events.

    `window`: events that are remembered; `radius`: px, L1; `weight`: of a new event in the centre;
    `min_size`: events of a cluster that is reported. Rodriguez-Gomez et al., ICRA 2020, without
    random probes.
    """

    def __init__(
        self, *, window: int = 8000, radius: float = 20.0, weight: float = 0.05, min_size: int = 15
    ) -> None:
        self._window, self._radius, self._weight = window, radius, weight
        self._min_size = min_size
        self._clusters: list[_Cluster] = []  # the oldest first
        self._live: deque[tuple[int, int, _Cluster]] = deque()
        self._made = 0

    def process(self, events: NDArray[np.void]) -> None:
        """Take events in time order."""
        for x, y in zip(events["x"].tolist(), events["y"].tolist(), strict=True):
            self._take(x, y)

    @property
    def clusters(self) -> NDArray[np.void]:
        """Clusters of at least `min_size` events: id, and the mean x, y of its events, px."""
        rows = [
            (one.id, one.sum_x / one.size, one.sum_y / one.size)
            for one in self._clusters
            if one.size >= self._min_size
        ]
        return np.array(rows, _DTYPE)

    def _take(self, x: int, y: int) -> None:
        if len(self._live) == self._window:
            self._forget_the_oldest()
        near = [one for one in self._clusters if abs(x - one.x) + abs(y - one.y) <= self._radius]
        if near:
            first = near[0]
            first.x += self._weight * (x - first.x)
            first.y += self._weight * (y - first.y)
        else:
            first = _Cluster(self._made, x, y)
            self._made += 1
            self._clusters.append(first)
        first.add(x, y)
        self._live.append((x, y, first))
        if len(near) > 1:
            self._merge(first, near)

    def _merge(self, first: _Cluster, near: list[_Cluster]) -> None:
        total = sum(one.size for one in near)
        first.x = sum(one.size * one.x for one in near) / total
        first.y = sum(one.size * one.y for one in near) / total
        for other in near[1:]:
            first.add(other.sum_x, other.sum_y, other.size)
            other.merged_into = first
            self._clusters.remove(other)

    def _forget_the_oldest(self) -> None:
        x, y, owner = self._live.popleft()
        cluster = owner.root()
        cluster.add(-x, -y, -1)
        if cluster.size == 0:
            self._clusters.remove(cluster)


def make(width: int, height: int) -> Any:
    """Make one as the other rungs are made; it knows no sensor."""
    return NaiveClusterer()
