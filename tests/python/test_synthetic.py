from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from asap import EVENT_DTYPE
from asap.synthetic import FlightOverChairs, ShakenPattern, SyntheticStream

SCENES = [ShakenPattern, FlightOverChairs]


def fingerprint(events: np.ndarray) -> int:
    """The sum that the C++ tests compute in tests/cpp/synthetic/scene_checks.hpp."""

    def mix(z: np.ndarray) -> np.ndarray:
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        return z ^ (z >> np.uint64(31))

    x, y, p, t = (events[field].astype(np.uint64) for field in "xypt")
    place = x | y << np.uint64(16) | p << np.uint64(32)
    index = np.arange(len(events), dtype=np.uint64)
    return int(mix(mix(place ^ t << np.uint64(33)) + index).sum(dtype=np.uint64))


def same(left: np.ndarray, right: np.ndarray) -> bool:
    return all(np.array_equal(left[field], right[field]) for field in "xypt")


@pytest.mark.parametrize(
    ("stream", "golden"),
    [
        (ShakenPattern(seed=1), 8434657412468591069),
        (FlightOverChairs(seed=1), 17972684643795974826),
    ],
    ids=["shaken", "flight"],
)
def test_first_events_are_golden_here_as_in_cpp(stream: SyntheticStream, golden: int) -> None:
    first = np.empty(0, EVENT_DTYPE)
    for events in stream:
        first = np.append(first, events)
        if len(first) >= 100_000:
            break
    assert fingerprint(first[:100_000]) == golden


@pytest.mark.parametrize("scene", SCENES)
def test_every_iteration_starts_anew(scene: Any) -> None:
    stream = scene(duration_s=0.5, seed=3)
    first = iter(stream)
    next(first)
    again = stream.events()
    assert again.dtype == EVENT_DTYPE
    assert same(again, np.concatenate(list(stream)))
    assert same(again, scene(duration_s=0.5, seed=3).events())
    assert not np.array_equal(again["t"][:1000], scene(duration_s=0.5, seed=4).events()["t"][:1000])


@pytest.mark.parametrize(
    ("scene", "parameters", "message"),
    [
        (ShakenPattern, {"duration_s": 0.0}, "duration_s = 0.0: give"),
        (ShakenPattern, {"duration_s": float("nan")}, "duration_s = nan: give"),
        (ShakenPattern, {"duration_s": float("inf")}, "duration_s = inf: give"),
        (ShakenPattern, {"seed": -1}, "seed = -1: give"),
        (ShakenPattern, {"seed": 2**64}, "seed = 18446744073709551616: give"),
        (ShakenPattern, {"width": 0}, "width = 0: give"),
        (ShakenPattern, {"first_rate_hz": 2e7}, "first_rate_hz = 2.*: give"),
        (ShakenPattern, {"last_rate_hz": 1e9}, "last_rate_hz = 1.*: give"),
        (ShakenPattern, {"amplitude_px": 0.0}, "amplitude_px = 0.*: give"),
        (FlightOverChairs, {"height": 9000}, "height = 9000: give"),
        (FlightOverChairs, {"last_rate_hz": -1.0}, "last_rate_hz = -1.*: give"),
        (FlightOverChairs, {"chair_px": 200.0}, "chair_px = 200.*: give"),
        (FlightOverChairs, {"noise_hz": -0.5}, "noise_hz = -0.5.*: give"),
    ],
)
def test_bad_parameters_are_named(scene: Any, parameters: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=f"^{message}"):
        scene(**parameters)
