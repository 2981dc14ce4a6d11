"""Topics and messages of a ROS 1 bag or an MCAP file from its first byte on, without its index.

A record that is cut or damaged raises `CorruptFile` after all that is before it, the whole messages
of a chunk that is cut among them. A chunk that is whole but damaged loses its own messages: behind
the damage an error is yielded in their place. No size in the file is believed: no more is unpacked
than `MAX_RATIO` allows. Source: wiki.ros.org/Bags/Format/2.0 and mcap.dev/spec.
"""

from __future__ import annotations

import importlib
import io
import struct
import zlib
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from asap.io.errors import HARMLESS, MAX_RATIO, CorruptFile

_MODULES = {  # that unpack: the first that is there
    "bz2": ("bz2",),
    "lz4": ("lz4.frame",),
    "zstd": ("compression.zstd", "backports.zstd", "zstandard"),
}


class Channel(NamedTuple):
    """A topic begins."""

    number: int
    topic: str
    type: str


class Message(NamedTuple):
    """A message as it was recorded."""

    channel: int
    data: bytes


class _Damage(NamedTuple):
    """A chunk is damaged; the next record is behind it."""

    fault: str


Records = Iterator[Channel | Message | CorruptFile]
_Parts = Iterator[Channel | Message | _Damage]


def rosbag1_records(path: Path) -> Records:
    """Walk a ROS 1 bag of version 2.0."""
    return _walk(path, len(b"#ROSBAG V2.0\n"), _rosbag1_record)


def mcap_records(path: Path) -> Records:
    """Walk an MCAP file: its topics of ROS 2 messages."""
    return _walk(path, len(b"\x89MCAP0\r\n"), partial(_mcap_record, {}))


class _Broken(Exception):
    """The bytes are none of the format."""


_FAULTS = (_Broken, KeyError, ValueError, struct.error)


class _Source:
    """Bytes from the front of a file or a chunk; `left` are still promised."""

    def __init__(self, file: Any, left: int, is_chunk: bool = False) -> None:
        self._file, self.left, self.is_chunk = file, left, is_chunk

    def take(self, size: int) -> bytes:
        data = self.take_some(size)
        if len(data) < size:
            raise _Broken("a record is cut")
        return data

    def take_some(self, size: int) -> bytes:
        """As much as is there of `size` bytes."""
        if size < 0:
            raise _Broken("a record is longer than what holds it")
        try:
            data = bytes(self._file.read(min(size, self.left)))
        except Exception as error:
            if not self.is_chunk:
                raise
            raise _Broken(f"a chunk does not unpack: {error}") from error
        self.left -= len(data)
        return data

    def skip(self, size: int) -> None:
        if not 0 <= size <= self.left:
            raise _Broken("a record is cut")
        if self.is_chunk:
            self.take(size)
        else:
            self._file.seek(size, io.SEEK_CUR)
            self.left -= size

    def u32(self) -> int:
        return _u32(self.take(4))


def _walk(path: Path, start: int, read_record: Callable[[_Source], _Parts]) -> Records:
    with path.open("rb") as file:
        file.seek(start)
        source = _Source(file, max(path.stat().st_size - start, 0))
        while source.left:
            at = file.tell()
            try:
                for part in read_record(source):
                    yield CorruptFile(path, at, part.fault) if isinstance(part, _Damage) else part
            except _FAULTS as error:
                raise CorruptFile(path, at, _words(error)) from error


def _words(error: Exception) -> str:
    return f"a record has no field {error}" if isinstance(error, KeyError) else str(error)


# ---- ROS 1 --------------------------------------------------------------------------------------

_MESSAGE, _CHUNK, _CONNECTION = b"\x02", b"\x05", b"\x07"


def _rosbag1_record(source: _Source) -> _Parts:
    header = _fields(source.take(source.u32()))
    op, size = header["op"], source.u32()
    if op == _CHUNK:
        unpacked = _u32(header["size"])
        yield from _chunk(source, size, header["compression"].decode(), unpacked, _rosbag1_record)
    elif op == _CONNECTION:
        kind = _fields(source.take(size))["type"].decode()
        yield Channel(_u32(header["conn"]), header["topic"].decode(), kind)
    elif op == _MESSAGE:
        yield Message(_u32(header["conn"]), source.take(size))
    else:
        source.skip(size)


def rosbag1_chunk_sizes(path: Path, offsets: Iterable[int]) -> Iterator[tuple[int, int, int]]:
    """Yield offset, bytes without compression and bytes in the file of the chunks at `offsets`."""
    with path.open("rb") as file:
        for offset in offsets:
            file.seek(offset)
            source = _Source(file, path.stat().st_size - offset)
            header = _fields(source.take(source.u32()))
            yield offset, _u32(header["size"]), source.u32()


def _fields(block: bytes) -> dict[str, bytes]:
    fields, source = {}, _Source(io.BytesIO(block), len(block))
    while source.left:
        name, _, value = source.take(source.u32()).partition(b"=")
        fields[name.decode()] = value
    return fields


# ---- MCAP ---------------------------------------------------------------------------------------

_FOOTER_OP, _SCHEMA_OP, _CHANNEL_OP, _MESSAGE_OP, _CHUNK_OP = 2, 3, 4, 5, 6


def _mcap_record(schemas: dict[int, str], source: _Source) -> _Parts:
    op, size = struct.unpack("<BQ", source.take(9))
    if op == _CHUNK_OP:
        before = source.left
        source.skip(16)  # first and last time
        unpacked, checksum = struct.unpack("<QI", source.take(12))
        compression = source.take(source.u32()).decode()
        (packed,) = struct.unpack("<Q", source.take(8))
        read_record = partial(_mcap_record, schemas)
        yield from _chunk(source, packed, compression, unpacked, read_record, checksum)
        source.skip(size - (before - source.left))
    elif op == _SCHEMA_OP:
        schema = _Source(io.BytesIO(source.take(size)), size)
        (number,) = struct.unpack("<H", schema.take(2))
        schemas[number] = schema.take(schema.u32()).decode()
    elif op == _CHANNEL_OP:
        channel = _Source(io.BytesIO(source.take(size)), size)
        number, schema_number = struct.unpack("<HH", channel.take(4))
        topic, encoding = (channel.take(channel.u32()).decode() for _ in range(2))
        if encoding == "cdr":
            yield Channel(number, topic, schemas.get(schema_number, ""))
    elif op == _MESSAGE_OP:
        (number,) = struct.unpack("<H", source.take(2))
        source.skip(20)  # number in its sequence, and two times
        yield Message(number, source.take(size - 22))
    elif op == _FOOTER_OP:
        source.left = 0
    else:
        source.skip(size)


# ---- both ---------------------------------------------------------------------------------------


def _chunk(
    source: _Source,
    size: int,
    compression: str,
    unpacked: int,
    read_record: Callable[[_Source], _Parts],
    checksum: int = 0,
) -> _Parts:
    """Walk the records in the next `size` bytes, which are `unpacked` without compression."""
    packed = source.take_some(size)
    is_cut = len(packed) < size
    if source.is_chunk:
        raise _Broken("a chunk is inside a chunk")
    if unpacked > max(HARMLESS, MAX_RATIO * len(packed)):
        raise _Broken(f"a chunk of {len(packed)} bytes promises {unpacked}")
    try:
        inside = _Source(_open(compression, packed), unpacked, is_chunk=True)
        if checksum and not is_cut:
            content = inside.take(unpacked)
            if zlib.crc32(content) != checksum:
                raise _Broken("the checksum of a chunk is another")
            inside = _Source(io.BytesIO(content), unpacked, is_chunk=True)
        while inside.left:
            yield from read_record(inside)
    except _FAULTS as error:
        if is_cut:
            raise
        yield _Damage(_words(error))


def _open(compression: str, packed: bytes) -> Any:
    if compression in ("", "none"):
        return io.BytesIO(packed)
    for name in _MODULES.get(compression, ()):
        try:
            return importlib.import_module(name).open(io.BytesIO(packed), "rb")
        except ImportError:
            pass
    raise _Broken(f"nothing here unpacks a chunk in {compression!r}")


def _u32(value: bytes) -> int:
    return int(struct.unpack("<I", value)[0])
