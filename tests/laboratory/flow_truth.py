"""True flow of recordings and scenes, and how far from it PlaneFlow is.

`python tests/laboratory/flow_truth.py` prints the tables of notebooks/algorithms/motion.md. The
constants were chosen on the first halves of the recordings and on the seeds 0 to 2; the tables are
of the second halves and of the seeds 100 to 119.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import asap
from asap_laboratory import scenes
from event_files import recording

Vectors = NDArray[np.float64]
RULES: dict[str, bool | None] = {"default": None, "published": True, "plain": False}


class Judged(NamedTuple):
    """Events, the events to judge, and what is known of the edge below each of these."""

    events: NDArray[np.void]
    width: int
    height: int
    counts: NDArray[np.bool_]
    #: True normal flow, px/s. Where only the velocity is known: that, see `along_velocity`.
    truth: Vectors


def rotating_pipe(begin_us: int = 750_000, end_us: int = 1_500_000) -> Judged:
    """A bar turns about a point: the normal flow along its edges is analytic."""
    folder = recording("labelled") / "rotating_pipe"
    with np.load(folder / "events.npz") as stored:
        events = asap.as_events({name: stored[name] for name in "txyp"})
    rows = np.genfromtxt(folder / "truth.csv", delimiter=",", names=True)
    theta, omega = (
        np.interp(events["t"], rows["t_us"], rows[name]) for name in ("theta_rad", "omega_rad_s")
    )
    from_axis = np.stack([events["x"] - 147.19, events["y"] - 126.43], 1)
    along = np.stack([np.cos(theta), np.sin(theta)], 1)
    across = np.stack([-np.sin(theta), np.cos(theta)], 1)
    radius = (from_axis * along).sum(1)
    distance = abs((from_axis * across).sum(1))
    on_edge = (distance > 6.2) & (distance < 11.2) & (abs(radius) > 15)
    in_time = (events["t"] >= begin_us) & (events["t"] < end_us)
    return Judged(events, 304, 240, on_edge & in_time, (omega * radius)[:, None] * across)


def disk(seed: int, noise_hz: float = 5.0) -> Judged:
    """A disk of radius 20 px, 160 to 400 px/s; the rim that moves along itself is not judged."""
    radius = 20.0
    scene = scenes.timing(
        1, 160, 160, 400, (radius, radius), seed, noise_hz=noise_hz, duration_s=0.2
    )
    events = scene.events
    times = np.arange(0, scene.duration_us, 1000)
    states = np.concatenate([scene.truth(t) for t in times])
    x, y, vx, vy = (np.interp(events["t"], times, states[name]) for name in ("x", "y", "vx", "vy"))
    from_centre = np.stack([events["x"] - x, events["y"] - y], 1)
    distance = np.hypot(*from_centre.T)
    normal = from_centre / distance[:, None]
    speed = vx * normal[:, 0] + vy * normal[:, 1]
    on_rim = (np.asarray(scene.labels) >= 0) & (abs(distance - radius) < 2.5)
    moving = abs(speed) > 0.2 * np.hypot(vx, vy)
    return Judged(events, 160, 160, on_rim & moving, speed[:, None] * normal)


def slider(begin_us: int = 95_000, end_us: int = 171_000) -> Judged:
    """A camera on a slider: of three planes the velocity at which their image is sharpest.

    The slider accelerates: that is found at the same time. Before 20 ms it has hardly begun.
    """
    events = asap.load(recording("text/slider_davis240.txt"), width=240, height=180)
    moving = events["t"] >= 20_000
    planes = [
        moving & inside(events, *box)
        for box in ((150, 240, 0, 80), (115, 160, 55, 140), (0, 40, 85, 150))
    ]

    def scale(acceleration: float) -> Vectors:
        """Return the slider's speed over that at 95 ms."""
        return 1 + acceleration * (events["t"] - 95_000) / 1e6

    def sharpest(acceleration: float) -> list[tuple[float, float]]:
        way = (1 + scale(acceleration)) / 2 * (events["t"] - 95_000) / 1e6
        return [
            max((sharpness(events[plane], v * way[plane]), v) for v in -np.geomspace(30, 200, 60))
            for plane in planes
        ]

    acceleration = max(np.arange(0, 5.5, 0.5), key=lambda a: sum(s for s, _ in sharpest(a)))
    velocity = np.full(len(events), np.nan)
    for plane, (_, v) in zip(planes, sharpest(acceleration), strict=True):
        velocity[plane] = v
    counts = np.isfinite(velocity) & (events["t"] >= begin_us) & (events["t"] < end_us)
    truth = np.stack([velocity * scale(acceleration), np.zeros(len(events))], 1)
    return Judged(events, 240, 180, counts, truth)


def inside(events: NDArray[np.void], x0: int, x1: int, y0: int, y1: int) -> NDArray[np.bool_]:
    """Whether the events lie in a box, px, half-open."""
    x, y = events["x"], events["y"]
    return (x0 <= x) & (x < x1) & (y0 <= y) & (y < y1)


def sharpness(events: NDArray[np.void], shift_px: Vectors) -> float:
    """Return the energy of the image of the events, moved back along x."""
    x = events["x"] - shift_px + 60
    left = np.floor(x).astype(np.int64)
    sign = np.where(events["p"] > 0, 1.0, -1.0)
    pixel = events["y"].astype(np.int64) * 400 + left
    image = np.bincount(pixel, sign * (left + 1 - x), 180 * 400)
    image += np.bincount(pixel + 1, sign * (x - left), 180 * 400)
    return float((image**2).sum())


def flow_of(judged: Judged, **parameters: Any) -> tuple[Vectors, Vectors]:
    """Return found and true flow of the events that count; NaN where none is found."""
    flow = asap.PlaneFlow(judged.width, judged.height, **parameters).process(judged.events)
    return flow[judged.counts].astype(np.float64), judged.truth[judged.counts]


def errors(judged: Judged, **parameters: Any) -> dict[str, float]:
    """Score against a normal flow that is known in full.

    ``flow``, the share of the events with a flow; medians of the ``angle`` in degrees and of the
    relative error of the ``speed``; ``wrong``, the share more than 90 degrees off.
    """
    found, true = flow_of(judged, **parameters)
    known = np.isfinite(found[:, 0])
    found, true = found[known], true[known]
    speed, right = np.hypot(*found.T), np.hypot(*true.T)
    angle = np.degrees(np.arccos(np.clip((found * true).sum(1) / (speed * right), -1, 1)))
    return {
        "flow": known.mean(),
        "angle": np.median(angle),
        "speed": np.median(abs(speed - right) / right),
        "wrong": np.mean(angle > 90),
    }


def along_velocity(judged: Judged, **parameters: Any) -> dict[str, float]:
    """Score against the velocity of the plane below, whose part along the found normal is true.

    ``flow`` as above; medians of ``ratio``, the speed over the true normal speed, and of
    ``residual``, its error over the speed of the plane; ``wrong``, the share of the wrong sign.
    """
    found, velocity = flow_of(judged, **parameters)
    known = np.isfinite(found[:, 0])
    found, velocity = found[known], velocity[known]
    speed = np.hypot(*found.T)
    true = (found * velocity).sum(1) / speed
    return {
        "flow": known.mean(),
        "ratio": np.median(speed / abs(true)),
        "residual": np.median(abs(speed - true) / np.hypot(*velocity.T)),
        "wrong": np.mean(true < 0),
    }


def line(name: str, figures: dict[str, float]) -> str:
    """Return a row of a table."""
    return " | ".join([name, *(f"{key} {value:.3f}" for key, value in figures.items())])


def main() -> None:
    """Print the tables."""
    scores: list[tuple[str, list[Judged], Callable[..., dict[str, float]]]] = [
        ("slider", [slider()], along_velocity),
        ("rotating pipe", [rotating_pipe()], errors),
        ("disks, 5 Hz/px", [disk(seed) for seed in range(100, 120)], errors),
    ]
    for name, cases, score in scores:
        for rule, refit in RULES.items():
            all_of_them = [score(case, refit=refit) for case in cases]
            mean = {
                key: math.fsum(one[key] for one in all_of_them) / len(cases)
                for key in all_of_them[0]
            }
            print(line(f"{name}, {rule}", mean))


if __name__ == "__main__":
    main()
