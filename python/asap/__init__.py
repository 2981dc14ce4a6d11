"""ASAP: events of an event camera to the algorithm as soon as possible, never overflowing it.

`run` replays a recording in real time, `simulate` runs it in virtual time; both return a `Run`.
The default scheme, `Deadline`, keeps a latency bound; `Asap2020` and the clustering are those of
Tapia et al., ASAP (ICRA workshop 2020).
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from asap._core import (
    ArcStar,
    Asap2020,
    Asap2022,
    BackgroundActivityFilter,
    ClusterTracker,
    DeadBeat,
    Deadline,
    EFast,
    EHarris,
    EventImage,
    FAHarris,
    FeatureTracker,
    FixedSize,
    FixedTime,
    GammaFilter,
    Greedy,
    HotPixelMask,
    LinearCost,
    MotionSegmenter,
    PlaneFlow,
    PublishedClusterTracker,
    Scheme,
    SingleEvent,
    SpeedInvariantTimeSurface,
    ThresholdOrdinalSurface,
    __version__,
)
from asap.events import EVENT_DTYPE, as_events, to_dtype
from asap.io import Recording, load, read

__all__ = [
    "EVENT_DTYPE",
    "ArcStar",
    "Asap2020",
    "Asap2022",
    "BackgroundActivityFilter",
    "Camera",
    "CameraError",
    "ClusterTracker",
    "Comparison",
    "DeadBeat",
    "Deadline",
    "EFast",
    "EHarris",
    "EventImage",
    "FAHarris",
    "FeatureTracker",
    "FixedSize",
    "FixedTime",
    "GammaFilter",
    "Greedy",
    "HotPixelMask",
    "Inspection",
    "LinearCost",
    "MotionSegmenter",
    "Pipeline",
    "PlaneFlow",
    "PublishedClusterTracker",
    "Recording",
    "Run",
    "Scheme",
    "SingleEvent",
    "SoftwareCamera",
    "SpeedInvariantTimeSurface",
    "ThresholdOrdinalSurface",
    "Tiled",
    "Tracks",
    "__version__",
    "analysis",
    "as_events",
    "cameras",
    "check",
    "compare",
    "convert",
    "info",
    "last_run",
    "load",
    "load_run",
    "open_camera",
    "oracle",
    "plots",
    "read",
    "record",
    "run",
    "simulate",
    "synthetic",
    "table",
    "to_dtype",
    "view",
]

# Imported when they are first used: modules, and names by the module that they are in.
_MODULES = ("analysis", "plots", "synthetic")
_NAMES = {
    name: home
    for home, names in {
        "camera": "Camera CameraError SoftwareCamera cameras open_camera record",
        # map is not in __all__: `import *` leaves Python its own
        "experiment": "Comparison Pipeline Run Tracks compare last_run map oracle run simulate",
        "inspection": "Inspection check info",
        "io.conversion": "convert",
        "results": "load_run table",
        "tiled": "Tiled",
        "viewer": "view",
    }.items()
    for name in names.split()
}

if TYPE_CHECKING:
    from asap import analysis, plots, synthetic
    from asap.camera import Camera, CameraError, SoftwareCamera, cameras, open_camera, record
    from asap.experiment import (
        Comparison,
        Pipeline,
        Run,
        Tracks,
        compare,
        last_run,
        oracle,
        run,
        simulate,
    )
    from asap.experiment import map as map
    from asap.inspection import Inspection, check, info
    from asap.io.conversion import convert
    from asap.results import load_run, table
    from asap.tiled import Tiled
    from asap.viewer import view
else:  # a type checker would take any name for one of a module that has a __getattr__

    def __getattr__(name: str) -> Any:
        if name in _MODULES:
            return importlib.import_module(f"asap.{name}")
        if name in _NAMES:
            value = getattr(importlib.import_module(f"asap.{_NAMES[name]}"), name)
            globals()[name] = value  # found here from now on
            return value
        raise AttributeError(f"module 'asap' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*__all__, *_NAMES})
