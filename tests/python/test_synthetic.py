from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

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


def rates_hz(events: np.ndarray, window_us: int) -> np.ndarray:
    return np.bincount(events["t"] // window_us) * (1e6 / window_us)


def same(left: np.ndarray, right: np.ndarray) -> bool:
    return all(np.array_equal(left[field], right[field]) for field in "xypt")


@pytest.fixture(scope="module")
def flight() -> np.ndarray:
    return FlightOverChairs().events()


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


def test_shaken_pattern_climbs_over_the_papers_rate_bound() -> None:
    counts = np.zeros(50)
    for events in ShakenPattern():
        np.add.at(counts, events["t"] // 100_000, 1)
    rates = counts / 0.1
    assert 0.05e6 < rates[0] < 0.2e6
    assert rates[-1] > 12e6
    assert 24e6 < counts.sum() < 30e6
    assert np.all(np.diff(rates[::5]) > 0)


def test_flight_stays_below_the_papers_rate_bound(flight: np.ndarray) -> None:
    assert rates_hz(flight, 10_000).max() < 5e6
    halves = rates_hz(flight, 500_000)
    assert halves[0] < 0.2e6
    assert halves[-1] == pytest.approx(1.8e6, rel=0.2)
    assert np.all(np.diff(halves) > 0)


@settings(max_examples=25)
@given(
    scene=st.sampled_from(SCENES),
    seed=st.integers(0, 2**64 - 1),
    width=st.integers(16, 400),
    height=st.integers(16, 400),
    t0_us=st.integers(-(2**62), 2**62),
    duration_s=st.floats(0.01, 0.05),
)
def test_streams_are_ordered_and_inside(
    scene: Any, seed: int, width: int, height: int, t0_us: int, duration_s: float
) -> None:
    extra = {"chair_px": 8.0} if scene is FlightOverChairs else {"first_rate_hz": 1e3}
    events = scene(
        seed=seed,
        width=width,
        height=height,
        t0_us=t0_us,
        duration_s=duration_s,
        last_rate_hz=50.0 * width * height,
        **extra,
    ).events()
    assert np.all(np.diff(events["t"]) >= 0)
    assert np.all((events["x"] < width) & (events["y"] < height))
    assert np.all((events["p"] == 0) | (events["p"] == 1))
    assert np.all(events["t"] >= t0_us)
    assert np.all(events["t"] < t0_us + round(duration_s * 1e6))


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
