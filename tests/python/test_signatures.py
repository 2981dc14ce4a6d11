"""inspect.signature of every public class: the names and defaults of its constructor."""

from __future__ import annotations

import inspect
from typing import Any

import pytest

import asap

PUBLIC = [name for name in asap.__all__ if isinstance(getattr(asap, name), type)]
CLASSES = [name for name in PUBLIC if not issubclass(getattr(asap, name), Exception)]
MADE = [
    asap.GammaFilter(),
    asap.LinearCost(100, 300),
    asap.ClusterTracker(20, 10),
    asap.ClusterTracker(20, 10, engine="compat"),
    asap.FeatureTracker(20, 10),
    asap.EventImage(20, 10, count=5),
    *(
        kind(20, 10)
        for kind in (
            *(asap.BackgroundActivityFilter, asap.HotPixelMask, asap.EFast, asap.ArcStar),
            *(asap.EHarris, asap.FAHarris, asap.ThresholdOrdinalSurface),
            *(asap.SpeedInvariantTimeSurface, asap.PlaneFlow),
        )
    ),
]


@pytest.mark.parametrize("name", CLASSES)
def test_every_public_class_has_one(name: str) -> None:
    arguments = inspect.signature(getattr(asap, name)).parameters
    unnamed = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)
    assert name == "Scheme" or not [one for one in arguments.values() if one.kind in unnamed]


@pytest.mark.parametrize("made", MADE, ids=lambda made: type(made).__name__)
def test_it_has_the_parameters_of_an_object(made: Any) -> None:
    arguments = inspect.signature(type(made)).parameters
    sides = [name for name in ("width", "height") if hasattr(made, name)]
    assert list(arguments)[: len(sides)] == sides
    assert set(made.parameters) <= set(arguments)
    given = {"engine": "compat", "count": 5, "alpha_us": 100, "beta_ns": 300}
    for name, value in made.parameters.items():
        if value != given.get(name):
            default = arguments[name].default
            assert type(value)(default) == value, name
