"""Schemes and algorithms by name, and their parameters as NAME=VALUE."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

import asap
from asap import _core
from asap.cli.imported import imported
from asap.cli.outcome import USAGE, Failure
from asap.cli.parser import hint

_SCHEMES = {kind().name: kind.__name__ for kind in _core.SCHEMES}
ALGORITHMS = {
    "clusters": "ClusterTracker",
    "baf": "BackgroundActivityFilter",
    "hot_pixels": "HotPixelMask",
    "e_fast": "EFast",
    "arc_star": "ArcStar",
    "e_harris": "EHarris",
    "fa_harris": "FAHarris",
    "tos": "ThresholdOrdinalSurface",
    "sits": "SpeedInvariantTimeSurface",
    "flow": "PlaneFlow",
}


def schemes() -> list[str]:
    """Names of the schemes that this version has."""
    return [name for name, attribute in _SCHEMES.items() if hasattr(asap, attribute)]


def scheme_of(name: str | None, settings: Sequence[str]) -> asap.Scheme | None:
    """Make the scheme with its NAME=VALUE parameters; None leaves the choice to the library."""
    if name is None:
        if not settings:
            return None
        name = "deadline"
    make = getattr(asap, _SCHEMES[name])
    defaults = make().parameters
    scheme: asap.Scheme = make(**dict(_setting(text, name, defaults) for text in settings))
    return scheme


def _setting(text: str, scheme: str, defaults: dict[str, Any]) -> tuple[str, Any]:
    name, equals, value = text.partition("=")
    if not equals:
        raise Failure(USAGE, f"--set {text}: write NAME=VALUE")
    if name not in defaults:
        raise Failure(USAGE, f"--set {text}: {scheme} has no {name}; {_near(name, defaults)}")
    if isinstance(defaults[name], str):
        return name, value
    try:
        number = float(value)
    except ValueError as error:
        raise Failure(USAGE, f"--set {text}: {value!r} is not a number") from error
    if not isinstance(defaults[name], int):
        return name, number
    if not number.is_integer():
        raise Failure(USAGE, f"--set {text}: {name} takes a whole number")
    return name, int(number)


def _near(name: str, known: dict[str, Any]) -> str:
    return hint(name, known, "it has") if known else "it has no parameters"


def algorithm_name(text: str) -> str:
    """Refuse what is neither one of ours by name nor ``package.module:name``."""
    if ":" not in text and text not in ALGORITHMS:
        near = hint(text, sorted(ALGORITHMS))
        raise argparse.ArgumentTypeError(
            f"invalid choice: {text!r}; {near} Your own is package.module:name"
            if near.endswith("?")
            else f"invalid choice: {text!r}; {near}, or give your own as package.module:name"
        )
    return text


def algorithm_of(name: str, recording: asap.Recording) -> Any:
    """Make the algorithm for the sensor of a recording; import it if it is the user's own."""
    if ":" in name:
        return imported(name, recording.width, recording.height)
    if not (recording.width and recording.height):
        raise Failure(
            USAGE,
            f"{recording.path}: sensor = unknown: {name} needs its size. "
            "Give --width and --height; asap info shows how far the events reach",
        )
    return getattr(asap, ALGORITHMS[name])(recording.width, recording.height)
