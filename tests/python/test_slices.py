"""Recording.slices: every format beside `load`, edges, silence, and a clock that is set back."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
import event_files
from asap.events import Events
from asap.io import FILE_FORMATS
from corrupt import clean_events, clock_reset
from event_files import assert_equal_events
from record_files import FORMATS, SIDE
from ros_bags import ENCODERS, SUFFIXES, Types, write_bag

EVENTS = clean_events(200_000)  # more than a chunk of any reader
EVENTS["x"] %= SIDE
EVENTS["y"] %= SIDE
SIZE = {"width": 346, "height": 260}
SUFFIX = {"hdf5": "h5", "matlab": "mat", "text": "txt"} | SUFFIXES
SUFFIX |= {kind: form.suffix[1:] for kind, form in FORMATS.items()}


def write(path: Path, form: str) -> Path:
    """Write EVENTS in any format that is read."""
    if form in SUFFIXES:
        types, base_us = Types(form), int(EVENTS["t"][0])
        packet = types.packet(ENCODERS["evt3"](EVENTS, base_us), "evt3", time_base=1000 * base_us)
        return write_bag(path, types, [("/events", packet)])
    if form == "matlab":
        pytest.importorskip("scipy.io").savemat(path, {role: EVENTS[role] for role in "txyp"})
    elif form == "text":
        event_files.write_txt(path, EVENTS)
    elif form in FORMATS:
        FORMATS[form].write(path, EVENTS)
    else:
        asap.convert(EVENTS, path, **SIZE)
    return path


def of_npy(path: Path, events: Events, **options: Any) -> asap.Recording:
    np.save(path / "a.npy", events)
    return asap.read(path / "a.npy", **options)


def stamped(*times: int) -> Events:
    events = np.zeros(len(times), asap.EVENT_DTYPE)
    events["t"] = times
    return events


@pytest.mark.parametrize("form", FILE_FORMATS)
def test_slices_of_every_format_are_all_of_its_events(tmp_path: Path, form: str) -> None:
    path = write(tmp_path / f"a.{SUFFIX.get(form, form)}", form)
    rec = asap.read(path)
    assert rec.format == form
    events = asap.load(path)
    assert len(events) == len(EVENTS)

    by_time = list(rec.slices(ms=10))
    assert_equal_events(np.concatenate([one.events for one in by_time]), events)
    assert by_time[0].begin_us == events["t"][0]
    for begin_us, end_us, part in by_time:
        assert end_us - begin_us == 10_000
        assert begin_us <= part["t"][0] <= part["t"][-1] < end_us
    assert all(one.end_us == after.begin_us for one, after in pairwise(by_time))

    by_count = list(rec.slices(events=30_000))
    assert [len(one.events) for one in by_count] == [*[30_000] * 6, 20_000]
    assert_equal_events(np.concatenate([one.events for one in by_count]), events)
    assert all(
        (one.begin_us, one.end_us) == (one.events["t"][0], one.events["t"][-1] + 1)
        for one in by_count
    )


def test_an_event_at_an_edge_begins_the_next_slice_and_silence_is_a_slice(tmp_path: Path) -> None:
    rec = of_npy(tmp_path, stamped(5, 1004, 1005, 3500, 4005))
    found = [(begin, end, part["t"].tolist()) for begin, end, part in rec.slices(ms=1)]
    assert found == [
        (5, 1005, [5, 1004]),
        (1005, 2005, [1005]),
        (2005, 3005, []),
        (3005, 4005, [3500]),
        (4005, 5005, [4005]),
    ]


def test_a_length_between_two_microseconds_does_not_drift(tmp_path: Path) -> None:
    frames = list(of_npy(tmp_path, stamped(0, 999_999)).slices(ms=1000 / 30))
    assert len(frames) == 30
    assert frames[-1].end_us == 1_000_000
    assert {end - begin for begin, end, _ in frames} == {33_333, 33_334}


def test_slices_of_a_window_begin_with_it(tmp_path: Path) -> None:
    rec = of_npy(tmp_path, stamped(0, 900, 3500, 7000), start=0.001, stop=0.005)
    found = [(begin, part["t"].tolist()) for begin, _, part in rec.slices(ms=1)]
    assert found == [(1000, []), (2000, []), (3000, [3500])]


@pytest.mark.parametrize("how", [{"ms": 10}, {"events": 7001}])
def test_time_goes_on_after_a_clock_was_set_back(tmp_path: Path, how: Any) -> None:
    rec = of_npy(tmp_path, clock_reset(EVENTS, 70_000))
    slices = list(rec.slices(**how))
    assert rec.clock_resets == 1
    with pytest.warns(asap.io.LossWarning):
        events = asap.load(rec.path)
    assert_equal_events(np.concatenate([one.events for one in slices]), events)
    assert all(one.begin_us < one.end_us <= after.end_us for one, after in pairwise(slices))


@pytest.mark.parametrize("how", [{"ms": 10}, {"events": 10}])
def test_no_events_are_no_slices(tmp_path: Path, how: Any) -> None:
    assert list(of_npy(tmp_path, EVENTS[:0]).slices(**how)) == []


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ({}, "ms = None, events = None"),
        ({"ms": 1, "events": 1}, "ms = 1, events = 1"),
        ({"ms": 0}, "ms = 0"),
        ({"events": 0}, "events = 0"),
    ],
)
def test_what_cuts_nothing_is_refused_at_once(tmp_path: Path, how: Any, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        of_npy(tmp_path, EVENTS).slices(**how)
