"""A value that does not fit is refused by its field at every entry, before anything is done."""

from __future__ import annotations

import math
import os
import socket
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
from asap import analysis, synthetic
from unfit import (
    NO_CALLBACKS,
    NO_FLAGS,
    NO_NAMES,
    NO_PATHS,
    NO_REALS,
    NO_SHARES,
    NO_TABLES,
    NO_WHOLES,
    assert_refused,
)

EVENTS = np.zeros(5, asap.EVENT_DTYPE)
COST = asap.LinearCost(1, 1)
RUN = asap.simulate(EVENTS, cost=COST)
CURVE = np.arange(9.0)


def nothing(events: np.ndarray) -> None:
    raise AssertionError("the algorithm was called")


ENTRIES: list[tuple[Callable[..., Any], str, tuple[Any, ...]]] = [
    (asap.Deadline, "latency_ms", NO_REALS),
    (asap.Greedy, "efficiency", NO_REALS[1:]),
    (asap.FixedSize, "size", (None, "x", 1.5, 0, 10**5000)),
    (lambda alpha_us: asap.LinearCost(alpha_us, 1), "alpha_us", NO_REALS),
    (partial(asap.LinearCost, 1, 2), "drift", (3, "x", [1.0, "x"])),
    (partial(asap.LinearCost, 1, 2), "outages_ms", (3, [(1,)])),
    (partial(asap.EFast, height=9), "width", (None, [9], 1.5, 0, 10**12, 10**5000)),
    (partial(asap.ClusterTracker, 9, 9), "support", NO_NAMES),
    (partial(asap.ClusterTracker, 9, 9), "slots", (None, "x", 1.5, 10**12)),
    (partial(asap.PlaneFlow, 9, 9), "refit", ("x", np.zeros(2))),
    (partial(asap.HotPixelMask, 9, 9), "pixels", (3, "xy", [(1,)])),
    (partial(asap.EventImage, 9, 9, count=5), "channels", (3, "on", ["x"])),
    (partial(asap.FeatureTracker, 9, 9), "detector", NO_NAMES),
    (lambda **named: asap.compare(EVENTS, cost=COST, **named), "speed", (None, "1", 1j, [1.0])),
    (lambda **named: asap.run(EVENTS, algorithm=nothing, **named), "speed", (None, "1", 1j, [1.0])),
    (lambda algorithm: asap.run(EVENTS, algorithm=algorithm), "algorithm", (asap.EFast,)),
    (asap.Pipeline, "algorithm", (asap.EFast, 10**5000)),
    (lambda before: asap.Pipeline(before=before), "before", (asap.EFast,)),
    (lambda **named: asap.as_events(EVENTS, **named), "time_unit", ([], {}, 5, "h")),
    (asap.Pipeline().push, "events", ("a.npy", 5)),
    (lambda **named: asap.run(EVENTS, algorithm=nothing, **named), "on_progress", NO_CALLBACKS),
    (lambda **named: asap.simulate(EVENTS, cost=COST, **named), "on_progress", NO_CALLBACKS),
    (lambda **named: asap.simulate(EVENTS, cost=COST, **named), "execution", NO_NAMES),
    (lambda **named: asap.simulate(EVENTS, cost=COST, **named), "width", NO_WHOLES[1:]),
    (lambda **named: asap.compare(EVENTS, cost=COST, **named), "on_progress", NO_CALLBACKS),
    (lambda **named: asap.compare(EVENTS, cost=COST, **named), "schemes", (1.5, object(), len)),
    (lambda **named: asap.compare(EVENTS, cost=COST, **named), "execution", NO_NAMES),
    (lambda **named: asap.oracle(EVENTS, cost=COST, latency_ms=5, **named), "execution", NO_NAMES),
    (lambda **named: asap.run(EVENTS, algorithm=nothing, **named), "execution", NO_NAMES[1:]),
    (lambda **named: asap.Pipeline(nothing, **named), "execution", NO_NAMES[1:]),
    (lambda **named: asap.compare(EVENTS, cost=COST, **named), "height", NO_WHOLES[1:]),
    (lambda **named: asap.check(EVENTS, **named), "on_progress", NO_CALLBACKS),
    (lambda **named: asap.check(EVENTS, **named), "width", NO_WHOLES[1:]),
    (lambda **named: asap.check(EVENTS, **named), "order", NO_NAMES[1:]),
    (lambda **named: asap.check(EVENTS, **named), "time_unit", NO_NAMES[1:]),
    (lambda **named: asap.as_events(EVENTS, **named), "order", NO_NAMES[1:]),
    (lambda **named: asap.as_events(EVENTS, **named), "copy", NO_FLAGS),
    (asap.as_events, "source", (5, object(), 1j, len)),
    (asap.read, "path", NO_PATHS),
    (asap.load_run, "path", NO_PATHS),
    (RUN.save, "path", NO_PATHS),
    (RUN.report, "path", NO_PATHS[-1:]),  # each draws the page first
    (synthetic.ShakenPattern, "duration_s", NO_SHARES),
    (synthetic.joined, "arrays", (None, "x", 5, EVENTS, [5], [np.zeros((2, 2))], [EVENTS[["t"]]])),
    (synthetic.FlightOverChairs, "seed", NO_WHOLES),
    (lambda bin_us: analysis.rate(EVENTS, bin_us), "bin_us", (*NO_SHARES, 0, math.inf)),
    (analysis.describe, "blocks", (None, "x", object(), 1.5, EVENTS)),
    (analysis.PeakCount, "window_us", (*NO_WHOLES, 0)),
    (analysis.PeakCount(9).add, "elapsed_us", (None, "x", [], object(), 1.5, np.ones((2, 2)))),
    (lambda x: analysis.decimate(x, CURVE, 8), "x", (*NO_TABLES[:4], [[1], [1, 2]])),
    (lambda y: analysis.decimate(CURVE, y, 8), "y", (*NO_TABLES[:5], [])),
    (lambda points: analysis.decimate(CURVE, CURVE, points), "points", (*NO_WHOLES, 3)),
    (analysis.time_s, "run", (None, "x", EVENTS)),
    (analysis.diagnose, "run", (None, "x", EVENTS)),
    (analysis.fit_cost, "run", (None, "x", EVENTS)),
    (lambda wanted: analysis.diagnose(RUN, wanted=wanted), "wanted", (*NO_SHARES, 1.5)),
    (lambda run: analysis.median_in_windows(run, "size", 1), "run", (None, "x", EVENTS)),
    (lambda column: analysis.median_in_windows(RUN, column, 1), "column", NO_NAMES),
    (lambda window_ms: analysis.median_in_windows(RUN, "size", window_ms), "window_ms", NO_SHARES),
    (analysis.Cost(1, 1).throughput_hz, "bound_us", NO_SHARES),
]


@pytest.mark.parametrize(("call", "field", "values"), ENTRIES)
def test_argument_of_any_kind_is_named(
    call: Callable[..., Any],
    field: str,
    values: tuple[Any, ...],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert_refused(call, field, values)


def test_masked_events_are_refused_by_every_door() -> None:
    masked = np.ma.masked_array(EVENTS.copy())
    masked["x"][3] = np.ma.masked
    for call in (
        lambda: asap.simulate(masked, cost=COST),
        lambda: asap.simulate([EVENTS, masked], cost=COST),
        lambda: asap.Pipeline().push(masked),
        lambda: asap.check(masked),
        lambda: analysis.rate(masked, 100),
        lambda: analysis.describe([masked]),
        lambda: synthetic.joined([EVENTS, masked]),
    ):
        with pytest.raises(ValueError, match=r"^\w+ = masked array: .{10,}"):
            call()
    with pytest.raises(TypeError, match="masked array"):
        asap.EFast(9, 9).process(masked)


SOURCES = [
    lambda source: asap.simulate(source, cost=COST),
    lambda source: asap.run(source, algorithm=nothing),
    lambda source: asap.compare(source, cost=COST),
    lambda source: asap.oracle(source, cost=COST, latency_ms=10),
]


@pytest.mark.parametrize("call", SOURCES)
def test_source_is_never_none_but_may_be_empty(call: Callable[[Any], Any]) -> None:
    with pytest.raises(TypeError, match=r"^source = None: "):
        call(None)
    call([])
    call(EVENTS[:0])


@pytest.mark.parametrize("kind", ["pipe", "device", "socket"])
def test_what_is_no_file_is_refused_and_not_waited_for(kind: str, tmp_path: Path) -> None:
    path = tmp_path / kind
    if kind == "pipe":
        os.mkfifo(path)
        end = os.open(path, os.O_RDWR)  # or whoever opens it waits
        os.write(end, b"1 2 3 1\n" * 6000)
    elif kind == "device":
        path = Path(os.devnull)
    else:
        server = socket.socket(socket.AF_UNIX)
        server.bind(os.path.relpath(path))  # a long one does not fit
    for call in (
        asap.read,
        asap.load,
        asap.check,
        asap.load_run,
        lambda path: asap.run(path, algorithm=nothing),
        lambda path: asap.simulate(path, cost=COST),
        lambda path: asap.compare(path, cost=COST),
    ):
        with pytest.raises(OSError, match=r"no regular file; .{10,}") as caught:
            call(path)
        assert caught.value.filename == str(path)
    if kind == "pipe":
        os.close(end)
    elif kind == "socket":
        server.close()
