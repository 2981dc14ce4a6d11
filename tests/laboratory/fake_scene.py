"""Scenes and trackers whose every answer is written down in a test."""

from __future__ import annotations

import numpy as np

import asap
import streams

CLUSTER_DTYPE = np.dtype(
    [("id", "<i8"), *((name, "<f8") for name in ("x", "y", "vx", "vy")), ("t_last", "<i8")]
)
TRUTH_DTYPE = np.dtype([("id", "<i4"), *((name, "<f8") for name in ("x", "y", "vx", "vy"))])
STEP_US = 1000


class FakeScene:
    """Objects on straight lines, an event of each every step at its centre, from 0 us on.

    objects: (x, y, vx, vy) at t = 0, px and px/s. noise: stamps of events that no object caused.
    silent: {object: (begin_us, end_us)} without events.
    """

    width, height = 346, 260

    def __init__(self, objects, end_us=130_001, noise=(), silent=None, step_us=STEP_US):
        self.objects = np.array(objects, float).reshape(-1, 4)
        rows = [(t, 1, 1, -1) for t in noise]
        for label, (x, y, vx, vy) in enumerate(self.objects):
            begin, end = (silent or {}).get(label, (0, 0))
            rows += [
                (t, x + vx * t * 1e-6, y + vy * t * 1e-6, label)
                for t in range(0, end_us, step_us)
                if not begin <= t < end
            ]
        t, x, y, labels = np.array(sorted(rows)).T if rows else np.empty((4, 0))
        self.events = streams.make(t, np.rint(x), np.rint(y), 1)
        self.labels = labels.astype(np.int32)

    def truth(self, t_us):
        found = np.zeros(len(self.objects), TRUTH_DTYPE)
        found["id"] = np.arange(len(self.objects))
        for axis in range(2):
            found["xy"[axis]] = self.objects[:, axis] + self.objects[:, 2 + axis] * t_us * 1e-6
            found[("vx", "vy")[axis]] = self.objects[:, 2 + axis]
        return found


class FakeTracker:
    """Says what it was told to.

    clusters: t_us -> rows (id, x, y[, vx, vy]). ids: events -> id of each; None: returns nothing.
    """

    def __init__(self, clusters, ids=None):
        self._clusters, self._ids = clusters, ids
        self.packages = []
        self.gammas = []

    def process(self, events):
        assert events.dtype == asap.EVENT_DTYPE
        self.packages.append(events.copy())
        return None if self._ids is None else np.array(self._ids(events), np.int32)

    def clusters_at(self, t_us):
        rows = [(*row, 0, 0)[:5] for row in self._clusters(t_us)]
        return np.array([(*row, t_us - 1000) for row in rows], CLUSTER_DTYPE)

    def set_gamma(self, gamma):
        self.gammas.append(gamma)


def perfect(scene, first_id=10, **others):
    """A tracker that knows the truth: object k has the id first_id + k."""

    def clusters(t_us):
        return [(one["id"] + first_id, *one.tolist()[1:]) for one in scene.truth(t_us)]

    return FakeTracker(clusters, **others)
