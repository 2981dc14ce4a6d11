"""ASAP: events of an event camera to the algorithm as soon as possible, never overflowing it.

`run` replays a recording in real time, `simulate` runs it in virtual time; both return a `Run`.
The scheme and the first algorithm are those of Tapia et al., ASAP (ICRA workshop 2020).
"""

from __future__ import annotations

import importlib
from typing import Any

from asap._core import (
    Asap2020,
    ClusterTracker,
    FixedSize,
    FixedTime,
    GammaFilter,
    Greedy,
    LinearCost,
    Scheme,
    SingleEvent,
    __version__,
)
from asap.events import EVENT_DTYPE, as_events
from asap.experiment import Run, last_run, load_run, run, simulate
from asap.io import Recording, load, read

__all__ = [
    "EVENT_DTYPE",
    "Asap2020",
    "ClusterTracker",
    "FixedSize",
    "FixedTime",
    "GammaFilter",
    "Greedy",
    "LinearCost",
    "Recording",
    "Run",
    "Scheme",
    "SingleEvent",
    "__version__",
    "analysis",
    "as_events",
    "last_run",
    "load",
    "load_run",
    "plots",
    "read",
    "report",
    "run",
    "simulate",
    "synthetic",
]

_MODULES = ("analysis", "plots", "report", "synthetic")  # imported when they are first used


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return importlib.import_module(f"asap.{name}")
    raise AttributeError(f"module 'asap' has no attribute {name!r}")
