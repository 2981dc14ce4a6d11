"""The trackers that are compared, and what they cost on the same events."""

from __future__ import annotations

import statistics
import time
from typing import Any

from asap import _core
from asap_laboratory import _native
from asap_laboratory.accuracy import RUNGS, Maker, Rung
from asap_laboratory.scoring.trace import HasEvents

OURS = "ClusterTracker"
_REPETITIONS = 3
_PACKAGE = 16_384  # events: large enough for the call not to count, small enough for the cache


def _frames(period_us: int, neighbours: int) -> Maker:
    def make(width: int, height: int) -> Any:
        from asap_laboratory.rivals.frames import FrameTracker  # scipy takes a while

        return FrameTracker(width, height, period_us=period_us, neighbours=neighbours)

    return make


_BAF = _core.BackgroundActivityFilter
RIVALS = {
    OURS: RUNGS[OURS],
    "frames 10 ms": Rung(_frames(10_000, neighbours=2)),
    "frames 20 ms": Rung(_frames(20_000, neighbours=3)),
    "published": RUNGS["published"],
    "BAF + published, steady": RUNGS["BAF + published, steady"],
    "jAER-type core": Rung(_native.JaerClusterTracker),
    "BAF + jAER-type core": Rung(_native.JaerClusterTracker, _BAF),
}
"""Ours with nothing in front, and every rival, by the label of the tables."""


def costs_ns(rungs: dict[str, Rung], scene: HasEvents) -> dict[str, float]:
    """Measure filter and tracker: median over the turns, ns of processor time per event.

    They take turns with the whole scene, so that what else the machine does meets all of them.
    """
    events = scene.events
    packages = [events[begin : begin + _PACKAGE] for begin in range(0, events.size, _PACKAGE)]
    turns: dict[str, list[float]] = {label: [] for label in rungs}
    for _ in range(_REPETITIONS):
        for label, rung in rungs.items():
            ns = _turn_ns(rung, scene, packages)
            turns[label].append(ns / max(events.size, 1))
    return {label: statistics.median(some) for label, some in turns.items()}


def _turn_ns(rung: Rung, scene: Any, packages: list[Any]) -> int:
    tracker, before = rung.made_for(scene)
    begin_ns = time.thread_time_ns()
    for package in packages:
        tracker.process(package if before is None else before.process(package), labels=False)
    return time.thread_time_ns() - begin_ns
