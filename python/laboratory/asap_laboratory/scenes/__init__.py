"""Scenes with truth: shapes that move before a camera, and what every event belongs to.

By these trackers are judged. `A` to `O` are named and fixed but for their seed; `timing`,
`corners`, `stop_and_go` and `occlusion` take parameters. The same arguments give the same events on
every machine; they are made natively, when they are first touched. An argument out of its range is
a ValueError that names it. `labelled` opens a real recording with boxes.

Shapes (disk, square, rectangle, triangle, star in turn; dark and bright in turn) move in steps of
250 us before an even ground. A pixel sees the log of its brightness, has thresholds of its own
around 0.25, and is blind for 0.3 ms after an event; background noise is independent of all that.

Limits, to be stated wherever results are shown: motion is quantised at 0.25 ms; there is no lens
and no bandwidth. In `A` to `G` edges are of one contrast, shapes small and rigid, and the ground is
at rest; `H` to `K` have large, hollow, textured and waving objects and a moving ground, `L` to `O`
what recordings show: sparse objects, one that comes near, lamps and hot pixels, a fence.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

from asap import _checks
from asap_laboratory.scenes.labelled import LabelledScene, labelled
from asap_laboratory.scenes.scene import CORNER_DTYPE, TRUTH_DTYPE, Scene

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
    "H",
    "I",
    "J",
    "K",
    "L",
    "LabelledScene",
    "M",
    "N",
    "O",
    "Scene",
    "corners",
    "labelled",
    "occlusion",
    "stop_and_go",
    "timing",
]


_LARGE = ("bars", "angles", "rings")

_MADE: dict[str, tuple[str, dict[str, Any], str]] = {  # kind of layout, its parameters, what it is
    "A": (
        *("named", {"name": "A"}),
        "20 objects on small orbits, 60 to 120 px/s; 346 x 260 px, 1.5 s, 0.5 Hz/px of noise.",
    ),
    "B": ("named", {"name": "B"}, "As `A`, but 10 to 400 px/s."),
    "C": (
        *("named", {"name": "C"}),
        "8 objects that cross each other, 80 to 200 px/s; 346 x 260 px, 2 s, 0.5 Hz/px of noise.",
    ),
    "D": ("named", {"name": "D"}, "As `A`, with 5 Hz/px of noise: two thirds of the events."),
    "E": ("named", {"name": "E"}, "As `C`, a little smaller, on 240 x 180 px: more crossings."),
    "F": (
        *("named", {"name": "F"}),
        "8 objects of very different size and speed: radius 3 to 20 px, 20 to 600 px/s; 2 s.",
    ),
    "G": (
        *("named", {"name": "G"}),
        "30 objects of radius 6 to 14 px, up to 250 px/s; 640 x 480 px, 2 s, 2 Hz/px of noise.",
    ),
    "I": (
        *("large_disks", {}),
        "6 disks of radius 14 to 34 px, plain and textured, 60 to 200 px/s; 346 x 260 px, 2 s.",
    ),
    "J": (
        *("hands", {}),
        "2 hands, palms of 55 px with five waving fingers, 50 to 200 px/s; 346 x 260 px, 2 s.",
    ),
    "K": (
        *("moving_camera", {}),
        "2 or 3 movers of 10 to 40 px before a texture that turns, zooms and shifts, labelled -1.",
    ),
    "L": (
        *("sparse", {}),
        "3 objects of 40 to 130 px and 2 to 10 kev/s; 346 x 260 px, 2 s, up to 0.5 Hz/px of noise.",
    ),
    "M": (
        *("approaching", {}),
        "One grows from 10 to 100 px in 1 to 1.8 s, 2 or 3 are small; 346 x 260 px, 2 s.",
    ),
    "N": (
        *("lamps", {}),
        "4 small objects beside lamps and hot pixels, which are noise; 346 x 260 px, 2 s.",
    ),
    "O": (
        *("fence", {}),
        "A ball of radius 15 to 40 px behind wires, which cause no event; 346 x 260 px, 2 s.",
    ),
}


def _named(label: str) -> Callable[..., Scene]:
    kind, parameters, words = _MADE[label]

    def make(seed: int = 0) -> Scene:
        return Scene._of(kind, label=label, seed=seed, **parameters)

    make.__name__ = make.__qualname__ = label
    make.__doc__ = words
    return make


A, B, C, D, E, F, G, I, J, K, L, M, N, O = map(_named, "ABCDEFGIJKLMNO")  # noqa: E741


def H(seed: int = 0, *, kind: Literal["bars", "angles", "rings"] | None = None) -> Scene:
    """6 large thin or hollow objects that turn, 60 to 400 px/s; 240 x 180 px, 2 s.

    Parameters
    ----------
    seed : int
        0 <= seed < 2**64.
    kind : {"bars", "angles", "rings"}, optional
        Bars of 60 to 90 by 8 to 14 px, L shapes with arms of 40 px, or rings of radius 14 to 30 px;
        by default two of each. 1 Hz/px of noise, as in `I`, `J` and `K`.
    """
    if kind is not None:
        _checks.choice("kind", kind, _LARGE)
    kinds = list(_LARGE) if kind is None else [kind]
    label = "H" if kind is None else f"H_{kind}"
    return Scene._of("large_shapes", label=label, kinds=kinds, seed=seed)


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
    """
    _checks.whole("n", n, 0, 10_000, "give 0 to 10000")
    for name, side in (("width", width), ("height", height)):
        _checks.whole(name, side, 16, 8192, "give 16 to 8192 px")
    ends = _checks.listed("radius", radius)
    _checks.require(len(ends) == 2, "radius", radius, "give two numbers, from and to, px")
    for end in ends:
        _checks.number("radius", end, 1, 8192, "give at least 1 px")
    _checks.require(ends[0] <= ends[1], "radius", radius, "give the smaller one first")
    speed = _checks.number("speed", speed, 0, 2000, "give 0 to 2000 px/s")
    _checks.number("duration_s", duration_s, 0.01, 86_400, "give 0.01 to 86400 s")
    return Scene._of(
        "free_shapes",
        label="timing",
        count=n,
        width=width,
        height=height,
        duration_us=round(float(duration_s) * 1e6),
        radius_px=(ends[0], ends[1]),
        speed_px_s=(0.4 * speed, speed),
        noise_hz=noise_hz,
        seed=seed,
    )


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
    """
    _checks.choice("kind", kind, _CORNERS)
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
    """
    return _one_object("stop_and_go", gap_ms, speed, radius, noise_hz, seed)


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
        Least time that object 0 is hidden, ms; 0 to what a square of half the view can hide.
    speed, radius, noise_hz, seed
        As for `stop_and_go`.
    """
    return _one_object("occlusion", gap_ms, speed, radius, noise_hz, seed)


def _one_object(
    kind: str, gap_ms: float, speed: float, radius: float, noise_hz: float, seed: int
) -> Scene:
    _checks.number("gap_ms", gap_ms, 0, 10_000, "give 0 to 10000 ms")
    _checks.number("speed", speed, 20, 1000, "give 20 to 1000 px/s")
    _checks.number("radius", radius, 2, 20, "give 2 to 20 px")
    return Scene._of(
        kind,
        label=kind,
        gap_us=round(float(gap_ms) * 1e3),
        speed_px_s=speed,
        radius_px=radius,
        noise_hz=noise_hz,
        seed=seed,
    )
