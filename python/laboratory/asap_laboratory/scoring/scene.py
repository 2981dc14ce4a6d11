"""What an algorithm is scored on: events with labels, and the truth at any time."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from asap._checks import unmasked
from asap.events import EVENT_DTYPE

NOISE = -1  #: label of an event that no object caused


class Scene(Protocol):
    """Anything with these attributes; those of `asap_laboratory.scenes` have them.

    Attributes
    ----------
    events : ndarray, shape (n,), EVENT_DTYPE
        In time order; stamps in us from 0.
    labels : ndarray of int, shape (n,)
        The object that caused each event, -1 for noise.
    width, height : int
        Of the sensor, px.

    Notes
    -----
    Where a cluster may be farther than 12 px from the centre of a large object, a scene has
    ``match_radii_px(t_us)``, px for each row of the truth. A scene for corner detectors has
    ``vertices(t_us)`` too: structured array id, x, y, one row per corner of an object.
    """

    @property
    def events(self) -> NDArray[np.void]: ...  # noqa: D102
    @property
    def labels(self) -> NDArray[np.integer[Any]]: ...  # noqa: D102
    @property
    def width(self) -> int: ...  # noqa: D102
    @property
    def height(self) -> int: ...  # noqa: D102

    def truth(self, t_us: int) -> NDArray[np.void]:
        """Return id, x, y [px], vx, vy [px/s] of every object at a time."""
        ...


def check_scene(scene: Any) -> None:
    """Refuse what is no scene."""
    missing = [
        name
        for name in ("events", "labels", "truth", "width", "height")
        if not hasattr(scene, name)
    ]
    if missing:
        raise TypeError(
            f"scene: a {type(scene).__name__} without {', '.join(missing)}; take one of "
            "asap_laboratory.scenes, or give an object with events, labels, truth(t_us), width and "
            "height"
        )
    for name in ("events", "labels"):
        unmasked(f"scene.{name}", getattr(scene, name))
    events, labels = scene.events, np.asarray(scene.labels)
    if getattr(events, "dtype", None) != EVENT_DTYPE:
        raise TypeError("scene.events: not in EVENT_DTYPE; convert with asap.as_events")
    if labels.shape != events.shape or not np.issubdtype(labels.dtype, np.integer):
        raise ValueError(
            f"scene.labels of shape {labels.shape}, {labels.dtype}: must be one whole number for "
            f"each of the {events.size} events"
        )
    if np.any(np.diff(events["t"]) < 0):
        raise ValueError("scene.events: not in time order; sort them with their labels")
