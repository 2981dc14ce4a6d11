"""Schemes and algorithms: ours by name, the user's own by ``package.module:name``."""

from __future__ import annotations

import argparse
import importlib
import os
import sys
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from operator import attrgetter
from typing import Any

import asap
from asap import _checks, _core
from asap.cli.outcome import CHECK_FAILED, USAGE, Failure

SCHEMES = {kind().name: kind for kind in _core.SCHEMES}
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

Setting = tuple[str, int | float | str]


def setting(text: str) -> Setting:
    """Parse NAME=VALUE; the scheme itself refuses what it does not take."""
    name, equals, value = text.partition("=")
    if not (name and equals):
        raise argparse.ArgumentTypeError(f"{text}: write NAME=VALUE")
    for kind in (int, float):
        try:
            return name, kind(value)
        except ValueError:
            pass
    return name, value


def scheme_of(name: str | None, settings: Sequence[Setting]) -> asap.Scheme | None:
    """Make the scheme with its parameters; None leaves the choice to the library."""
    if name is None and not settings:
        return None
    return SCHEMES[name or "deadline"](**dict(settings))


def algorithm_name(text: str) -> str:
    """Refuse what is neither one of ours by name nor ``package.module:name``."""
    module, colon, name = text.partition(":")
    if not (module and name if colon else text in ALGORITHMS):
        known = ", ".join(sorted(ALGORITHMS))
        raise argparse.ArgumentTypeError(f"{text}: give one of {known}, or package.module:name")
    return text


def algorithm_of(name: str, recording: asap.Recording | asap.Camera) -> Any:
    """Make the algorithm for the sensor of a source; import it if it is the user's own."""
    found = _imported(name) if ":" in name else getattr(asap, ALGORITHMS[name])
    if ":" in name and not isinstance(found, type):
        return found
    width, height = recording.width, recording.height
    if not (width and height):
        raise Failure(
            USAGE,
            f"{getattr(recording, 'path', recording)}: sensor = unknown: {name} needs its size. "
            "Give --width and --height; asap info shows how far the events reach",
        )
    try:
        return found(width, height)
    except Exception as error:
        if ":" not in name:
            raise
        raise _failed(USAGE, name) from error


def _imported(spec: str) -> Any:
    """Import ``package.module:name``, the current directory first; the name may have dots."""
    module, _, name = spec.partition(":")
    here = os.getcwd()
    if not getattr(sys.flags, "safe_path", False) and sys.path[:1] not in ([here], [""]):
        sys.path.insert(0, here)  # stays: the module may import later
    try:
        found = attrgetter(name)(importlib.import_module(module))
        if not isinstance(found, type):
            _checks.worker("algorithm", found)
    except Exception as error:
        raise _failed(USAGE, spec) from error
    return found


@contextmanager
def own_code(spec: str) -> Iterator[None]:
    """Show the traceback of an error that passed the user's own module; others are not its."""
    package = spec.partition(":")[0].partition(".")[0]
    try:
        yield
    except Exception as error:
        frames = (frame for frame, _ in traceback.walk_tb(error.__traceback__))
        passed = {str(frame.f_globals.get("__name__")).partition(".")[0] for frame in frames}
        if package not in passed - {"asap"}:
            raise
        raise _failed(CHECK_FAILED, spec) from error


def _failed(code: int, spec: str) -> Failure:
    return Failure(code, f"--algorithm {spec} failed:\n{traceback.format_exc().rstrip()}")
