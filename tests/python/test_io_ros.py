"""ROS bags: packets in every encoding, arrays, several topics, and bags that are cut or damaged."""

from __future__ import annotations

import os
import struct
import warnings
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import asap
import ros_bags
from asap.events import Events
from asap.io import CorruptFile, TruncatedFileWarning, UnsupportedFormat
from corrupt import clean_events, cut_file
from event_files import assert_equal_events, recording
from fuzzing import damaged, effort
from ros_bags import ENCODERS, HEIGHT, SUFFIXES, WIDTH, Types, write_bag

EVENTS = clean_events(1000)
BASE_US = 1_999_999
TOPIC = "/event_camera/events"


@pytest.fixture(params=SUFFIXES)
def types(request: pytest.FixtureRequest) -> Types:
    """The messages of a format."""
    return Types(request.param)


@pytest.fixture
def path(types: Types, tmp_path: Path) -> Path:
    """Where a bag of that format is written."""
    return tmp_path / f"events.{SUFFIXES[types.format]}"


def packets(types: Types, events: Events, count: int, encoding: str = "mono") -> list[Any]:
    """`count` messages of events, each with a base of its own."""
    messages = []
    for part in np.array_split(events, count):
        base_us = int(part["t"][0]) - 1
        payload = ENCODERS[encoding](part, base_us)
        message = types.packet(payload, encoding, time_base=1000 * base_us + 999)
        messages.append((TOPIC, message))
    return messages


def read_all(path: Path, **options: Any) -> tuple[Events, asap.io.Recording]:
    """The events and the recording, whatever it warns."""
    rec = asap.read(path, **options)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", TruncatedFileWarning)
        chunks = list(rec)
    return np.concatenate([EVENTS[:0], *chunks]), rec


class TestPackets:
    @pytest.mark.parametrize("encoding", ["mono", "libcaer", "libcaer_cmp"])
    def test_every_encoding(self, types: Types, path: Path, encoding: str) -> None:
        write_bag(path, types, packets(types, EVENTS, 7, encoding))
        rec = asap.read(path)
        assert_equal_events(np.concatenate(list(rec)), EVENTS)
        assert_equal_events(np.concatenate(list(rec)), EVENTS)
        assert (rec.format, rec.width, rec.height) == (types.format, WIDTH, HEIGHT)
        assert rec.streams == (TOPIC,)
        assert set(rec.rejected.values()) == {0}

    def test_evt3_words_run_on_across_messages(self, types: Types, path: Path) -> None:
        words = ENCODERS["evt3"](EVENTS, 0)
        cuts = np.sort(np.random.default_rng(0).integers(0, len(words), 50))  # odd ones too
        parts = [words[first:last] for first, last in pairwise((0, *cuts, len(words)))]
        write_bag(path, types, [(TOPIC, types.packet(part, "evt3")) for part in parts])
        assert_equal_events(asap.load(path), EVENTS)

    @pytest.mark.parametrize("frame", ["", "a", "ab", "abc", "abcd", "abcde", "abcdef", "abcdefg"])
    def test_fields_are_aligned_behind_any_frame(
        self, types: Types, path: Path, frame: str
    ) -> None:
        payload = ENCODERS["mono"](EVENTS, BASE_US)
        messages = [
            (TOPIC, types.packet(payload, "mono", time_base=1000 * BASE_US, frame=frame)),
            ("/array", types.array(EVENTS, frame=frame)),
        ]
        write_bag(path, types, messages)
        for stream in (TOPIC, "/array"):
            assert_equal_events(asap.load(path, stream=stream), EVENTS)


class TestArrays:
    @pytest.mark.parametrize("counts", [[1000], [0, 1, 2, 997], [500, 500]])
    def test_of_any_length(self, types: Types, path: Path, counts: list[int]) -> None:
        parts = np.split(EVENTS, np.cumsum(counts)[:-1])
        write_bag(path, types, [(TOPIC, types.array(part)) for part in parts])
        events, rec = read_all(path)
        assert_equal_events(events, EVENTS)
        assert (rec.width, rec.height) == (WIDTH, HEIGHT)
        assert set(rec.rejected.values()) == {0}


class TestTopics:
    def write(self, path: Path, types: Types) -> None:
        messages = [("/other", types.other())]
        halves = (packets(types, half, 5) for half in (EVENTS[:500], EVENTS[500:]))
        for (_, left), (_, right) in zip(*halves, strict=True):
            messages += [("/left/events", left), ("/right/events", right)]
        write_bag(path, types, messages)

    def test_several_are_a_question(self, types: Types, path: Path) -> None:
        self.write(path, types)
        packet = r"\(event_camera_msgs/EventPacket\)"
        words = rf"holds 2 streams of events \(/left/events {packet}, /right/events {packet}\)"
        with pytest.raises(ValueError, match=words):
            asap.read(path)
        with pytest.raises(ValueError, match=r"stream = '/other': .*/left/events"):
            asap.read(path, stream="/other")

    @pytest.mark.parametrize("name", ["/right/events", "right"])
    def test_one_is_chosen(self, types: Types, path: Path, name: str) -> None:
        self.write(path, types)
        rec = asap.read(path, stream=name)
        assert_equal_events(np.concatenate(list(rec)), EVENTS[500:])
        assert rec.streams == ("/left/events", "/right/events")

    def test_none_of_events_are_listed(self, types: Types, path: Path) -> None:
        write_bag(path, types, [("/clock", types.other())])
        words = r"no topic holds events; topics: /clock \(std_msgs/Header\); .* dvs_msgs/EventArray"
        with pytest.raises(UnsupportedFormat, match=words):
            asap.read(path)

    @pytest.mark.parametrize("storage", ["db3", "mcap"])
    def test_a_folder(self, tmp_path: Path, storage: str) -> None:
        types = Types("rosbag2")
        ros_bags.write_folder(tmp_path / "bag", types, packets(types, EVENTS, 3), storage)
        rec = asap.read(tmp_path / "bag")
        assert_equal_events(np.concatenate(list(rec)), EVENTS)
        assert rec.format == "rosbag2"
        assert_equal_events(asap.load(tmp_path / "bag", file_format="rosbag2"), EVENTS)


class TestBadMessages:
    def test_an_unknown_encoding_is_named(self, types: Types, path: Path) -> None:
        write_bag(path, types, [(TOPIC, types.packet(b"", "trigger"))])
        with pytest.raises(UnsupportedFormat, match=r"encoded in 'trigger'; .* mono"):
            asap.read(path)

    def test_they_are_dropped_and_counted(self, types: Types, path: Path) -> None:
        payload = ENCODERS["mono"](EVENTS[:10], 0)
        name, good = types.packet(payload, "mono")
        bad = [
            types.packet(payload, "libcaer"),
            types.packet(payload, "mono", is_bigendian=True),
            (name, good[:-8]),  # events are missing
            (name, good[:40]),
            (name, b"\0"),
            (name, b"\xff" * 60),
        ]
        messages = [(TOPIC, message) for message in ((name, good), *bad)]
        write_bag(path, types, messages)
        events, rec = read_all(path)
        assert_equal_events(events[:10], EVENTS[:10])
        assert rec.rejected["bad_record"] == len(bad)
        for number, word in (
            (1, "'libcaer', not 'mono'"),
            (2, "big-endian"),
            (3, "72 of 80 bytes"),
        ):
            write_bag(path, types, [messages[0], messages[number]])
            fault = f"message 1 of {TOPIC}: .*{word}"
            with pytest.raises(CorruptFile, match=fault):
                asap.load(path, on_bad="raise")

    def test_bad_records_are_counted(self, types: Types, path: Path) -> None:
        good = ENCODERS["libcaer"](EVENTS[:10], 0)
        message = types.packet(good + struct.pack("<Ii", 0, -1) + b"abc", "libcaer")
        write_bag(path, types, [(TOPIC, message)])
        events, rec = read_all(path)
        assert_equal_events(events, EVENTS[:10])
        assert rec.rejected["bad_record"] == 2  # the negative stamp and the cut one
        with pytest.raises(CorruptFile, match=r"message 0 of .* some of its records hold no event"):
            asap.load(path, on_bad="raise")


def mcap_record(op: int, data: bytes, size: int | None = None) -> bytes:
    return struct.pack("<BQ", op, len(data) if size is None else size) + data


def mcap_chunk(records: bytes, size: int | None = None) -> bytes:
    head = struct.pack("<QQQIIQ", 0, 0, len(records), 0, 0, len(records))
    return mcap_record(6, head + records, size)


MANY = clean_events(20_000)  # in messages that are longer than a page of a database


WAYS = [(format, way) for format in SUFFIXES for way in ("", *ros_bags.COMPRESSIONS[format])]


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_a_file_of_messages_that_are_packed_one_by_one(storage: str, tmp_path: Path) -> None:
    types, folder = Types("mcap" if storage == "mcap" else "rosbag2"), tmp_path / "bag"
    options = {"compression": "zstd", "mode": "message"}
    ros_bags.write_folder(folder, types, packets(types, EVENTS, 20), storage, **options)
    (file,) = (path for path in folder.iterdir() if path.suffix != ".yaml")
    for path in (folder, file):
        assert_equal_events(read_all(path)[0], EVENTS)


@pytest.mark.parametrize("name", [b"#", b"a?b", b"%41", b"\xff"], ids=repr)
@pytest.mark.parametrize("is_folder", [True, False])
def test_a_folder_may_have_any_name(name: bytes, is_folder: bool, tmp_path: Path) -> None:
    types, bag = Types("rosbag2"), tmp_path / "bag"
    ros_bags.write_folder(bag, types, packets(types, EVENTS, 20), "sqlite3")
    (tmp_path / os.fsdecode(name)).mkdir()
    bag = bag.rename(tmp_path / os.fsdecode(name) / "bag")
    assert_equal_events(asap.load(bag if is_folder else bag / "bag.db3"), EVENTS)


def test_unrelated_bags_with_neighbouring_numbers_are_no_parts(tmp_path: Path) -> None:
    types = Types("rosbag2")
    first, second = tmp_path / "run_1.db3", tmp_path / "run_2.db3"
    write_bag(first, types, packets(types, EVENTS, 20))
    write_bag(second, types, [(TOPIC, types.packet(ENCODERS["evt3"](EVENTS, 0), "evt3"))])
    for path in (first, second):  # a warning of siblings would be an error
        assert_equal_events(asap.load(path), EVENTS)
    for both in (tmp_path, [first, second]):
        with pytest.raises(ValueError, match=r"run_2\.db3: its .* give the parts of one recording"):
            asap.load(both)


class TestDamage:
    @pytest.mark.parametrize("chunk_bytes", [0, 20_000])
    def test_mcap_without_its_end_gives_what_is_whole(
        self, tmp_path: Path, chunk_bytes: int
    ) -> None:
        mcap = pytest.importorskip("mcap.writer")
        types, path = Types("mcap"), tmp_path / "events.mcap"
        with path.open("wb") as file:
            writer = mcap.Writer(file, chunk_size=chunk_bytes, use_chunking=chunk_bytes > 0)
            writer.start(profile="ros2")
            kind = "event_camera_msgs/msg/EventPacket"
            topic = writer.register_channel(TOPIC, "cdr", writer.register_schema(kind, "", b""))
            for _, (_, message) in packets(types, MANY, 20):
                writer.add_message(topic, 0, message, 0)
            data = file.tell()
            writer.finish()
        content = path.read_bytes()
        random = np.random.default_rng(0)
        counts = []
        for size in sorted({*range(16, 200), *random.integers(200, data, 50).tolist()}):
            path.write_bytes(content[:size])
            try:
                events, _ = read_all(path)
            except CorruptFile as error:
                assert error.offset <= size
                counts.append(0)
            else:
                assert_equal_events(events, MANY[: len(events)])
                counts.append(len(events))
        assert counts == sorted(counts)
        assert len(set(counts)) > 5

    def test_a_bag_of_ros_1_without_its_index_is_refused_with_what_helps(
        self, tmp_path: Path
    ) -> None:
        types, path = Types("rosbag1"), tmp_path / "a.bag"
        write_bag(path, types, packets(types, MANY, 20))
        cut_file(path, path.stat().st_size * 3 // 4)
        with pytest.raises(CorruptFile, match=r"rosbag reindex a\.bag"):
            asap.load(path)

    def test_a_cut_database_is_refused_with_what_helps(self, tmp_path: Path) -> None:
        types, path = Types("rosbag2"), tmp_path / "a.db3"
        write_bag(path, types, packets(types, MANY, 20))
        cut_file(path, path.stat().st_size * 3 // 4)
        with pytest.raises(CorruptFile, match=r"SQLite: .*: sqlite3 a\.db3 \.recover"):
            asap.load(path)

    @pytest.mark.parametrize(
        "record",
        [
            mcap_record(5, bytes(5)),  # a message shorter than its own fields
            mcap_chunk(mcap_record(5, bytes(5)) + bytes(60)),
            mcap_chunk(bytes(90), size=50),
            mcap_record(3, bytes(90), size=2**63),
        ],
        ids=["message", "message in a chunk", "chunk", "schema"],
    )
    def test_a_record_that_lies_about_its_size(self, tmp_path: Path, record: bytes) -> None:
        pytest.importorskip("mcap")
        (tmp_path / "a.mcap").write_bytes(b"\x89MCAP0\r\n" + record + bytes(90))
        with pytest.raises(CorruptFile, match=r"byte \d+: "):
            asap.read(tmp_path / "a.mcap")

    @pytest.mark.parametrize(
        ("format", "compression"), [way for way in WAYS if way[0] != "rosbag2"]
    )
    def test_what_is_before_a_damaged_chunk_is_kept(
        self, tmp_path: Path, format: str, compression: str
    ) -> None:
        types, path = Types(format), tmp_path / f"events.{SUFFIXES[format]}"
        truth = clean_events(500_000)  # 4 MB, which are 4 chunks
        write_bag(path, types, packets(types, truth, 200), compression=compression)
        content = bytearray(path.read_bytes())
        if compression:
            begin = {"bz2": b"BZh9", "lz4": b"\x04\x22\x4d\x18", "zstd": b"\x28\xb5\x2f\xfd"}
            at, size = content.index(begin[compression], len(content) // 4), 4
        else:
            at, size = content.index(packets(types, truth, 200)[70][1][1]) - 28, 28  # of its head
        content[at : at + size] = b"\xff" * size
        path.write_bytes(content)
        with pytest.warns(TruncatedFileWarning, match=r"byte \d+: .*; what came before was read"):
            events = asap.load(path)
        assert 100_000 < len(events) < 300_000
        assert_equal_events(events, truth[: len(events)])
        with pytest.raises(CorruptFile, match=r"byte \d+: "):
            asap.load(path, on_bad="raise")

    @pytest.mark.parametrize(("format", "compression"), [("rosbag1", "bz2"), ("mcap", "zstd")])
    def test_a_chunk_that_promises_too_much(
        self, tmp_path: Path, format: str, compression: str
    ) -> None:
        types, path = Types(format), tmp_path / "events"
        write_bag(path, types, packets(types, EVENTS, 20), compression=compression)
        content, bomb = path.read_bytes(), struct.pack("<I", 2**32 - 1)
        if format == "rosbag1":
            at = content.index(b"size=") + len("size=")
            path.write_bytes(content[:at] + bomb + content[at + 4 :])
        else:
            at = content.index(compression.encode()) - 16  # before the checksum and a length
            size = content[at : at + 8]
            path.write_bytes(content.replace(size, bomb + bytes(4)))
        with pytest.raises(CorruptFile, match=f"chunk decompresses to {2**32 - 1} bytes"):
            asap.load(path)

    @effort(30)
    @given(data=st.data())
    def test_damaged_bytes_raise_only_what_is_documented(
        self, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
    ) -> None:
        types = Types(data.draw(st.sampled_from(sorted(SUFFIXES))))
        path = tmp_path_factory.mktemp("bag") / f"events.{SUFFIXES[types.format]}"
        compression = data.draw(st.sampled_from(("", *ros_bags.COMPRESSIONS[types.format])))
        write_bag(path, types, packets(types, EVENTS[:40], 4), compression=compression)
        path.write_bytes(data.draw(damaged(path.read_bytes())))
        try:
            read_all(path)
        except (ValueError, OSError) as error:
            assert str(error)


class TestRecordings:
    def test_one_in_two_containers(self) -> None:
        bag, database = (recording(f"ros/room_person_evt3.{suffix}") for suffix in ("bag", "db3"))
        pytest.importorskip("rosbags")
        assert_equal_events(asap.load(bag), asap.load(database))
