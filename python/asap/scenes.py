"""Scenes with truth: shapes that move before a camera, and what every event belongs to.

By these trackers are judged. `A` to `G` are named and fixed but for their seed; `timing`,
`corners`, `stop_and_go` and `occlusion` take parameters. The same arguments give the same events on
every machine; they are made natively, when they are first touched.

Shapes (disk, square, rectangle, triangle, star in turn; dark and bright in turn) move in steps of
250 us before an even ground. A pixel sees the log of its brightness, has thresholds of its own
around 0.25, and is blind for 0.3 ms after an event; background noise is independent of all that.

Limits, to be stated wherever results are shown: motion is quantised at 0.25 ms; there is no lens,
no bandwidth, no motion of the background; edges are of one contrast, shapes rigid.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from asap import _core
from asap.events import Events
from asap.synthetic import joined

if TYPE_CHECKING:
    from asap.plots import NotebookFigure

__all__ = [
    "CORNER_DTYPE",
    "TRUTH_DTYPE",
    "A",
    "B",
    "C",
    "D",
    "E",
    "F",
    "G",
    "Scene",
    "corners",
    "occlusion",
    "stop_and_go",
    "timing",
]

TRUTH_DTYPE = np.dtype([("id", "<i4"), ("x", "<f8"), ("y", "<f8"), ("vx", "<f8"), ("vy", "<f8")])
CORNER_DTYPE = np.dtype([("id", "<i4"), ("x", "<f8"), ("y", "<f8")])

Labels = NDArray[np.int32]

_STEP_US = 250
_EVENTS_PER_ARRAY = 2**16


class Scene:
    """Events with exact truth. Made by the functions of this module.

    Iterating yields the events in arrays of about 2**16, made as they are read: a scene is a source
    for `asap.run` and `asap.simulate`. `events` and `labels` are made once and kept.

    Attributes
    ----------
    name : str
        How the scene is called in tables and files.
    seed : int
        Decides on the layout, the pixels' thresholds and the noise.
    """

    def __init__(self, layout: _core.SceneLayout, *, name: str, seed: int) -> None:
        self.name = name
        self.seed = int(seed)
        self._layout = layout
        _core.MovingShapesStream(layout)  # checks it

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
        stream = _core.MovingShapesStream(self._layout)
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

        Raises
        ------
        ValueError
            The time lies outside the scene.
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

        Raises
        ------
        ValueError
            The time lies outside the scene.
        """
        poses = self._poses_at(t_us)[self._corner_ids]
        along, across = self._corners.T
        axis_x, axis_y = poses[:, 4], poses[:, 5]
        vertices = np.empty(len(poses), CORNER_DTYPE)
        vertices["id"] = self._corner_ids
        vertices["x"] = poses[:, 0] + along * axis_x - across * axis_y
        vertices["y"] = poses[:, 1] + along * axis_y + across * axis_x
        return vertices

    @property
    def reaches_px(self) -> NDArray[np.float64]:
        """How far each object gets from its centre, px: shape (objects,)."""
        return np.array(self._layout.reaches_px, np.float64)

    def thin(self, gamma: float, seed: int = 0) -> ThinnedScene:
        """Return this scene with each event kept with probability gamma; the truth stays.

        Parameters
        ----------
        gamma : float
            0 to 1.
        seed : int
            Of the `asap.GammaFilter` that decides.

        Raises
        ------
        ValueError
            gamma is not in [0, 1], or the seed is negative.
        """
        return ThinnedScene(self, gamma, seed)

    def plot(self, t_ms: float | None = None, *, window_ms: float = 15.0) -> NotebookFigure:
        """Draw the events before a moment and the truth at it. Needs matplotlib.

        Parameters
        ----------
        t_ms : float, optional
            The moment; by default the middle of the scene.
        window_ms : float
            How far back the events go.
        """
        from asap import scene_figures

        return scene_figures.snapshot(self, t_ms, window_ms=window_ms)

    def __repr__(self) -> str:
        return (
            f"<{type(self).__name__} {self.name}, seed {self.seed}: "
            f"{self.width} x {self.height} px, {len(self.reaches_px)} objects, "
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
        if not 0 <= t_us <= self.duration_us:
            raise ValueError(f"t_us = {t_us}: give a time from 0 to {self.duration_us} us")
        return self._track[int(t_us // _STEP_US)]


class ThinnedScene(Scene):
    """A scene of which a uniform random share of the events is left."""

    def __init__(self, whole: Scene, gamma: float, seed: int) -> None:
        self.name = whole.name
        self.seed = whole.seed
        self._source = whole
        self._layout = whole._layout
        self._gamma = gamma
        self._thin_seed = seed
        if not 0 <= gamma <= 1:
            raise ValueError(f"gamma = {gamma}: give 0 to 1")
        _core.GammaFilter(seed=seed)  # checks it

    def blocks(self) -> Iterator[tuple[Events, Labels]]:
        """Yield the events that are kept, and their labels, piece by piece."""
        keep = _core.GammaFilter(seed=self._thin_seed)
        for events, labels in self._source.blocks():
            kept = keep.mask(events, self._gamma)
            if kept.any():
                yield joined([events[kept]]), labels[kept]


def _named(name: str, seed: int) -> Scene:
    return Scene(_core.SceneLayout.named(name, seed), name=name, seed=seed)


def A(seed: int = 0) -> Scene:
    """20 objects on small orbits, 60 to 120 px/s; 346 x 260 px, 1.5 s, 0.5 Hz/px of noise."""
    return _named("A", seed)


def B(seed: int = 0) -> Scene:
    """As `A`, but 10 to 400 px/s."""
    return _named("B", seed)


def C(seed: int = 0) -> Scene:
    """8 objects that cross each other, 80 to 200 px/s; 346 x 260 px, 2 s, 0.5 Hz/px of noise."""
    return _named("C", seed)


def D(seed: int = 0) -> Scene:
    """As `A`, with 5 Hz/px of noise: two thirds of the events."""
    return _named("D", seed)


def E(seed: int = 0) -> Scene:
    """As `C`, a little smaller, on 240 x 180 px: more crossings."""
    return _named("E", seed)


def F(seed: int = 0) -> Scene:
    """8 objects of very different size and speed: radius 3 to 20 px, 20 to 600 px/s; 2 s."""
    return _named("F", seed)


def G(seed: int = 0) -> Scene:
    """30 objects of radius 6 to 14 px, up to 250 px/s; 640 x 480 px, 2 s, 2 Hz/px of noise."""
    return _named("G", seed)


def timing(
    n: int,
    width: int,
    height: int,
    speed: float,
    radius: tuple[float, float] = (6.0, 11.0),
    seed: int = 0,
    *,
    noise_hz: float = 0.5,
    duration_s: float = 1.0,
) -> Scene:
    """Free objects, for timing at a rate and a resolution of your choice.

    Parameters
    ----------
    n : int
        How many objects.
    width, height : int
        Of the sensor, px.
    speed : float
        The fastest, at most 2000 px/s; the others down to 0.4 of it.
    radius : (float, float)
        From, to, px.
    seed : int
        0 <= seed < 2**64.
    noise_hz : float
        Background events per second and pixel, at most ``1e6 / (width * height)``.
    duration_s : float
        A multiple of 250 us.

    Raises
    ------
    ValueError
        An argument is out of its range; the message names it.
    """
    if not 0.01 <= duration_s <= 86_400:
        raise ValueError(f"duration_s = {duration_s}: give 0.01 to 86400 s")
    layout = _core.SceneLayout.free_shapes(
        count=n,
        width=width,
        height=height,
        duration_us=round(duration_s * 1e6),
        radius_px=radius,
        speed_px_s=(0.4 * speed, speed),
        noise_hz=noise_hz,
        seed=seed,
    )
    return Scene(layout, name="timing", seed=seed)


_CORNERS = {"slow": (120.0, 0.5), "fast": (700.0, 0.5), "noisy": (300.0, 8.0)}


def corners(
    kind: Literal["slow", "fast", "noisy"] = "slow",
    width: int = 346,
    height: int = 260,
    seed: int = 0,
    *,
    duration_s: float = 1.0,
) -> Scene:
    """8 turning objects of radius 12 to 26 px, whose corners `Scene.vertices` knows.

    Parameters
    ----------
    kind : {"slow", "fast", "noisy"}
        Up to 120 px/s; up to 700 px/s; up to 300 px/s with 8 Hz/px of noise.
    width, height : int
        Of the sensor, px.
    seed : int
        0 <= seed < 2**64.
    duration_s : float
        A multiple of 250 us.

    Raises
    ------
    ValueError
        An argument is out of its range; the message names it.
    """
    if kind not in _CORNERS:
        raise ValueError(f"kind = {kind!r}: give one of {', '.join(_CORNERS)}")
    speed, noise_hz = _CORNERS[kind]
    scene = timing(
        8, width, height, speed, (12.0, 26.0), seed, noise_hz=noise_hz, duration_s=duration_s
    )
    scene.name = f"corners_{kind}"
    return scene


def stop_and_go(
    gap_ms: float = 300.0,
    *,
    speed: float = 150.0,
    radius: float = 8.0,
    noise_hz: float = 0.5,
    seed: int = 0,
) -> Scene:
    """One object that moves for 0.7 s, stands still for the gap, and moves on for 0.7 s.

    Parameters
    ----------
    gap_ms : float
        0 to 10000 ms; rounded down to steps of 0.25 ms.
    speed, radius : float
        20 to 1000 px/s, 2 to 20 px.
    noise_hz : float
        Background events per second and pixel.
    seed : int
        Decides on the kind of shape, its place and its direction.

    Raises
    ------
    ValueError
        An argument is out of its range; the message names it.
    """
    layout = _core.SceneLayout.stop_and_go(
        gap_us=_gap_us(gap_ms), speed_px_s=speed, radius_px=radius, noise_hz=noise_hz, seed=seed
    )
    return Scene(layout, name="stop_and_go", seed=seed)


def occlusion(
    gap_ms: float = 300.0,
    *,
    speed: float = 150.0,
    radius: float = 8.0,
    noise_hz: float = 0.5,
    seed: int = 0,
) -> Scene:
    """Object 0 crosses the view; object 1, a bright square at rest, hides it for the gap.

    Parameters
    ----------
    gap_ms : float
        Least time without an event of object 0, ms; 0 to what a square of half the view can hide.
    speed, radius : float
        20 to 1000 px/s, 2 to 20 px.
    noise_hz : float
        Background events per second and pixel.
    seed : int
        Decides on the kind of shape, its height in the view and its direction.

    Raises
    ------
    ValueError
        An argument is out of its range; the message names it.
    """
    layout = _core.SceneLayout.occlusion(
        gap_us=_gap_us(gap_ms), speed_px_s=speed, radius_px=radius, noise_hz=noise_hz, seed=seed
    )
    return Scene(layout, name="occlusion", seed=seed)


def _gap_us(gap_ms: float) -> int:
    if not 0 <= gap_ms <= 10_000:
        raise ValueError(f"gap_ms = {gap_ms}: give 0 to 10000 ms")
    return round(gap_ms * 1e3)
