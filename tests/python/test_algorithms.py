"""What every algorithm of the library keeps: a table of algorithms and promises.

What each one finds: test_cluster_tracker.py, test_features.py, test_surfaces.py, and the rules in
tests/cpp.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest

import asap
from asap import _core
from golden import golden_stream
from threads import turns_meanwhile

WIDTH, HEIGHT = 346, 260
EVENTS = golden_stream()[:60_000]

Make = Callable[..., Any]  # of an algorithm, with every parameter at another value than its default
MADE: dict[str, tuple[Make, dict[str, Any]]] = {
    "clusters": (asap.ClusterTracker, {"confirm_events": 9.0, "support": "off", "slots": 64}),
    "published_clusters": (asap.PublishedClusterTracker, {"window": 300, "seed": 2**63}),
    "features": (
        asap.FeatureTracker,
        {"detector": "e_fast", "window": 50, "radius": 4, "min_neighbours": 0, "window_us": 9000},
    ),
    "background": (asap.BackgroundActivityFilter, {"window_us": 700}),
    "hot_pixels": (asap.HotPixelMask, {"pixels": [(3, 4), (0, 9)], "learn_events": 0}),
    "e_fast": (asap.EFast, {}),
    "arc_star": (asap.ArcStar, {"filter_us": 9}),
    "e_harris": (asap.EHarris, {"threshold": 2.5}),
    "fa_harris": (asap.FAHarris, {"filter_us": 3, "threshold": 0.25}),
    "tos": (asap.ThresholdOrdinalSurface, {"side": 5}),
    "sits": (asap.SpeedInvariantTimeSurface, {"radius": 3}),
    "flow": (asap.PlaneFlow, {"window_us": 900, "min_points": 9, "refit": False}),
    "motion": (asap.MotionSegmenter, {"window_us": 50_000, "min_px_s": 9.0, "min_share": 0.25}),
    "event_image": (asap.EventImage, {"count": 1000, "channels": ["on", "off"]}),
}


def test_every_algorithm_is_here_by_its_name() -> None:
    assert {name: kind for name, (kind, _) in MADE.items()} == {
        kind.name: kind for kind in _core.ALGORITHMS
    }


TILEABLE = ("background", "e_fast", "arc_star", "e_harris", "fa_harris", "tos", "flow")


@pytest.fixture(params=[*MADE, *(f"{name} tiled" for name in TILEABLE)])
def make(request: pytest.FixtureRequest) -> Make:
    """Make it with its defaults, as far as it has some."""
    name, _, tiled = request.param.partition(" ")
    if tiled:
        return partial(asap.Tiled, MADE[name][0], threads=3)
    kind, _ = MADE[name]
    return partial(kind, count=1000) if kind is asap.EventImage else kind


def outcome(algorithm: Any, *parts: np.ndarray) -> list[Any]:
    """Everything that a user sees of it after these events."""
    found = [algorithm.process(part) for part in parts]
    arrays = [one[0] if isinstance(one, tuple) else one for one in found if one is not None]
    seen = [np.concatenate(arrays).tolist()] if arrays else []
    for name in ("clusters", "tracks", "surface", "image", "pixels"):
        if hasattr(algorithm, name):
            seen.append(np.asarray(getattr(algorithm, name)).tolist())
    return seen


def same(one: list[Any], other: list[Any]) -> bool:
    return repr(one) == repr(other)  # NaN too


@pytest.mark.parametrize("bad", [-0.1, 1.1, float("nan")])
def test_keep_is_checked(make: Make, bad: float) -> None:
    algorithm = make(WIDTH, HEIGHT)
    for gamma in (0, 1):
        algorithm.set_gamma(gamma)
    with pytest.raises(ValueError, match="gamma = "):
        algorithm.set_gamma(bad)


def test_other_arrays_are_refused_and_read_only_ones_taken(make: Make) -> None:
    algorithm, events = make(WIDTH, HEIGHT), EVENTS[:100].copy()
    packed = np.zeros(100, [("x", "<u2"), ("y", "<u2"), ("p", "<i2"), ("t", "<i8")])
    for bad in (packed, events[::2], events.reshape(10, 10), events["x"]):
        with pytest.raises(TypeError, match="as_events"):
            algorithm.process(bad)
    for other in ({}, [], None, 5, "events.npy"):
        with pytest.raises(TypeError, match=r"^events = .*as_events\(\.\.\.\) makes one$"):
            algorithm.process(other)
    algorithm.process(asap.as_events(packed))
    events.flags.writeable = False
    algorithm.process(events)


def test_other_threads_run_meanwhile(make: Make) -> None:
    events, algorithm = np.tile(EVENTS, 40), make(WIDTH, HEIGHT)
    assert turns_meanwhile(lambda: algorithm.process(events)) > 2


def test_a_runner_takes_it_as_native_and_tells_it_what_is_kept(make: Make) -> None:
    alone, algorithm = make(WIDTH, HEIGHT), make(WIDTH, HEIGHT)
    run = asap.simulate(EVENTS[:20_000], cost=asap.LinearCost(0, 10), algorithm=algorithm)
    assert asap._core.is_native(algorithm)
    assert run.kept == 1 and run.algorithm is algorithm
    alone.process(EVENTS[:20_000])
    assert same(outcome(algorithm, EVENTS[:0]), outcome(alone, EVENTS[:0]))


@pytest.mark.parametrize("name", MADE)
def test_parameters_arrive_and_rebuild_it(name: str) -> None:
    kind, parameters = MADE[name]
    algorithm = kind(WIDTH, HEIGHT, **parameters)
    found = algorithm.parameters
    assert (algorithm.width, algorithm.height) == (WIDTH, HEIGHT)
    for key, value in parameters.items():
        assert np.array_equal(found[key], value), key
    assert asap.simulate(EVENTS[:0], cost=asap.LinearCost(1, 1), algorithm=algorithm)
    again = type(algorithm)(WIDTH, HEIGHT, **found)
    assert again.parameters == found
    assert eval(repr(algorithm), vars(asap).copy()).parameters == found


@pytest.mark.parametrize("name", MADE)
def test_parameters_are_keyword_only_and_named_when_unknown(name: str) -> None:
    kind, parameters = MADE[name]
    with pytest.raises(TypeError):
        kind(WIDTH, HEIGHT, *(parameters.values() or [1000]))
    with pytest.raises(TypeError, match="none_such"):
        kind(WIDTH, HEIGHT, none_such=1)


NAN = float("nan")
BAD: list[tuple[Make, dict[str, Any]]] = [
    (asap.ClusterTracker, {"slots": 0}),
    (asap.ClusterTracker, {"support": "of"}),
    (asap.PublishedClusterTracker, {"window": 0}),
    (asap.FeatureTracker, {"detector": "harris"}),
    (asap.FeatureTracker, {"window": 0}),
    (asap.FeatureTracker, {"radius": -1}),
    (asap.FeatureTracker, {"min_neighbours": 8}),
    (asap.FeatureTracker, {"window_us": -1}),
    (asap.FeatureTracker, {"velocity_us": 0}),
    (asap.BackgroundActivityFilter, {"window_us": -1}),
    (asap.BackgroundActivityFilter, {"window_us": 10**9}),
    (asap.ArcStar, {"filter_us": -1}),
    (asap.EHarris, {"threshold": float("inf")}),
    (asap.FAHarris, {"filter_us": -1}),
    (asap.FAHarris, {"threshold": NAN}),
    (asap.HotPixelMask, {"learn_events": -1}),
    (asap.ThresholdOrdinalSurface, {"side": 4}),
    (asap.SpeedInvariantTimeSurface, {"radius": 0}),
    (asap.PlaneFlow, {"window_us": 0}),
    (asap.PlaneFlow, {"min_points": 0}),
    (asap.MotionSegmenter, {"window_us": 0}),
    (asap.MotionSegmenter, {"min_px_s": NAN}),
    (asap.MotionSegmenter, {"min_share": -1}),
    (asap.EventImage, {"count": -1}),
]


@pytest.mark.parametrize(("kind", "bad"), BAD)
def test_a_bad_parameter_is_refused_by_name(kind: Make, bad: dict[str, Any]) -> None:
    ((name, value),) = bad.items()
    with pytest.raises(ValueError, match=f"^{name} = {re.escape(repr(value))}: "):
        kind(10, 10, **bad)


@pytest.mark.parametrize(("side", "value"), [("width", 0), ("height", -3), ("width", 10**9)])
def test_a_sensor_that_cannot_be_is_refused_by_name(make: Make, side: str, value: int) -> None:
    with pytest.raises(ValueError, match=f"^{side} = {value}: "):
        make(**{"width": 10, "height": 10, side: value})
