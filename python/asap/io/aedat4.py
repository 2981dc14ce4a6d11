"""AEDAT4: packets of flatbuffers, compressed by lz4 or zstd (extra ``aedat4``).

The flatbuffers are read here, and every offset in them is checked by ``struct`` and NumPy: the
libraries for this format follow the offsets of a damaged file out of the memory that it has.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from asap.events.values import Events, pack
from asap.io.columns import events_of, first_us, row_before
from asap.io.errors import HARMLESS, MAX_RATIO, CorruptFile, foreign, library
from asap.io.reader import CHUNK, Losses, Options, choose_stream, expected_of, sensor_size

MAGIC = b"#!AER-DAT4.0\r\n"
MAX_PIXELS = 1 << 15  # a side has at most so many
_HEADER_AT = len(MAGIC)
_USUAL_RATIO = 8  # for events; MAX_RATIO is for anything
EVENT = np.dtype(
    {
        "names": ["t", "x", "y", "p"],
        "formats": ["<i8", "<i2", "<i2", "u1"],
        "offsets": [0, 8, 10, 12],
        "itemsize": 16,
    }
)

_TYPE = "typeIdentifier"  # says what a stream holds: EVTS, FRME, IMUS, TRIG


class Aedat4Reader:
    """One stream of events of an AEDAT4 file; width and height stand in the file."""

    format = "aedat4"

    def __init__(self, path: Path, options: Options) -> None:
        options.refuse_stated(path, self.format)
        self._path = path
        self.expected = expected_of(path, 8)  # packed, most have 5 to 9
        with foreign(path, _HEADER_AT):
            header, self._first = _header(path)
            self._unpack = _unpacker(header.number(0, "<i", 0))
            self._end = header.number(1, "<q", -1)
            streams = _streams(header)
        cameras = {
            name: node for name, node in streams.items() if _attribute(node, _TYPE) == "EVTS"
        }
        if not cameras:
            found = ", ".join(_attribute(node, _TYPE) for node in streams.values()) or "none"
            raise CorruptFile(
                path, _HEADER_AT, f"a stream of events is needed, streams found: {found}"
            )
        named = _by_name(cameras)
        self.streams = tuple(named)
        sizes = {name: _size(cameras[number]) for name, number in named.items()}
        words = [f"{name} ({width}x{height})" for name, (width, height) in sizes.items()]
        wanted = options.stream
        if wanted in cameras and wanted not in named:  # the number of a stream that has a name
            wanted = next(name for name, number in named.items() if number == wanted)
        chosen = choose_stream(path, wanted, self.streams, words)
        self.width, self.height = sizes[chosen]
        self._stream = named[chosen]

    def chunks(self, losses: Losses, from_us: int | None = None) -> Iterator[Events]:
        """Decode packets; of those before `from_us` only the headers are read."""
        if from_us is None:
            return self._decoded(losses, self._first)
        places: list[int] = []
        with self._path.open("rb") as file, suppress(CorruptFile):  # told when it is reached
            for at, stream, _ in self._packets(file, self._first):
                if str(stream) == self._stream:
                    places.append(at)

        def time_of(number: int) -> int | None:
            return first_us(np.frombuffer(next(self._records(places[number])), EVENT))

        place = self._first
        with suppress(CorruptFile):  # no packet before the damage is left out
            place = places[row_before(time_of, len(places), from_us)] if places else place
        return self._decoded(losses, place)

    def _decoded(self, losses: Losses, at: int) -> Iterator[Events]:
        """Decode from that place on, and hand on many packets at once: some hold few events."""
        out, filled, count = losses.room(CHUNK), 0, 0
        cut: CorruptFile | None = None
        records = self._records(at)
        while True:
            try:
                packet = next(records, None)
            except CorruptFile as error:
                cut, packet = error, None
            if packet is None:
                break
            whole = np.frombuffer(packet, EVENT)
            for rows in (whole[first : first + CHUNK] for first in range(0, len(whole), CHUNK)):
                if filled + len(rows) > CHUNK:
                    yield out[:filled]
                    out, filled = losses.room(CHUNK), 0
                place = out[filled : filled + len(rows)]
                columns = {role: rows[role] for role in "txyp"}
                if pack(columns, normalise=False, out=place) is not None:
                    filled += len(rows)
                else:
                    yield out[:filled]
                    yield events_of(rows, Options(None, None), losses, count)
                    out, filled = losses.room(CHUNK), 0
                count += len(rows)
        yield out[:filled]
        if cut is not None:
            losses.truncated(cut.offset, cut.fault)

    def _records(self, at: int) -> Iterator[Buffer]:
        """Yield the events of the stream, packet by packet, up to the first that is damaged."""
        with self._path.open("rb") as file:
            for offset, stream, length in self._packets(file, at):
                if str(stream) != self._stream:
                    continue
                with foreign(self._path, offset):
                    if length > HARMLESS:
                        raise ValueError(f"a packet of {length} bytes")
                    records = _records_of(self._unpack(file.read(length)))
                yield records

    def _packets(self, file: Any, at: int) -> Iterator[tuple[int, int, int]]:
        """Offset, stream and length of each packet, while the file stands behind its header."""
        size = self._path.stat().st_size
        end = self._end if self._end > 0 else size  # the file may never have been closed
        while at + 8 <= min(end, size):
            file.seek(at)
            stream, length = struct.unpack("<ii", file.read(8))
            if not 0 < length <= min(end, size) - at - 8:
                break
            yield at, stream, length
            at += 8 + length
        if at != end:
            raise CorruptFile(self._path, at, "no whole packet follows")
        if self._end > 0 and not self._is_closed(file):
            raise CorruptFile(self._path, size, "the table of all packets, which ends it, is cut")

    def _is_closed(self, file: Any) -> bool:
        """Whether the table of all packets is whole; it holds no events."""
        file.seek(self._end)
        try:
            with foreign(self._path, self._end):
                table = self._unpack(file.read(HARMLESS))
        except CorruptFile:
            return False
        return len(table) >= 4 and len(table) >= 4 + int.from_bytes(table[:4], "little")


def _header(path: Path) -> tuple[Table, int]:
    """Read the header; the packets begin at the position beside it."""
    with path.open("rb") as file:
        file.seek(_HEADER_AT)
        (length,) = struct.unpack("<I", file.read(4))
        end = _HEADER_AT + 4 + length
        if end > path.stat().st_size:
            raise ValueError(f"a header of {length} bytes is promised, the file ends")
        return Table(file.read(length)), end


def _streams(header: Table) -> dict[str, ElementTree.Element]:
    """Find what the header's text says of each stream, by its number."""
    at, length = header.vector(2)
    text = bytes(header.buffer[at : at + length])
    if b"<!ENTITY" in text:  # what it stands for may be endless
        raise ValueError("the text of the header defines entities")
    nodes = ElementTree.fromstring(text).findall("./node[@name='outInfo']/node")
    return {node.get("name", ""): node for node in nodes}


def _attribute(node: ElementTree.Element, key: str) -> str:
    return node.findtext(f"./attr[@key='{key}']", "")


def _by_name(cameras: dict[str, ElementTree.Element]) -> dict[str, str]:
    """Return the number of each stream by the name of its camera or output, else by itself."""
    for path in ("./node[@name='info']/attr[@key='source']", "./attr[@key='originalOutputName']"):
        names = [node.findtext(path, "") for node in cameras.values()]
        if all(names) and len(set(names)) == len(names) > 1:
            return dict(zip(names, cameras, strict=True))
    return {number: number for number in cameras}


def _size(node: ElementTree.Element) -> tuple[int | None, int | None]:
    """Width and height, where the stream states them."""
    sides = (f"./node[@name='info']/attr[@key='{key}']" for key in ("sizeX", "sizeY"))
    return sensor_size(*map(node.findtext, sides))


def _unpacker(compression: int) -> Callable[[bytes], bytes]:
    """Return what unpacks a packet."""
    if compression == 0:
        return bytes
    if compression in (1, 2):
        lz4 = library("lz4.frame", "AEDAT4", "aedat4")
        return _bounded(lambda packed, most: lz4.LZ4FrameDecompressor().decompress(packed, most))
    if compression in (3, 4):
        zstd = library("zstandard", "AEDAT4", "aedat4")
        return _bounded(
            lambda packed, most: zstd.ZstdDecompressor().stream_reader(packed).read(most)
        )
    raise ValueError(f"compression {compression} is not known")


def _bounded(unpack: Callable[[bytes, int], bytes]) -> Callable[[bytes], bytes]:
    """Unpack no more than any good packet holds; memory for much more than usual costs time."""

    def unpack_bounded(packed: bytes) -> bytes:
        usual = min(_USUAL_RATIO * len(packed), HARMLESS)
        unpacked = unpack(packed, usual)
        if len(unpacked) < usual:
            return unpacked
        return unpack(packed, min(MAX_RATIO * len(packed), HARMLESS))

    return unpack_bounded


def _records_of(packet: bytes) -> Buffer:
    """View the one field of a packet of events: a vector of structures."""
    table = Table(memoryview(packet)[4:])
    if table.name != b"EVTS":
        raise ValueError(f"EVTS is needed, the packet is {table.name!r}")
    at, count = table.vector(0)
    records = table.buffer[at : at + count * EVENT.itemsize]
    if len(records) < count * EVENT.itemsize:
        raise ValueError(f"{count} events promised, {len(records) // EVENT.itemsize} are there")
    return records


Buffer = bytes | memoryview


class Table:
    """The root table of a FlatBuffer: fields by their number in the schema, every offset checked.

    Positions count from behind the size prefix. What lies outside raises ``struct.error``.
    """

    def __init__(self, buffer: Buffer) -> None:
        self.buffer = buffer
        self._at = self._read("<I", 0)
        self._fields = self._at - self._read("<i", self._at)
        self._size = self._read("<H", self._fields)
        self.name = bytes(self.buffer[4:8])  # the name of the schema

    def number(self, field: int, kind: str, default: int) -> int:
        """Return a field of the type `kind` of ``struct``."""
        at = self._place(field)
        return default if at is None else self._read(kind, at)

    def vector(self, field: int) -> tuple[int, int]:
        """Where the elements of a vector or a text begin, and how many there are."""
        at = self._place(field)
        if at is None:
            return 0, 0
        at += self._read("<I", at)
        return at + 4, self._read("<I", at)

    def _place(self, field: int) -> int | None:
        slot = 4 + 2 * field
        offset = self._read("<H", self._fields + slot) if slot + 2 <= self._size else 0
        return self._at + offset if offset else None

    def _read(self, kind: str, at: int) -> int:
        if at < 0:
            raise struct.error(f"offset {at} is outside the buffer")
        return int(struct.unpack_from(kind, self.buffer, at)[0])
