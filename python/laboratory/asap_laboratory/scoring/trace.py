"""Trace: what a tracker said about a scene, moment by moment and event by event."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from asap import _core
from asap_laboratory.scoring.scene import NOISE, Scene

START_US = 100_000  #: the first sample
PERIOD_US = 5_000  #: from one to the next
ACTIVE_EVENTS = 5  #: of an object since the previous sample, to count as active
_HALF_SIGMAS = 1.75  # half a box


class Sample(NamedTuple):
    """A moment: what is there, and what the tracker says."""

    t_us: int
    objects: NDArray[np.int64]  #: their ids, shape (k,)
    centres: NDArray[np.float64]  #: (k, 2), px
    speeds: NDArray[np.float64]  #: (k, 2), px/s
    active: NDArray[np.bool_]  #: at least 5 events since the previous sample
    clusters: Snapshot
    gates_px: NDArray[np.float64] | None = None  #: a cluster farther away is another; None: 12 px


@dataclass(frozen=True)
class Feed:
    """The events that reached an algorithm, and what it returned for them."""

    indices: NDArray[np.int64]  #: into the events of the scene
    returned: NDArray[Any] | None  #: an id or a bool for each; None: nothing of that kind
    entered: NDArray[np.int64]  #: events of each package that went into filter or algorithm
    busy_ns: NDArray[np.int64]  #: time of each package in both


@dataclass(frozen=True)
class Trace:
    """A tracker over a scene."""

    samples: list[Sample]  #: every 5 ms from 100 ms on, up to the last event
    t_us: NDArray[np.int64]  #: of the events that reached the tracker
    labels: NDArray[np.int64]  #: of the same
    ids: NDArray[np.int64] | None  #: returned for them; None where the tracker returns none
    feed: Feed


def sample_times(events: NDArray[np.void]) -> list[int]:
    """Every 5 ms from 100 ms on, not after the last event; us."""
    end_us = int(events["t"][-1]) if events.size else -1
    return list(range(START_US, end_us + 1, PERIOD_US))


class HasEvents(Protocol):
    """What can be fed to an algorithm."""

    @property
    def events(self) -> NDArray[np.void]: ...  # noqa: D102


class _Feeder:
    """Package by package through filter, thinning and algorithm."""

    def __init__(
        self, algorithm: Any, scene: HasEvents, before: Any, gamma: float, seed: int
    ) -> None:
        self._algorithm, self._events, self._before = algorithm, scene.events, before
        self._gamma, self._thinning = gamma, _core.GammaFilter(seed=seed)
        self._indices: list[NDArray[np.int64]] = []
        self._returned: list[Any] = []
        self._entered: list[int] = []
        self._busy_ns: list[int] = []

    def feed(self, begin: int, end: int) -> NDArray[np.int64]:
        """Hand over events [begin, end); return the indices of those that passed the filter."""
        events, busy_ns = self._events[begin:end], 0
        kept = np.arange(events.size)
        if self._before is not None:
            start_ns = time.perf_counter_ns()
            returned = self._before.process(events)
            busy_ns = time.perf_counter_ns() - start_ns
            kept = passed(returned, events)
        passing = begin + kept
        if self._gamma < 1:
            kept = kept[self._thinning.mask(events[kept], self._gamma)]
        package = events if kept.size == events.size else events[kept]
        start_ns = time.perf_counter_ns()
        returned = self._algorithm.process(package)
        self._busy_ns.append(busy_ns + time.perf_counter_ns() - start_ns)
        self._entered.append(events.size if self._before is not None else package.size)
        self._indices.append(begin + kept)
        self._returned.append(_per_event(returned, package.size))
        return passing

    def rename(self, objects: list[int]) -> None:
        """Put the ids of objects for those of clusters in what the last package returned."""
        if self._returned[-1] is not None:
            self._returned[-1] = _ids_of_objects(self._algorithm, self._returned[-1], objects)

    def close(self) -> Feed:
        """Put the packages together."""
        returned = self._returned
        whole = returned and all(one is not None for one in returned)
        return Feed(
            np.concatenate([np.empty(0, np.int64), *self._indices]),
            np.concatenate(returned) if whole else None,
            np.array(self._entered, np.int64),
            np.array(self._busy_ns, np.int64),
        )


def _per_event(returned: Any, size: int) -> NDArray[Any] | None:
    """Ids or bools, one for each event; None for anything else."""
    values = np.asarray(returned)
    if values.dtype != np.bool_ and not np.issubdtype(values.dtype, np.integer):
        return None
    if values.shape != (size,):
        raise ValueError(
            f"process returned an array of shape {values.shape} for {size} events: must be one id "
            "or one bool for each event, or None"
        )
    return values


def _packages(events: NDArray[np.void], times: list[int]) -> Iterator[tuple[int, int, int | None]]:
    """Yield the events up to each of the times as (begin, end, time), then those after the last."""
    ends = np.searchsorted(events["t"], times)
    begin = 0
    for end, t_us in zip(ends.tolist(), times, strict=True):
        yield begin, end, t_us
        begin = end
    yield begin, events.size, None


def follow(
    tracker: Any,
    scene: Scene,
    *,
    before: Any = None,
    gamma: float = 1.0,
    seed: int = 0,
) -> Trace:
    """Let a tracker follow a scene and note what it says at every sample time; see `score`."""
    labels = np.asarray(scene.labels).astype(np.int64)
    feeder = _Feeder(tracker, scene, before, gamma, seed)
    samples = []
    for begin, end, t_us in _packages(scene.events, sample_times(scene.events)):
        passing = feeder.feed(begin, end)
        if t_us is None:
            break
        clusters = snapshot_at(tracker, t_us)
        if _groups(tracker):
            feeder.rename(clusters.ids.tolist())
        recent = passing[scene.events["t"][passing] >= t_us - PERIOD_US]
        sample = sample_at(scene, t_us, labels[recent])
        samples.append(sample._replace(clusters=clusters))
    feed = feeder.close()
    ids = feed.returned
    return Trace(
        samples,
        scene.events["t"][feed.indices],
        labels[feed.indices],
        None if ids is None else ids.astype(np.int64),
        feed,
    )


def snapshots_at(
    tracker: Any,
    scene: HasEvents,
    times: list[int],
    *,
    before: Any = None,
    gamma: float = 1.0,
    seed: int = 0,
) -> tuple[list[Snapshot], Feed]:
    """Let a tracker follow a recording and note its clusters at each of the times, us."""
    feeder = _Feeder(tracker, scene, before, gamma, seed)
    snapshots = []
    for begin, end, t_us in _packages(scene.events, times):
        feeder.feed(begin, end)
        if t_us is not None:
            snapshots.append(snapshot_at(tracker, t_us))
    return snapshots, feeder.close()


def run_through(
    algorithm: Any, scene: Scene, *, before: Any = None, gamma: float = 1.0, seed: int = 0
) -> Feed:
    """Put a scene through an algorithm without clusters, in the same packages as `follow`."""
    feeder = _Feeder(algorithm, scene, before, gamma, seed)
    for begin, end, _ in _packages(scene.events, sample_times(scene.events)):
        feeder.feed(begin, end)
    return feeder.close()


def sample_at(scene: Scene, t_us: int, recent: NDArray[np.int64]) -> Sample:
    """Return what there is at a time, without clusters; `recent`: objects of late events."""
    truth = scene.truth(t_us)
    caused = {
        int(label): int(count)
        for label, count in zip(*np.unique(recent, return_counts=True), strict=True)
    }
    objects = truth["id"].astype(np.int64)
    return Sample(
        t_us=t_us,
        objects=objects,
        centres=np.stack([truth["x"], truth["y"]], axis=-1).astype(np.float64),
        speeds=np.stack([truth["vx"], truth["vy"]], axis=-1).astype(np.float64),
        active=np.array([caused.get(one, 0) >= ACTIVE_EVENTS for one in objects.tolist()], bool),
        clusters=Snapshot(np.empty(0, np.int64), np.empty((0, 2))),
        gates_px=scene.match_radii_px(t_us) if hasattr(scene, "match_radii_px") else None,
    )


@dataclass(frozen=True)
class Snapshot:
    """Clusters at one time, one row each; None: the tracker has or states none."""

    ids: NDArray[np.int64]
    positions: NDArray[np.float64]  # (m, 2), px
    velocities: NDArray[np.float64] | None = None  # (m, 2), px/s
    covariances: NDArray[np.float64] | None = None  # (m, 2, 2), of the position's error, px^2
    boxes: NDArray[np.float64] | None = None  # (m, 4), left, top, width, height, px


def found_at(tracker: Any, t_us: int) -> NDArray[np.void]:
    """Read the objects of a tracker at a time, or the clusters of one that knows no objects.

    ``objects_at(t_us)`` and ``clusters_at(t_us)`` extrapolate by themselves, ``objects`` and
    ``clusters`` are extrapolated here where they have vx, vy and t_last.
    """
    name = "objects" if hasattr(tracker, "objects") else "clusters"
    if hasattr(tracker, f"{name}_at"):
        return np.asarray(getattr(tracker, f"{name}_at")(t_us))
    table = np.array(getattr(tracker, name))
    if {"x", "y", "vx", "vy", "t_last"} <= set(table.dtype.names or ()):
        ahead_s = (t_us - table["t_last"]) * 1e-6
        table["x"] = table["x"] + table["vx"] * ahead_s
        table["y"] = table["y"] + table["vy"] * ahead_s
    return table


def snapshot_at(tracker: Any, t_us: int) -> Snapshot:
    """Read what `found_at` finds, at a time not before the last event that the tracker has seen.

    A structured array with id, x, y and, where the tracker knows them, vx, vy [px/s], t_last [us]
    and the covariance pxx, pxy, pyy [px^2] of the error of x, y (infinite: it knows none). Its box
    is left, top, width, height [px], or 1.75 standard deviations around x, y where it has cxx, cyy,
    the covariance of its events; that is half of a bar, as in the boxes of our objects.
    """
    table = found_at(tracker, t_us)
    names = table.dtype.names or ()
    if not {"id", "x", "y"} <= set(names):
        raise TypeError(f"clusters of {tracker!r} have the fields {names}: need id, x, y")
    positions = _columns(table, "x", "y")
    velocities = _columns(table, "vx", "vy") if {"vx", "vy"} <= set(names) else None
    stated = _heaviest(tracker, table["id"].tolist(), t_us) if _groups(tracker) else table
    covariances = None
    if {"pxx", "pxy", "pyy"} <= set(stated.dtype.names or ()):
        errors = _columns(stated, "pxx", "pxy", "pxy", "pyy").reshape(-1, 2, 2)
        covariances = errors if np.all(np.isfinite(errors)) else None
    boxes = _boxes(table, positions)
    return Snapshot(table["id"].astype(np.int64), positions, velocities, covariances, boxes)


def _boxes(table: NDArray[np.void], positions: NDArray[np.float64]) -> NDArray[np.float64] | None:
    names = set(table.dtype.names or ())
    if {"left", "top", "width", "height"} <= names:
        return _columns(table, "left", "top", "width", "height")
    if not {"cxx", "cyy"} <= names:
        return None
    half = _HALF_SIGMAS * np.sqrt(_columns(table, "cxx", "cyy"))
    return np.hstack([positions - half, 2 * half])


def _groups(tracker: Any) -> bool:
    """Whether a tracker tells which object a cluster is a part of."""
    return hasattr(tracker, "objects") and hasattr(tracker, "to_objects")


def _heaviest(tracker: Any, objects: list[int], t_us: int) -> NDArray[np.void]:
    """Return the cluster of each object that it has its position from."""
    clusters = np.asarray(tracker.clusters_at(t_us))
    clusters = clusters[np.argsort(-clusters["size"], kind="stable")]
    owners = tracker.to_objects(clusters["id"].astype(np.int32)).tolist()
    return clusters[[owners.index(id) for id in objects]]


def _ids_of_objects(tracker: Any, ids: NDArray[Any], objects: list[int]) -> NDArray[np.int64]:
    """Put the id of its object for the id of each cluster; -1 for a cluster without."""
    owners = np.asarray(tracker.to_objects(ids.astype(np.int32)), np.int64)
    return np.where(np.isin(owners, objects), owners, NOISE)


def _columns(table: NDArray[np.void], *names: str) -> NDArray[np.float64]:
    return np.stack([table[name].astype(np.float64) for name in names], axis=-1)


_COORDINATE_BITS = 16


def passed(returned: Any, events: NDArray[np.void]) -> NDArray[np.int64]:
    """Find the indices, ascending, of the events that a filter let pass.

    It returned those events, in their order and unchanged, or a bool for each event (a corner
    detector in front of a tracker). The events that went in are in time order, of less than 1000 s;
    of several that are alike in every field, the first ones pass. A ValueError if events came out
    that did not go in, or in another order.
    """
    found = np.asarray(returned)
    if found.dtype == np.bool_ and found.shape == events.shape:
        return np.flatnonzero(found)
    if found.dtype != events.dtype or found.ndim != 1:
        raise ValueError(
            f"before.process returned {found.dtype} of shape {found.shape}: must be the events "
            "that pass, or a bool for each event"
        )
    if found.size == 0:
        return np.empty(0, np.int64)
    keys, order = _sorted_keys(events, events)
    wanted, back = _sorted_keys(found, events)
    # The k-th of the events that came out alike is the k-th of those that went in.
    place = np.searchsorted(keys, wanted)
    place += np.arange(wanted.size) - np.searchsorted(wanted, wanted)
    if place.max() >= keys.size or not np.array_equal(keys[place], wanted):
        raise ValueError("before.process returned events that were not handed to it")
    indices = np.empty(found.size, np.int64)
    indices[back] = order[place]
    return indices if np.all(np.diff(indices) > 0) else _in_order(found.tolist(), events.tolist())


def _in_order(found: list[Any], events: list[Any]) -> NDArray[np.int64]:
    """Find each after the one before it, where the first of several alike is not the one."""
    indices, at = [], 0
    for event in found:
        try:
            indices.append(events.index(event, at))
        except ValueError:
            raise ValueError("before.process returned the events in another order") from None
        at = indices[-1] + 1
    return np.array(indices, np.int64)


def _sorted_keys(
    events: NDArray[np.void], among: NDArray[np.void]
) -> tuple[NDArray[np.int64], NDArray[np.intp]]:
    """Every field of an event in one number, in ascending order, and where each stood."""
    since = events["t"] - among["t"][0]
    key = since << 2 * _COORDINATE_BITS + 1
    key |= events["x"].astype(np.int64) << _COORDINATE_BITS + 1
    key |= events["y"].astype(np.int64) << 1
    key |= events["p"].astype(np.int64) & 1
    order = np.argsort(key, kind="stable")
    return key[order], order
