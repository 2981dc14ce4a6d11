"""ROS bags: ROS 1 ``.bag`` and folders through ``rosbags``, ``.mcap`` through ``mcap``, ``.db3``.

The libraries hand out raw messages; a database is read with ``sqlite3``. The fields before the
events are read here and the events decoded by the native core, never one by one. One decoder serves
a topic from its first message to its last, because EVT3 words run on across messages. No definition
of a message is needed.

A recorder that crashes, a full disk or a copy that broke off leaves a bag without its index. An
MCAP file is then read from the front, up to the first record that is not whole; a ROS 1 bag is
refused with the command that makes the index.
"""

from __future__ import annotations

import errno
import shutil
import struct
import warnings
import weakref
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import mkdtemp
from typing import IO, Any, Protocol

import numpy as np

from asap import _core
from asap.events import EVENT_DTYPE, Events
from asap.io.errors import (
    HARMLESS,
    MAX_RATIO,
    CorruptFile,
    UnsupportedFormat,
    foreign,
    library,
    refuse_bomb,
)
from asap.io.reader import CHUNK, Losses, Options, choose_stream
from asap.io.sniff import METADATA, first_bytes, parts_of, stated

_MAX_PX = 0xFFFF


class RosReader:
    """The events of one topic of a bag of `kind`: ``"rosbag1"``, ``"rosbag2"`` or ``"mcap"``."""

    def __init__(self, kind: str, path: Path, options: Options, parts: Sequence[Path] = ()) -> None:
        options.refuse_stated(path, kind)
        self.format = kind
        self._path = path
        self._bag: Bag = _Parts(parts) if parts else open_bag(kind, path)
        self.streams = self._topics_of_events()
        types = self._bag.topics
        words = [f"{topic} ({types[topic]})" for topic in self.streams]
        self._topic = choose_stream(path, options.stream, self.streams, words)
        self._cdr = self._topic not in getattr(self._bag, "ros1", ()) and kind != "rosbag1"
        self._read = read_packet if types[self._topic] in PACKETS else read_array
        self._first = first = self._first_message(self._bag)
        self.width = first.width if first and 0 < first.width <= _MAX_PX else None
        self.height = first.height if first and 0 < first.height <= _MAX_PX else None
        if first and self._read is read_packet and first.encoding not in _core.PACKET_ENCODINGS:
            raise UnsupportedFormat(
                f"{path}: {self._topic} is encoded in {first.encoding!r}; what is read: "
                f"{', '.join(_core.PACKET_ENCODINGS)}"
            )

        for part, bag in getattr(self._bag, "bags", {}).items():
            if self._topic in bag.topics and not self._is_of_one_recording(bag):
                raise ValueError(
                    f"path = {part}: its {self._topic} has another sensor or encoding than the "
                    "part before; give the parts of one recording"
                )
        siblings = [] if parts or path.is_dir() else parts_of(path.parent, like=path)
        siblings = [other for other in siblings if other == path or self._goes_on_in(kind, other)]
        if len(siblings) > 1:
            warnings.warn(
                f"{path} is one of {len(siblings)} parts, {siblings[0].name} to "
                f"{siblings[-1].name}; give the folder, or a list of them, to read them all",
                stacklevel=2,
            )

    def _goes_on_in(self, kind: str, path: Path) -> bool:
        with suppress(CorruptFile, OSError):
            bag = open_bag(kind, path)
            return self._topic in bag.topics and self._is_of_one_recording(bag)
        return False

    def _is_of_one_recording(self, bag: Bag) -> bool:
        """Whether the topic has the same sensor and encoding there, as far as both tell."""
        first, other = self._first, self._first_message(bag)
        return (
            first is None
            or other is None
            or (first.width, first.height, first.encoding)
            == (other.width, other.height, other.encoding)
        )

    def chunks(self, losses: Losses, from_us: int | None = None) -> Iterator[Events]:
        """Decode message by message; an array goes out when it is full."""
        decoder = self._decoder()
        out, filled, bad_messages = np.empty(CHUNK, EVENT_DTYPE), 0, 0
        for number, raw in enumerate(self._messages(losses)):
            fault = "some of its records hold no event"
            try:
                message = self._read(raw, self._cdr)
                decoder.begin(message)
                while True:
                    filled += decoder.decode_into(out[filled:])
                    if decoder.is_done:
                        break
                    decoder.count(losses)  # its triggers go with the events
                    yield out[:filled]
                    out, filled = np.empty(CHUNK, EVENT_DTYPE), 0
                message.check_whole()
            except BadMessage as error:
                bad_messages, fault = bad_messages + 1, str(error)
            losses.lost_packets = decoder.lost
            losses.bad_record = bad_messages + decoder.count(losses)
            if losses.bad_record and losses.on_bad == "raise":
                raise CorruptFile(self._path, 0, f"message {number} of {self._topic}: {fault}")
        losses.bad_record += decoder.is_inside_a_record
        yield out[:filled]

    def _topics_of_events(self) -> tuple[str, ...]:
        types = self._bag.topics
        topics = tuple(sorted(topic for topic in types if types[topic] in PACKETS + ARRAYS))
        if not topics:
            found = ", ".join(f"{topic} ({kind})" for topic, kind in sorted(types.items()))
            raise UnsupportedFormat(
                f"{self._path}: no topic holds events; topics: {found or 'none'}; types that are "
                f"read: {', '.join(PACKETS + ARRAYS)}"
            )
        return topics

    def _messages(self, losses: Losses) -> Iterator[bytes]:
        try:
            yield from map(_unpacked, self._bag.messages(self._topic))
        except CorruptFile as error:
            losses.truncated(error.offset, error.fault)

    def _first_message(self, bag: Bag) -> Message | None:
        with suppress(CorruptFile):  # it is told when all are read
            for raw in map(_unpacked, bag.messages(self._topic)):
                with suppress(BadMessage):
                    return self._read(raw, self._cdr)
        return None

    def _decoder(self) -> _PacketDecoder | _ArrayDecoder:
        if self._read is read_array:
            return _ArrayDecoder(self._cdr)
        return _PacketDecoder(self._first.encoding if self._first else "mono")  # decodes none


class _PacketDecoder:
    """Events of packets in one encoding."""

    def __init__(self, encoding: str) -> None:
        self._encoding = encoding
        self._decoder = _core.packet_decoder(encoding)
        self._rest = memoryview(b"")
        self._sequence: int | None = None
        self.lost = 0  # messages that never arrived

    def begin(self, message: Message) -> None:
        """Go on with the events of another message; after a gap only with what is known there."""
        last, self._sequence = self._sequence, message.sequence
        if last is not None and message.sequence not in (last, last + 1):
            self.lost += max(message.sequence - last - 1, 0)  # it goes back: the driver restarted
            self._decoder.resume()
        if message.encoding != self._encoding:
            raise BadMessage(f"its encoding is {message.encoding!r}, not {self._encoding!r}")
        self._decoder.begin(message.time_base)
        self._rest = message.payload

    def decode_into(self, out: Events) -> int:
        """Return how many events there was room for."""
        used, written = self._decoder.decode_into(self._rest, out)
        self._rest = self._rest[used:]
        return int(written)

    @property
    def is_done(self) -> bool:
        """No event of the message is left."""
        return not self._rest

    def count(self, losses: Losses) -> int:
        """Return how many records were none."""
        losses.take_triggers(self._decoder)
        return int(self._decoder.bad_records)

    @property
    def is_inside_a_record(self) -> bool:
        """The last message ends with a part of a record."""
        return bool(self._decoder.unfinished)


class _ArrayDecoder:
    """Events of arrays, field by field."""

    is_done = True
    is_inside_a_record = False
    lost = 0  # arrays are not counted

    def __init__(self, cdr: bool) -> None:
        self._cdr = cdr
        self._payload = memoryview(b"")
        self._events = 0  # that are decoded

    def begin(self, message: Message) -> None:
        self._payload, self._events, self.is_done = message.payload, 0, False

    def decode_into(self, out: Events) -> int:
        written = _core.decode_dvs_into(self._payload, cdr=self._cdr, first=self._events, out=out)
        self._events += written
        self.is_done = written < len(out)
        return written

    def count(self, losses: Losses) -> int:
        return 0


# ---- messages: where the bytes of the events are. CDR aligns each field to its size, counted from
# the end of the four bytes that come first.

PACKETS = ("event_camera_msgs/EventPacket", "event_array_msgs/EventArray")
ARRAYS = ("dvs_msgs/EventArray", "prophesee_event_msgs/EventArray")

_FRAME_AT = 12  # the name of the frame, after four bytes, s and ns
_CDR_LITTLE = b"\x00\x01"


class BadMessage(Exception):
    """A message that holds no events; says why."""


@dataclass(frozen=True)
class Message:
    """Sensor and events of one message."""

    width: int
    height: int
    payload: memoryview  # the events, as far as they are there
    promised: int  # bytes of the events
    encoding: str = ""  # a packet has one
    time_base: int = 0  # ns
    sequence: int = 0  # number of the packet

    def check_whole(self) -> None:
        """Raise `BadMessage` if events are missing at its end."""
        if len(self.payload) < self.promised:
            raise BadMessage(f"{len(self.payload)} of {self.promised} bytes of events are there")


def read_packet(raw: bytes, cdr: bool) -> Message:
    """Read an ``EventPacket``: events in an encoding of their own."""
    try:
        at = _after_frame(raw, cdr)
        height, width = struct.unpack_from("<II", raw, at)
        at = _aligned(at + 8, 8, cdr)
        sequence, time_base, length = struct.unpack_from("<QQI", raw, at)
        encoding = raw[at + 20 : at + 20 + length].rstrip(b"\0").decode()
        at += 20 + length
        is_bigendian = raw[at]
        at = _aligned(at + 1, 4, cdr)
        (promised,) = struct.unpack_from("<I", raw, at)
    except (struct.error, IndexError, UnicodeDecodeError) as error:
        raise BadMessage("its header is cut or damaged") from error
    if is_bigendian:
        raise BadMessage("its events are big-endian")
    at += 4
    payload = memoryview(raw)[at : at + promised]
    return Message(width, height, payload, promised, encoding, time_base, sequence)


def read_array(raw: bytes, cdr: bool) -> Message:
    """Read an ``EventArray`` of dvs_msgs: events field by field."""
    try:
        at = _after_frame(raw, cdr)
        height, width, events = struct.unpack_from("<III", raw, at)
    except struct.error as error:
        raise BadMessage("its header is cut or damaged") from error
    at += 12
    promised = max(16 * events - 3, 0) if cdr else 13 * events  # only the first one has no padding
    return Message(width, height, memoryview(raw)[at : at + promised], promised)


def _after_frame(raw: bytes, cdr: bool) -> int:
    """Where the fields after the header begin."""
    if cdr and raw[:2] != _CDR_LITTLE:
        raise BadMessage(f"it is not in little-endian CDR but in 0x{raw[:2].hex()}")
    (length,) = struct.unpack_from("<I", raw, _FRAME_AT)
    return _aligned(_FRAME_AT + 4 + length, 4, cdr)


def _aligned(at: int, size: int, cdr: bool) -> int:
    return at + (4 - at) % size if cdr else at


# ---- bags: topics and raw messages --------------------------------------------------------------


class Bag(Protocol):
    """The topics of a bag and their messages."""

    topics: dict[str, str]  # type of each, "package/Type"

    def messages(self, topic: str) -> Iterator[bytes]:
        """Yield the messages of a topic as they were recorded.

        Raises
        ------
        CorruptFile
            After the last good one, if there should be more.
        """
        ...


def open_bag(kind: str, path: Path) -> Bag:
    """Open a bag of `kind`: ``"rosbag1"``, ``"rosbag2"`` (a file or a folder) or ``"mcap"``."""
    by_parts = path.is_dir() and (not _has_metadata(path) or any(path.glob("*.db3")))
    if by_parts and (parts := parts_of(path)):
        return _Parts(parts)
    if kind == "mcap":
        return _Mcap(path)
    if kind == "rosbag2":
        return _IndexedBag(path, _folder_reader(path)) if path.is_dir() else _Database(path)
    rosbag1 = library("rosbags.rosbag1", "A ROS 1 bag", "ros")
    try:
        return _IndexedBag(path, lambda: rosbag1.Reader(path))
    except CorruptFile as error:
        remedy = f"{error.fault}; if its index is missing: rosbag reindex {path.name}"
        raise CorruptFile(path, error.offset, remedy) from error


def _has_metadata(folder: Path) -> bool:
    """Whether the recorder came to list its files; one that was killed did not."""
    metadata = folder / METADATA
    return metadata.exists() and b"relative_file_paths" in metadata.read_bytes()


def _folder_reader(path: Path) -> Callable[[], Any]:
    reader = library("rosbags.rosbag2", "A folder of ROS 2", "ros").Reader.STORAGE_PLUGINS["dir"]
    return lambda: reader(path)  # by content: Reader() would go by the suffix


def _plain(msgtype: str) -> str:
    return msgtype.replace("/msg/", "/")


@contextmanager
def _library_errors(path: Path) -> Iterator[None]:
    with foreign(path):
        try:
            yield
        except OSError as error:
            if error.errno != errno.EINVAL:
                raise
            raise ValueError("its index points outside of it") from error


class _IndexedBag:
    """A bag that the library opens."""

    def __init__(self, path: Path, make_reader: Callable[[], Any]) -> None:
        self._path, self._make_reader = path, make_reader
        with self._opened() as reader, _library_errors(path):
            self.topics = {c.topic: _plain(c.msgtype) for c in reader.connections}
            if isinstance(chunks := getattr(reader, "chunks", None), dict):
                _refuse_bombs_of_ros1(path, chunks)

    def messages(self, topic: str) -> Iterator[bytes]:
        count = 0
        with self._opened() as reader:
            wanted = [c for c in reader.connections if c.topic == topic]
            try:
                with _library_errors(self._path):
                    for _, _, data in reader.messages(wanted):
                        yield data if isinstance(data, bytes) else b""  # in a database: anything
                        count += 1
            except CorruptFile as error:
                file = getattr(reader, "bio", None)  # none in a database or a folder
                words = f"{error.fault} (after {count} messages of {topic})"
                raise CorruptFile(self._path, file.tell() if file else 0, words) from error

    @contextmanager
    def _opened(self) -> Iterator[Any]:
        with _library_errors(self._path):
            reader = self._make_reader()
            try:
                reader.open()
            except BaseException:
                with suppress(Exception):  # older ones leave the file open
                    reader.close()
                raise
        with closing(reader):
            yield reader


class _Parts:
    """A split bag: its files one after the other."""

    def __init__(self, parts: Iterable[Path]) -> None:
        self.bags = {part: open_bag(stated(first_bytes(part)) or "", part) for part in parts}
        bags = self.bags.values()
        self.topics = {name: kind for bag in bags for name, kind in bag.topics.items()}
        self.ros1 = {topic for bag in bags for topic in getattr(bag, "ros1", ())}

    def messages(self, topic: str) -> Iterator[bytes]:
        for bag in self.bags.values():
            if topic in bag.topics:
                yield from bag.messages(topic)


class _Database:
    """A ROS 2 bag in one SQLite file; SQLite itself refuses one that was cut.

    What a recorder that was killed left beside it, in a log or a journal, belongs to it: SQLite
    reads both in a copy, because it would write beside the recording.
    """

    def __init__(self, path: Path) -> None:
        self._path = self._file = path
        if logs := _logs(path):
            folder = mkdtemp(prefix="asap-")
            weakref.finalize(self, shutil.rmtree, folder, ignore_errors=True)
            self._file = Path(folder, path.name)
            for file in (path, *logs):
                shutil.copyfile(file, self._file.with_name(file.name))
        rows = self._rows("SELECT name, type FROM topics")
        self.topics = {str(name): _plain(str(kind)) for name, kind in rows}

    def messages(self, topic: str) -> Iterator[bytes]:
        wanted = "topic_id IN (SELECT id FROM topics WHERE name = ?)"
        query = f"SELECT CAST(data AS BLOB) FROM messages WHERE {wanted} ORDER BY id"
        for (data,) in self._rows(query, topic):
            yield data or b""

    def _rows(self, query: str, *values: str) -> Iterator[tuple[Any, ...]]:
        sqlite3 = library("sqlite3", "A ROS 2 bag", "ros")
        try:
            only_read = "?mode=ro&immutable=1" if self._file == self._path else ""
            uri = f"{self._file.absolute().as_uri()}{only_read}"
            with closing(sqlite3.connect(uri, uri=True)) as database:
                yield from database.execute(query, values)
        except sqlite3.Error as error:
            words = f"SQLite: {error}; what is left of it: sqlite3 {self._path.name} .recover"
            raise CorruptFile(self._path, self._path.stat().st_size, words) from error


def _logs(path: Path) -> list[Path]:
    """Files beside a database that hold a part of it."""
    beside = (path.with_name(path.name + end) for end in ("-wal", "-journal"))
    return [log for log in beside if log.exists() and log.stat().st_size]


def _unpacked(message: bytes) -> bytes:
    """Unpack what a recorder packed message by message, which only its metadata would say."""
    if not message.startswith(b"\x28\xb5\x2f\xfd"):  # no CDR begins so
        return message
    zstandard = library("zstandard", "A bag of packed messages", "ros")
    with suppress(zstandard.ZstdError):
        unpacker = zstandard.ZstdDecompressor().stream_reader(message)
        return bytes(unpacker.read(max(HARMLESS, MAX_RATIO * len(message))))
    return b""  # a bad message


def _refuse_bombs_of_ros1(path: Path, offsets: Iterable[int]) -> None:
    """Compare what the chunks of a ROS 1 bag promise with what is stored."""
    with path.open("rb") as file:
        for offset in offsets:
            file.seek(offset)
            (length,) = struct.unpack("<I", file.read(4))
            (promised,) = struct.unpack("<I", file.read(length).partition(b"size=")[2][:4])
            refuse_bomb(path, offset, "the chunk", promised, *struct.unpack("<I", file.read(4)))


class _Mcap:
    """An MCAP file; without an index it is read from the front, up to what is not whole."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._end: CorruptFile | None = None
        self._reader, self._stream_reader, self._kind = (
            library(f"mcap.{name}", "An MCAP file", "ros")
            for name in ("reader", "stream_reader", "records")
        )
        with path.open("rb") as file:
            summary = self._summary(file)
        self._has_index = summary is not None and bool(summary.chunk_indexes)
        if summary is None:
            channels, schemas = self._listed()
        else:
            channels, schemas = summary.channels, summary.schemas
        for chunk in summary.chunk_indexes if summary is not None else ():
            offset, unpacked = chunk.chunk_start_offset, chunk.uncompressed_size
            refuse_bomb(path, offset, "the chunk", unpacked, chunk.compressed_size)
        of_ros = [c for c in channels.values() if c.message_encoding in ("cdr", "ros1")]
        kinds = {c.id: schemas[c.schema_id].name for c in of_ros if c.schema_id in schemas}
        self.topics = {c.topic: _plain(kinds.get(c.id, "")) for c in of_ros}
        self.ros1 = {c.topic for c in of_ros if c.message_encoding == "ros1"}
        if not self.topics and self._end is not None:
            raise self._end

    def messages(self, topic: str) -> Iterator[bytes]:
        with self._path.open("rb") as file, foreign(self._path):
            if self._has_index:
                reader = self._reader.SeekingReader(file, validate_crcs=True)
                yield from (message.data for _, _, message in reader.iter_messages(topic))
                return
            wanted: set[int] = set()
            for record in self._records(file):
                if isinstance(record, self._kind.Channel) and record.topic == topic:
                    wanted.add(record.id)
                elif isinstance(record, self._kind.Message) and record.channel_id in wanted:
                    yield record.data

    def _summary(self, file: IO[bytes]) -> Any:
        with suppress(CorruptFile), foreign(self._path):
            return self._reader.SeekingReader(file).get_summary()
        return None

    def _listed(self) -> tuple[dict[int, Any], dict[int, Any]]:
        """Return channels and schemas by their numbers, as far as the file can be read."""
        channels: dict[int, Any] = {}
        schemas: dict[int, Any] = {}
        with self._path.open("rb") as file:
            try:
                for record in self._records(file):
                    if isinstance(record, self._kind.Channel):
                        channels[record.id] = record
                    elif isinstance(record, self._kind.Schema):
                        schemas[record.id] = record
            except CorruptFile as error:
                self._end = error
        return channels, schemas

    def _records(self, file: IO[bytes]) -> Iterator[Any]:
        """Read record by record; `CorruptFile` at the first that is not whole."""
        size, at = self._path.stat().st_size, len(b"\x89MCAP0\r\n")
        reader = self._stream_reader.StreamReader(file, emit_chunks=True, record_size_limit=size)
        records = iter(reader.records)
        while True:
            try:
                with foreign(self._path, at):
                    record = next(records, None)
                    if record is None:
                        return
                    inside = [record]
                    if isinstance(record, self._kind.Chunk):
                        promised, stored = record.uncompressed_size, len(record.data)
                        refuse_bomb(self._path, at, "the chunk", promised, stored)
                        inside = self._stream_reader.breakup_chunk(record, validate_crc=True)
            except CorruptFile as error:
                raise CorruptFile(self._path, at, error.fault) from error
            yield from inside
            at = file.tell()
