"""Bad event data, class by class, through every way in: simulate, run, Pipeline and each format."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

import asap
import corrupt
from asap.events import Events
from event_files import WRITERS, assert_equal_events

EVENTS = corrupt.clean_events(4000)
SENSOR = {"width": corrupt.WIDTH, "height": corrupt.HEIGHT}


class Passed(NamedTuple):
    """What came through, and the books."""

    events: Events
    rejected: dict[str, int]
    clock_resets: int


class Collector(list[Events]):
    def process(self, events: Events) -> None:
        self.append(events)


def passed(parts: list[Events], books: Any, received: int) -> Passed:
    events = np.concatenate([EVENTS[:0], *parts])
    rejected = {reason: count for reason, count in books["rejected"].items() if count}
    assert received == len(events) + sum(rejected.values())
    assert (np.diff(events["t"]) >= 0).all()
    return Passed(events, rejected, books["clock_resets"])


def played(play: Callable[..., asap.Run], events: Any, _: Path, **options: Any) -> Passed:
    got = Collector()
    run = play(events, algorithm=got, **{"scheme": asap.Greedy(), **SENSOR, **options})
    assert run.ledger.balanced
    return passed(got, run.summary(), run.ledger.received)


def played_from_file(events: Events, folder: Path, **options: Any) -> Passed:
    WRITERS["npy"](folder / "played.npy", events)
    return played(SIMULATE, folder / "played.npy", folder, **options)


def live(events: Events, _: Path, **options: Any) -> Passed:
    pipeline = asap.Pipeline(**{"scheme": asap.Greedy(), "latency_ms": 1e4, **SENSOR, **options})
    for chunk in np.array_split(events, 3):
        pipeline.push(chunk)
    pipeline.stop()
    parts = [package.events for package in pipeline]
    assert pipeline.ledger.balanced
    return passed(parts, pipeline.stats(), pipeline.ledger.received)


def from_file(kind: str, events: Events, folder: Path, **options: Any) -> Passed:
    path = folder / f"events.{kind}"
    WRITERS[kind](path, events)
    if len(events) == 0 and kind == "txt":
        path.write_text("# no events\n")
    recording = asap.read(path, **{**SENSOR, **options})
    parts = list(recording)
    books = {"rejected": recording.rejected, "clock_resets": recording.clock_resets}
    found = passed(parts, books, recording.received)
    lost = bool(found.rejected or found.clock_resets)
    with pytest.warns(asap.io.LossWarning, match=str(path)) if lost else nullcontext():
        assert_equal_events(asap.load(path, **{**SENSOR, **options}), found.events)
    return found


FILES = {f"read {kind}": partial(from_file, kind) for kind in WRITERS}
WITH_TOLERANCE = {"live": live, **FILES}
SIMULATE = partial(asap.simulate, cost=asap.LinearCost(10, 10))
ENTRIES: dict[str, Callable[..., Passed]] = {
    "simulate": partial(played, SIMULATE),
    "simulate a file": played_from_file,
    "run": partial(played, partial(asap.run, speed=10)),
    **WITH_TOLERANCE,
}


@pytest.fixture(params=ENTRIES)
def entry(request: pytest.FixtureRequest, tmp_path: Path) -> Callable[..., Passed]:
    return lambda events, **options: ENTRIES[request.param](events, tmp_path, **options)


def test_clean_events_pass_untouched(entry: Any) -> None:
    assert_equal_events(entry(EVENTS).events, EVENTS)


def test_A1_back_steps(entry: Any) -> None:
    bad = corrupt.back_steps(EVENTS, 40)
    found = entry(bad)
    assert found.rejected == {"nonmonotonic": 40}
    assert_equal_events(found.events, EVENTS[bad["t"] == EVENTS["t"]])
    assert len(entry(bad, on_bad="clamp").events) == len(EVENTS)
    at = int(np.argmax(bad["t"] != EVENTS["t"]))
    with pytest.raises(ValueError, match=rf"^t = {bad['t'][at]} \(event {at}\): "):
        entry(bad, on_bad="raise")


@pytest.mark.parametrize("name", WITH_TOLERANCE)
def test_A1_back_steps_within_the_tolerance_are_no_loss(name: str, tmp_path: Path) -> None:
    bad = corrupt.back_steps(EVENTS, 40, by_us=100)
    found = WITH_TOLERANCE[name](bad, tmp_path, reorder_tolerance_us=100)
    in_files = np.sort(bad["t"])  # that can be looked ahead in
    lifted = np.maximum.accumulate(bad["t"])
    assert found.events["t"].tolist() == (in_files if "read" in name else lifted).tolist()
    assert WITH_TOLERANCE[name](bad, tmp_path, reorder_tolerance_us=50).rejected


def test_A2_clock_reset_starts_an_epoch(entry: Any) -> None:
    found = entry(corrupt.clock_reset(EVENTS, 2000, to_us=0))
    t = found.events["t"]
    assert (found.clock_resets, found.rejected) == (1, {})
    assert t[2000] == t[1999] + 1
    assert np.diff(t[2000:]).tolist() == np.diff(EVENTS["t"][2000:]).tolist()


@pytest.mark.parametrize("bits", [24, 31])
def test_A3_a_counter_that_wraps(entry: Any, bits: int) -> None:
    wrapped = EVENTS.copy()
    wrapped["t"] = (EVENTS["t"] - EVENTS["t"][2000]) % (1 << bits)
    found = entry(wrapped)
    assert (found.clock_resets, len(found.events)) == (1, len(EVENTS))


@pytest.mark.parametrize("first_us", [-(1 << 50), -1, 0, 1_633_953_690_975_950])
def test_A4_the_first_stamp_does_not_matter(entry: Any, first_us: int) -> None:
    moved = EVENTS.copy()
    moved["t"] += first_us - moved["t"][0]
    assert_equal_events(entry(moved).events, moved)


def test_A5_events_outside_the_sensor(entry: Any) -> None:
    bad = corrupt.outside_sensor(EVENTS, 30)
    found = entry(bad)
    inside = (bad["x"] < corrupt.WIDTH) & (bad["y"] < corrupt.HEIGHT)
    assert found.rejected == {"out_of_bounds": 30}
    assert_equal_events(found.events, bad[inside])
    clamped = entry(bad, on_bad="clamp").events
    assert clamped["x"].tolist() == np.minimum(bad["x"], corrupt.WIDTH - 1).tolist()
    with pytest.raises(ValueError, match=r"^[xy] = \d+ \(event \d+\): outside the sensor"):
        entry(bad, on_bad="raise")
    assert_equal_events(entry(bad, width=None, height=None).events, bad)


def test_A6_A8_events_on_one_stamp_and_duplicates_pass(entry: Any) -> None:
    for odd in (corrupt.one_stamp(EVENTS, 500, 600), corrupt.duplicates(EVENTS, 80)):
        assert_equal_events(entry(odd).events, odd)


def test_A8_odd_polarities_are_normalised(entry: Any) -> None:
    assert_equal_events(entry(corrupt.odd_polarity(EVENTS, 50)).events, EVENTS)


@pytest.mark.parametrize("count", [0, 1])
def test_A9_nothing_and_a_single_event(entry: Any, count: int) -> None:
    assert_equal_events(entry(EVENTS[:count]).events, EVENTS[:count])


@pytest.mark.parametrize("name", ["simulate", "live", *FILES])
def test_A10_a_year_of_silence_is_no_fault(name: str, tmp_path: Path) -> None:
    quiet = corrupt.gap(EVENTS, 100, 365 * 24 * 3600 * 10**6)
    found = ENTRIES[name](quiet, tmp_path)
    assert (found.rejected, found.clock_resets) == ({}, 0)
    assert_equal_events(found.events, quiet)


# ---- what only one of them can tell ---------------------------------------------------------


def test_empty_arrays_and_none_in_a_stream() -> None:
    chunks = [EVENTS[:0], EVENTS[:10], None, EVENTS[10:10], EVENTS[10:]]
    run = asap.simulate(iter(chunks), cost=asap.LinearCost(10, 10))
    assert run.ledger.received == EVENTS.size
    pipeline = asap.Pipeline()
    for chunk in chunks:
        pipeline.push(chunk)
    assert pipeline.ledger.received == EVENTS.size


def test_A15_what_comes_first_is_left_over(tmp_path: Path) -> None:
    rest = corrupt.clean_events(100, start_us=7_000_000)
    rest["x"][::2] = 9999
    fresh = EVENTS.copy()
    fresh["t"] -= fresh["t"][0]
    warm = fresh[fresh["t"] >= 5000]
    both = np.concatenate([rest, fresh])
    for on_bad in ("drop", "raise"):
        found = live(both, tmp_path, warmup_discard_us=5000, on_bad=on_bad)
        assert found.rejected == {"before_start": both.size - warm.size}
        assert found.clock_resets == 0
        assert_equal_events(found.events, warm)
