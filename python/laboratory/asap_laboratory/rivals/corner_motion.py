"""CornerMotion: independent motion by corner tracks, the rival of `asap.MotionSegmenter`.

Corners are tracked; the velocities of the tracks about the motion of all have a mean and a
covariance; a track whose Mahalanobis distance is beyond a threshold moves on its own. A baseline of
an experiment, no product.

Source: Vasco et al., "Independent Motion Detection with Event-driven Cameras", ICAR 2017, where the
robot's encoders tell the motion of all; here it is fitted to the tracks.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from asap import _core

_ROUNDS = 5
_MIN_EVENTS = 5  # of a track whose velocity counts
_MIN_TRACKS = 12


class CornerMotion:
    """Say which corner tracks move on their own."""

    def __init__(self, width: int, height: int, *, threshold: float = 3.0) -> None:
        self._tracker = _core.FeatureTracker(width, height, detector="e_harris", radius=4)
        self._middle = 0.5 * np.array([width - 1, height - 1])
        self._threshold = threshold

    def process(self, events: NDArray[np.void]) -> None:
        """Follow the corners of these events."""
        self._tracker.process(events, labels=False)

    def movers(self) -> tuple[NDArray[np.void], NDArray[np.bool_]]:
        """Return the tracks with a velocity, and which of them move on their own."""
        tracks = self._tracker.tracks
        tracks = tracks[(tracks["size"] >= _MIN_EVENTS) & (tracks["vx"] != 0)]
        if tracks.size < _MIN_TRACKS:
            return tracks, np.zeros(tracks.size, bool)
        residual = self._residual(tracks)
        within = np.ones(tracks.size, bool)
        for _ in range(_ROUNDS):
            about = residual - residual[within].mean(axis=0)
            inverse = np.linalg.pinv(np.cov(residual[within].T))
            distance = np.sqrt(np.einsum("ni,ij,nj->n", about, inverse, about))
            within = distance <= self._threshold
        return tracks, ~within

    def _residual(self, tracks: NDArray[np.void]) -> NDArray[np.float64]:
        """Return the velocities without shift, turn and zoom, which are fitted robustly."""
        x, y = (np.stack([tracks["x"], tracks["y"]], axis=-1) - self._middle).T
        one, none = np.ones_like(x), np.zeros_like(x)
        rows = np.stack(
            [np.stack([one, none, -y, x], axis=-1), np.stack([none, one, x, y], axis=-1)], axis=1
        )
        velocities = np.stack([tracks["vx"], tracks["vy"]], axis=-1)
        weights = np.ones(tracks.size)
        residual = velocities
        for _ in range(_ROUNDS):
            root = np.sqrt(weights)[:, None]
            found, *_ = np.linalg.lstsq(
                (rows * root[..., None]).reshape(-1, 4), (velocities * root).ravel(), rcond=None
            )
            residual = velocities - rows @ found
            error = np.hypot(*residual.T)
            weights = 1 / (1 + (error / (2 * np.median(error) + 1e-9)) ** 2) ** 2
        return residual
