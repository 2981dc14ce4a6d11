"""What is left of the accuracy when a scheme has decided what arrives, and when.

Told twice. *Delivered*: the algorithm is asked at every sample time after the last event before it
that the scheme let through, as `score` does; latency costs nothing. *In use*: it is asked what
it knows at that moment, which is what the packages have told it that were finished by then. The
truth is that of the moment in both. For a detector of corners: labels of the delivered events among
themselves; and of all events of the stream, where one that was not finished in time is no corner.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from asap.experiment import Run
from asap_laboratory.scoring import Scene
from asap_laboratory.scoring.corners import near_a_vertex
from asap_laboratory.scoring.matching import match
from asap_laboratory.scoring.measures import mota, ratio
from asap_laboratory.scoring.trace import (
    PERIOD_US,
    Sample,
    passed,
    sample_at,
    sample_times,
    snapshot_at,
)

_STEP_US = 1000


class Delivery(NamedTuple):
    """A package."""

    events: NDArray[np.void]
    gamma: float  #: the fraction that the algorithm was told
    done_us: float


class Used(NamedTuple):
    """Accuracy told twice: MOTA of a tracker, F of a detector."""

    delivered: float
    in_use: float


class Recorder:
    """An algorithm that only keeps what it gets."""

    def __init__(self) -> None:
        self._packages: list[tuple[NDArray[np.void], float]] = []
        self._gamma = 1.0

    def set_gamma(self, gamma: float) -> None:
        """Note what an algorithm would be told."""
        self._gamma = gamma

    def process(self, events: NDArray[np.void]) -> None:
        """Keep a package."""
        self._packages.append((events.copy(), self._gamma))

    def deliveries(self, run: Run) -> list[Delivery]:
        """Put the times of a run in virtual time to its packages."""
        rows = run.packages[run.packages["size"] > 0]
        done_us = (rows["start_us"] + rows["processing_us"]).tolist()
        return [
            Delivery(events, gamma, done)
            for (events, gamma), done in zip(self._packages, done_us, strict=True)
        ]


def everything(scene: Scene) -> list[Delivery]:
    """Return all events, each millisecond of them done at once."""
    stamps = scene.events["t"]
    cuts = np.searchsorted(stamps, np.arange(_STEP_US, int(stamps[-1]), _STEP_US))
    return [
        Delivery(events, 1.0, float(events["t"][-1]))
        for events in np.split(scene.events, cuts)
        if events.size
    ]


def tracker_accuracy(make: Callable[[], Any], scene: Scene, deliveries: Sequence[Delivery]) -> Used:
    """MOTA of a tracker that gets these packages."""
    return Used(
        _mota(make(), scene, _split_at(deliveries, sample_times(scene.events))),
        _mota(make(), scene, deliveries),
    )


def _mota(tracker: Any, scene: Any, deliveries: Sequence[Delivery]) -> float:
    samples = []
    following = 0
    for sample in samples_without_clusters(scene):
        while following < len(deliveries) and deliveries[following].done_us <= sample.t_us:
            if hasattr(tracker, "set_gamma"):
                tracker.set_gamma(deliveries[following].gamma)
            tracker.process(deliveries[following].events)
            following += 1
        samples.append(sample._replace(clusters=snapshot_at(tracker, sample.t_us)))
    return mota(match(samples)).mota


def _split_at(deliveries: Sequence[Delivery], times_us: Sequence[int]) -> list[Delivery]:
    """Cut packages at the sample times, as if each part were done with its last event."""
    parts = []
    for one in deliveries:
        stamps = one.events["t"]
        inside = [t for t in times_us if stamps[0] < t <= stamps[-1]]
        for events in np.split(one.events, np.searchsorted(stamps, inside)):
            if events.size:
                parts.append(Delivery(events, one.gamma, float(events["t"][-1]) + 0.5))
    return parts


@lru_cache(maxsize=1)
def samples_without_clusters(scene: Scene) -> list[Sample]:
    """Return what there is at every sample time; all events of the scene make an object active."""
    t_us, labels = scene.events["t"], np.asarray(scene.labels).astype(np.int64)
    times = sample_times(scene.events)
    begins, ends = (
        np.searchsorted(t_us, np.array(times, np.int64) - before) for before in (PERIOD_US, 0)
    )
    return [
        sample_at(scene, time_us, labels[begin:end])
        for time_us, begin, end in zip(times, begins.tolist(), ends.tolist(), strict=True)
    ]


def corner_accuracy(
    detector: Any, scene: Scene, deliveries: Sequence[Delivery], latency_us: float
) -> Used:
    """F of a detector that gets these packages."""
    called, in_time, events = [], [], []
    for one in deliveries:
        if hasattr(detector, "set_gamma"):
            detector.set_gamma(one.gamma)
        called.append(detector.process(one.events))
        in_time.append(one.done_us - one.events["t"] <= latency_us)
        events.append(one.events)
    if not called:
        return Used(float("nan"), 0.0)
    is_corner, all_corners = _truth(scene, np.concatenate(events))
    found = np.concatenate(called)
    finished = found & np.concatenate(in_time)
    return Used(_f(found, is_corner, int(is_corner.sum())), _f(finished, is_corner, all_corners))


def _f(called: NDArray[np.bool_], is_corner: NDArray[np.bool_], corners: int) -> float:
    return ratio(2 * int(np.sum(called & is_corner)), int(called.sum()) + corners)


def _truth(scene: Any, delivered: NDArray[np.void]) -> tuple[NDArray[np.bool_], int]:
    """Return which delivered events are corners, and how many of the whole scene are."""
    truth = _corners(scene)
    return truth[passed(delivered, scene.events)], int(truth.sum())


@lru_cache(maxsize=1)
def _corners(scene: Scene) -> NDArray[np.bool_]:
    return near_a_vertex(scene, scene.events, np.asarray(scene.labels).astype(np.int64))
