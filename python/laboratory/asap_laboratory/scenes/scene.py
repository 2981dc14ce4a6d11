"""Scene: events with exact truth, lazily made."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from asap import _checks
from asap.events import Events
from asap.synthetic import joined
from asap_laboratory import _native

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TRUTH_DTYPE = np.dtype([("id", "<i4"), ("x", "<f8"), ("y", "<f8"), ("vx", "<f8"), ("vy", "<f8")])
CORNER_DTYPE = np.dtype([("id", "<i4"), ("x", "<f8"), ("y", "<f8")])

Labels = NDArray[np.int32]

Recipe = tuple[str, dict[str, Any]]  # a function of SceneLayout and its arguments

_STEP_US = 250
_MATCH_PX = 12.0
_MATCH_SHARE = 0.7  # of the reach of an object, in scenes of large ones
_LARGE = {
    *("large_shapes", "large_disks", "hands", "moving_camera"),
    *("sparse", "approaching", "lamps", "fence"),
}
_EVENTS_PER_ARRAY = 2**16


class Scene:
    """Events with exact truth. Made by the functions of `asap_laboratory.scenes`.

    Iterating yields the events in arrays of about 2**16, made as they are read: a scene is a source
    for `asap.run` and `asap.simulate`. `events` and `labels` are made once and kept.

    Attributes
    ----------
    name : str
        How the scene is called in tables and files.
    seed : int
        Decides on the layout, the pixels' thresholds and the noise.
    """

    def __init__(self, layout: _native.SceneLayout, *, name: str, seed: int) -> None:
        self.name = name
        self.seed = int(seed)
        self._layout = layout
        self._recipe: Recipe | None = None
        _native.MovingShapesStream(layout)  # checks it

    @classmethod
    def _of(cls, kind: str, *, label: str, seed: int, **parameters: Any) -> Scene:
        """Make one of a kind of layout; it pickles by what it was made of."""
        recipe = kind, {**parameters, "seed": seed}
        scene = cls(_layout(recipe), name=label, seed=seed)
        scene._recipe = recipe
        return scene

    def __getstate__(self) -> dict[str, Any]:
        if self._recipe is None:
            raise TypeError(f"cannot pickle scene {self.name}: its layout is its own; make it anew")
        made_again = {"_layout", "_whole", "_track", "_corners", "_corner_ids"}
        return {name: value for name, value in vars(self).items() if name not in made_again}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        assert self._recipe is not None
        self._layout = _layout(self._recipe)

    @property
    def width(self) -> int:
        """Columns of the sensor, px."""
        return self._layout.width

    @property
    def height(self) -> int:
        """Rows of the sensor, px."""
        return self._layout.height

    @property
    def duration_us(self) -> int:
        """Events lie in [0, duration), us."""
        return self._layout.duration_us

    @property
    def events(self) -> Events:
        """All events in time order: shape (n,), EVENT_DTYPE, read-only."""
        return self._whole[0]

    @property
    def labels(self) -> Labels:
        """Object of each event, -1 for noise: shape (n,), int32, read-only."""
        return self._whole[1]

    def blocks(self) -> Iterator[tuple[Events, Labels]]:
        """Yield events and labels piece by piece, in flat memory, from the start."""
        stream = _native.MovingShapesStream(self._layout)
        while True:
            events, labels = stream.read(_EVENTS_PER_ARRAY)
            if not events.size:
                return
            yield events, labels

    def __iter__(self) -> Iterator[Events]:
        """Yield the events piece by piece, from the start."""
        return (events for events, _ in self.blocks())

    def truth(self, t_us: float) -> NDArray[np.void]:
        """Where the objects are.

        Parameters
        ----------
        t_us : float
            0 to the duration, us. The answer is that of step ``floor(t_us / 250)``.

        Returns
        -------
        ndarray, shape (objects,), TRUTH_DTYPE
            id (the label), x, y in px, vx, vy in px/s.
        """
        poses = self._poses_at(t_us)
        truth = np.empty(len(poses), TRUTH_DTYPE)
        truth["id"] = np.arange(len(poses))
        for column, field in enumerate(("x", "y", "vx", "vy")):
            truth[field] = poses[:, column]
        return truth

    def vertices(self, t_us: float) -> NDArray[np.void]:
        """Where the objects' corners are; a disk has none.

        Parameters
        ----------
        t_us : float
            As for `truth`.

        Returns
        -------
        ndarray, shape (corners,), CORNER_DTYPE
            id of the object, x, y in px, around each object in order.
        """
        poses = self._poses_at(t_us)[self._corner_ids]
        along, across = self._corners.T * poses[:, 6]
        axis_x, axis_y = poses[:, 4], poses[:, 5]
        vertices = np.empty(len(poses), CORNER_DTYPE)
        vertices["id"] = self._corner_ids
        vertices["x"] = poses[:, 0] + along * axis_x - across * axis_y
        vertices["y"] = poses[:, 1] + along * axis_y + across * axis_x
        return vertices

    def reaches_px(self, t_us: float) -> NDArray[np.float64]:
        """Return how far each object gets from its centre at a time, px: shape (objects,)."""
        scales: NDArray[np.float64] = self._poses_at(t_us)[:, 6]
        return scales * self._layout.reaches_px

    def match_radii_px(self, t_us: float) -> NDArray[np.float64]:
        """Return how far from each centre a cluster may be to count as the object, px.

        12 px in `A` to `G`, in `H` to `O` at least that and 0.7 of the object's reach at that time.
        """
        is_large = self._recipe is not None and self._recipe[0] in _LARGE
        share = _MATCH_SHARE if is_large else 0.0
        return np.maximum(_MATCH_PX, share * self.reaches_px(t_us))

    def plot(self, t_ms: float | None = None, *, window_ms: float = 15.0) -> Figure:
        """Draw the events before a moment and the truth at it. Needs matplotlib.

        Parameters
        ----------
        t_ms : float, optional
            The moment; by default the middle of the scene.
        window_ms : float
            How far back the events go.
        """
        try:
            from asap_laboratory.scenes import figures
        except ModuleNotFoundError as error:
            words = "a picture of a scene needs matplotlib: install asap-events[report]"
            raise ImportError(words) from error

        return figures.snapshot(self, t_ms, window_ms=window_ms)

    def __repr__(self) -> str:
        return (
            f"<{type(self).__name__}: {self.name}, seed {self.seed}, "
            f"{self.width} x {self.height} px, {len(self._layout.reaches_px)} objects, "
            f"{self.duration_us * 1e-6:g} s>"
        )

    @cached_property
    def _whole(self) -> tuple[Events, Labels]:
        pieces = list(self.blocks())
        events = joined([events for events, _ in pieces])
        labels = np.concatenate([np.empty(0, np.int32), *(labels for _, labels in pieces)])
        events.flags.writeable = False
        labels.flags.writeable = False
        return events, labels

    @cached_property
    def _track(self) -> NDArray[np.float64]:
        return self._layout.track()

    @cached_property
    def _corners(self) -> NDArray[np.float64]:
        return np.concatenate([np.empty((0, 2)), *self._layout.corners()])

    @cached_property
    def _corner_ids(self) -> NDArray[np.int32]:
        sizes = [len(corners) for corners in self._layout.corners()]
        return np.repeat(np.arange(len(sizes), dtype=np.int32), sizes)

    def _poses_at(self, t_us: float) -> NDArray[np.float64]:
        remedy = f"give a time from 0 to {self.duration_us} us"
        _checks.number("t_us", t_us, 0, self.duration_us, remedy)
        poses: NDArray[np.float64] = self._track[int(t_us // _STEP_US)]
        return poses


def _layout(recipe: Recipe) -> _native.SceneLayout:
    kind, parameters = recipe
    layout: _native.SceneLayout = getattr(_native.SceneLayout, kind)(**parameters)
    return layout
