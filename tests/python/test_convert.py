"""asap.convert: what is written is read back, by asap and by others."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
import corrupt
from asap import cli
from asap.events import Events
from asap.io.conversion import WRITERS
from event_files import assert_equal_events

EVENTS = corrupt.clean_events(3000)
SENSOR = {"width": corrupt.WIDTH, "height": corrupt.HEIGHT}
HDF5 = ("dsec",)
STATE_THE_SENSOR = ("npz", "es", "evt3", "aedat4", "mcap", *HDF5)
IN_PACKETS = ("aedat4", "mcap", *HDF5)  # which also end where a piece of the source does


def long_gaps() -> Events:
    """Stamps that begin late, and stand apart by more than the counters of some formats."""
    events = EVENTS.copy()
    events["t"] += 274_260_989
    events["t"][1000:] += 30_000_000
    events["t"][2000:] += 600_000_000
    return events


# ---- read back by asap ----------------------------------------------------------------------


@pytest.mark.parametrize("to", WRITERS)
@pytest.mark.parametrize("events", [EVENTS, long_gaps()], ids=["short", "gaps"])
def test_it_is_read_back(tmp_path: Path, to: str, events: Events) -> None:
    path = tmp_path / "events.out"
    assert asap.convert(events, path, to=to, **SENSOR) == len(events)
    rec = asap.read(path)
    assert rec.format == ("hdf5" if to in HDF5 else to)
    sensor = (corrupt.WIDTH, corrupt.HEIGHT) if to in STATE_THE_SENSOR else (None, None)
    assert (rec.width, rec.height) == sensor
    assert_equal_events(asap.load(path), events)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("to", WRITERS)
def test_stamps_of_whole_ms_are_read_back_without_a_question(tmp_path: Path, to: str) -> None:
    events = EVENTS.copy()
    events["t"] = np.arange(len(events)) * 1000
    path = tmp_path / f"whole.{'h5' if to == 'dsec' else to}"
    asap.convert(events, path, to=to, **SENSOR)
    assert np.array_equal(asap.load(path), events)


@pytest.mark.parametrize(("to", "name"), [("es", "Event Stream"), ("aedat4", "AEDAT 4")])
def test_some_formats_need_the_sensor(tmp_path: Path, to: str, name: str) -> None:
    with pytest.raises(ValueError, match=f"width = None: {name} states its sensor; give width"):
        asap.convert(EVENTS, tmp_path / "out", to=to)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("to", WRITERS)
def test_a_file_a_recording_and_a_stream_are_sources(tmp_path: Path, to: str) -> None:
    asap.convert(EVENTS, tmp_path / "whole", to=to, **SENSOR)
    asap.convert(EVENTS, tmp_path / "in.npz", **SENSOR)
    sources = (
        tmp_path / "in.npz",
        asap.read(tmp_path / "in.npz"),
        [EVENTS[:7], EVENTS[7:7], EVENTS[7:]],
        {name: EVENTS[name] for name in "txyp"},
    )
    for source in sources:
        asap.convert(source, tmp_path / "again", to=to, **SENSOR)
        if to in IN_PACKETS:
            assert_equal_events(asap.load(tmp_path / "again"), EVENTS)
        else:
            assert (tmp_path / "again").read_bytes() == (tmp_path / "whole").read_bytes()


@pytest.mark.parametrize("to", ["npy", "npz"])
def test_the_same_events_are_the_same_bytes(tmp_path: Path, to: str) -> None:
    dirty = np.frombuffer(np.full(16 * len(EVENTS), 255, np.uint8), asap.EVENT_DTYPE).copy()
    for name in "txyp":
        dirty[name] = EVENTS[name]
    dirty.view(np.uint16)[3::8] = 7  # padding
    for name, events in (("a", EVENTS), ("b", dirty)):
        asap.convert(events, tmp_path / name, to=to)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


# ---- read back by others --------------------------------------------------------------------


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    folder = tmp_path_factory.mktemp("written")

    def write(to: str) -> Path:
        suffix = "raw" if to.startswith("evt") else to
        path = folder / f"{to}.{suffix}"
        asap.convert(EVENTS, path, to=to, **SENSOR)
        return path

    return write


def columns_of(array: Any) -> Events:
    return asap.as_events({name: array[name] for name in "txyp"})


@pytest.mark.parametrize("events", [EVENTS, long_gaps()], ids=["short", "gaps"])
def test_the_library_reads_aedat4(tmp_path: Path, events: Events) -> None:
    aedat = pytest.importorskip("aedat")
    path = tmp_path / "a.aedat4"
    asap.convert(events, path, **SENSOR)
    decoder = aedat.Decoder(path)
    assert decoder.id_to_stream() == {
        0: {"type": "events", "width": corrupt.WIDTH, "height": corrupt.HEIGHT}
    }
    packets = [packet["events"] for packet in decoder]
    assert_equal_events(columns_of(np.concatenate(packets)), events)
    assert all(np.ptp(packet["t"] // 10_000) == 0 for packet in packets)  # of 10 ms each


@pytest.mark.parametrize("events", [EVENTS, long_gaps()], ids=["short", "gaps"])
def test_rosbags_reads_mcap(tmp_path: Path, events: Events) -> None:
    highlevel = pytest.importorskip("rosbags.highlevel")
    path, words = tmp_path / "a.mcap", tmp_path / "words.raw"
    asap.convert(events, path, **SENSOR)
    with highlevel.AnyReader([path]) as bag:  # with the definition that stands in the file
        (topic,) = bag.connections
        messages = [(at, bag.deserialize(raw, topic.msgtype)) for _, at, raw in bag.messages()]
    assert (topic.topic, topic.msgtype) == ("/events", "event_camera_msgs/msg/EventPacket")
    for number, (at, message) in enumerate(messages):
        assert (message.width, message.height) == (corrupt.WIDTH, corrupt.HEIGHT)
        assert (message.seq, message.time_base, message.encoding) == (number, 0, "evt3")
        stamp_us = message.header.stamp.sec * 10**6 + message.header.stamp.nanosec // 1000
        assert message.header.frame_id == "" and not message.is_bigendian
        assert stamp_us in events["t"] and at // 1000 in events["t"]
        assert stamp_us // 1000 == at // 10**6  # of 1 ms
    words.write_bytes(b"".join(bytes(message.events) for _, message in messages))
    assert_equal_events(asap.load(words, file_format="evt3"), events)


# Peers run as programs of their own: some are under the GPL.
PEERS = {
    "evt3": ("evt3", "vars_of(evt3.decode_file(path))"),
    "es": ("event_stream", "turned(np.concatenate(list(event_stream.Decoder(path))))"),
}


@pytest.mark.parametrize("to", PEERS)
def test_peers_read_it(written: Callable[[str], Path], tmp_path: Path, to: str) -> None:
    module, read = PEERS[to]
    pytest.importorskip(module)
    program = f"""
import sys, numpy as np, {module}
path, out = sys.argv[1:]
vars_of = lambda events: {{name: getattr(events, name) for name in "txyp"}}
turned = lambda events: {{"t": events["t"], "x": events["x"], "p": events["on"],
                         "y": {SENSOR["height"]} - 1 - events["y"].astype(int)}}
events = {read}
np.save(out, np.stack([np.asarray(events[name]).astype(np.int64) for name in "txyp"]))
"""
    out = tmp_path / "columns.npy"
    subprocess.run([sys.executable, "-c", program, str(written(to)), str(out)], check=True)
    assert_equal_events(asap.as_events(tuple(np.load(out))), EVENTS)


# ---- what is refused ------------------------------------------------------------------------


@pytest.mark.parametrize("to", WRITERS)
def test_a_stamp_that_goes_back_is_refused_with_its_number(tmp_path: Path, to: str) -> None:
    events = EVENTS.copy()
    events["t"][2000] = events["t"][1999] - 3
    words = rf"^t = {events['t'][2000]} \(event 2000\): goes back by 3 us; sort the events"
    for source in (events, [events[:1500], events[1500:2000], events[2000:]]):
        with pytest.raises(ValueError, match=words):
            asap.convert(source, tmp_path / "out", to=to, **SENSOR)
    assert not list(tmp_path.iterdir())


def test_an_error_leaves_the_older_file(tmp_path: Path) -> None:
    asap.convert(EVENTS, tmp_path / "a.npy")

    def stream() -> Iterator[Events]:
        yield EVENTS
        raise RuntimeError("the camera is gone")

    with pytest.raises(RuntimeError, match="the camera is gone"):
        asap.convert(stream(), tmp_path / "a.npy")
    assert_equal_events(asap.load(tmp_path / "a.npy"), EVENTS)
    assert list(tmp_path.iterdir()) == [tmp_path / "a.npy"]


def test_what_is_lost_is_told(tmp_path: Path) -> None:
    np.save(tmp_path / "bad.npy", corrupt.outside_sensor(EVENTS, 60))
    with pytest.warns(UserWarning, match=r"out: without the events .*: 60 out_of_bounds"):
        count = asap.convert(tmp_path / "bad.npy", tmp_path / "out", to="evt3", **SENSOR)
    assert count == len(EVENTS) - 60
    np.save(tmp_path / "reset.npy", corrupt.clock_reset(EVENTS, 1000))
    with pytest.warns(UserWarning, match="jumped back 1 times.* go on 1 us after the last"):
        asap.convert(tmp_path / "reset.npy", tmp_path / "out", to="evt3")


# ---- the verb -------------------------------------------------------------------------------


def test_the_verb(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source, out = tmp_path / "a.npy", tmp_path / "a.raw"
    np.save(source, np.stack([EVENTS[role] for role in "xytp"], axis=1))
    arguments = ["convert", str(source), str(out), "--order", "xytp", "--width=346"]
    assert cli.main([*arguments, "--height=260", "--relative"]) == 0
    assert capsys.readouterr().out == f"wrote {out}: 3,000 events\n"
    assert asap.load(out)["t"][0] == 0
    assert cli.main([*arguments, "--format", "evt3", "--to", "3600s", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {
        "schema_version": 1,
        "path": str(out),
        "format": "evt3",
        "events": 3000,
    }
    assert_equal_events(asap.load(out), EVENTS)


def triggers_of(tmp_path: Path) -> Path:
    """Write EVT2 with three events and four triggers, one after a pause of 10 s."""

    def high(t: int) -> int:
        return 8 << 28 | t >> 6

    def trigger(t: int, number: int, value: int) -> int:
        return 10 << 28 | (t & 63) << 22 | number << 8 | value

    def event(t: int) -> int:
        return 1 << 28 | (t & 63) << 22 | 3 << 11 | 4

    late = 10_000_000
    words = [high(320), event(320), trigger(327, 2, 1), trigger(329, 0, 0), event(329)]
    words += [high(late), trigger(late + 1, 1, 1), event(late + 5), trigger(late + 6, 1, 0)]
    path = tmp_path / "in.raw"
    path.write_bytes(b"% evt 2.0\n" + np.array(words, "<u4").tobytes())
    return path


EDGES = [(327, 2, 1), (329, 0, 0), (10_000_001, 1, 1), (10_000_006, 1, 0)]


@pytest.mark.parametrize("relative", [False, True])
def test_triggers_are_written_in_evt3(relative: bool, tmp_path: Path) -> None:
    source, path = triggers_of(tmp_path), tmp_path / "out.raw"
    asap.convert(source, path, relative=relative)
    first_us = 320 * relative
    written = asap.read(path)
    assert np.concatenate(list(written))["t"].tolist() == [
        320 - first_us, 329 - first_us, 10_000_005 - first_us
    ]  # fmt: skip
    assert written.triggers.tolist() == [(t - first_us, n, value) for t, n, value in EDGES]


def test_triggers_of_a_window_of_time_are_written(tmp_path: Path) -> None:
    asap.convert(triggers_of(tmp_path), tmp_path / "out.raw", start=9, stop=9.999686)
    written = asap.read(tmp_path / "out.raw")
    assert np.concatenate(list(written))["t"].tolist() == [10_000_005]
    assert written.triggers.tolist() == EDGES[2:3]


def test_triggers_that_a_format_does_not_have_are_told(tmp_path: Path) -> None:
    with pytest.warns(UserWarning, match="without 4 external triggers"):
        asap.convert(triggers_of(tmp_path), tmp_path / "a.npz")
