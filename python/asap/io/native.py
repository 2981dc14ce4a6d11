"""Formats that the native core decodes: one reader for all of them.

A format is a row of `FORMATS`: its name, and a function that reads the header and says where the
records begin and which decoder takes them. The file is read in pieces into one buffer.
"""

from __future__ import annotations

import re
import struct
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from os import SEEK_CUR
from pathlib import Path

import numpy as np
import numpy.typing as npt

from asap import _core
from asap.events import Events
from asap.io.columns import row_before
from asap.io.errors import CorruptFile, UnsupportedFormat
from asap.io.reader import CHUNK, Losses, Options, choose_stream, expected_of

_SOURCE = re.compile(r"^#Source (\d+): *(.*?)\s*$", re.MULTILINE)
HEAD = 1 << 20  # bytes that a header may take, with the records that tell the layout
_RAW_HEAD = 1 << 16
_WITH_RECORDS = ("aedat2", "aedat3", "atis40")
_PIECE = 1 << 18
_BYTES_PER_EVENT = {"evt2": 4, "evt3": 4, "es": 5, "atis40": 5}  # about; 8 in the others
_MUCH = 1 << 24
_RECORD_OF_40_BITS = 5  # bytes
_ROWS_OF_40_BITS = 240  # the largest sensor has so many; the row below it marks time
_BACK, _BACK_LEAST = 0.25, 8  # steps back in time that no recording has: a share, and so many


@dataclass(frozen=True)
class Layout:
    """What a header says."""

    start: int  # byte of the first record
    make: Callable[[int], _core._Decoder]  # of the byte where it begins
    width: int | None = None
    height: int | None = None
    streams: tuple[str, ...] = ()  # numbers of the cameras, where there are several
    #: First byte of the bytes at an offset that can be read without what comes before, and its
    #: time; None where there is none. Where a format has it, a window of time is sought.
    entry: Callable[[bytes], tuple[int, int] | None] | None = None


class NativeReader:
    """The events of a file of the format with that name, a row of `FORMATS`."""

    def __init__(self, name: str, path: Path, options: Options) -> None:
        options.refuse_stated(path, name)
        self.format = name
        self._path = path
        with path.open("rb") as file:
            head = file.read(HEAD if name in _WITH_RECORDS else _RAW_HEAD)
        self._layout = layout = FORMATS[name](path, head, options)
        self.width, self.height, self.streams = layout.width, layout.height, layout.streams
        self.expected = expected_of(path, _BYTES_PER_EVENT.get(name, 8))

    def chunks(self, losses: Losses, from_us: int | None = None) -> Iterator[Events]:
        """Decode from the first record, or from a place before `from_us`."""
        start, entry = self._layout.start, self._layout.entry
        last = (self._path.stat().st_size - start) // _PIECE
        if from_us is None or entry is None or last == 0:
            return self._decoded(losses, start)
        with self._path.open("rb") as file:

            def found(piece: int) -> tuple[int, int] | None:
                file.seek(start + piece * _PIECE)
                return entry(file.read(_PIECE))

            def time_of(piece: int) -> int | None:
                place = found(piece)
                return None if place is None else place[1]

            piece = row_before(time_of, last, from_us)
            place = found(piece) if piece else None
        return self._decoded(losses, start if place is None else start + piece * _PIECE + place[0])

    def _decoded(self, losses: Losses, position: int) -> Iterator[Events]:
        """Decode piece by piece; an array goes out when it is full."""
        decoder = self._layout.make(position)
        buffer = memoryview(bytearray(_PIECE))
        out, filled = losses.room(CHUNK), 0
        with self._path.open("rb", buffering=0) as file:
            file.seek(position)
            while size := file.readinto(buffer):
                position, at = position + size, 0
                while at < size:
                    used, written = decoder.decode_into(buffer[at:size], out[filled:])
                    at, filled = at + used, filled + written
                    if at < size:  # no room for the next record
                        self._count(decoder, losses)
                        yield out[:filled]
                        out, filled = losses.room(CHUNK), 0
                self._count(decoder, losses)
        yield out[:filled]
        if decoder.unfinished:
            losses.truncated(
                position - decoder.unfinished,
                f"the last record is cut: {decoder.unfinished} bytes of it are there",
            )

    def _count(self, decoder: _core._Decoder, losses: Losses) -> None:
        losses.take_bad_records(decoder, lambda _: f"no record of a file in {self.format}")
        losses.take_triggers(decoder)


def _raw(encoding: str, path: Path, head: bytes, options: Options) -> Layout:
    """Words of that encoding, after a header or without one."""
    header = _core.read_raw_header(head) or {}
    if header.get("words") and header["words"] != encoding:
        raise CorruptFile(path, 0, f"the header says {header['words']}, not {encoding}")
    start, little_endian = header.get("size", 0), header.get("little_endian", False)
    make: dict[str, Callable[[int], _core._Decoder]] = {
        "evt2": lambda at: _core.Evt2Decoder(first_offset=at),
        "evt21": lambda at: _core.Evt21Decoder(little_endian=little_endian, first_offset=at),
        "evt3": lambda at: _core.Evt3Decoder(first_offset=at),
    }
    words = {"evt2": (1, 0), "evt21": (2, int(little_endian))}  # of 32 bits; the one with the time
    entry = partial(_time_high, *words[encoding]) if encoding in words else None
    return Layout(start, make[encoding], header.get("width"), header.get("height"), entry=entry)


def _time_high(size: int, upper: int, piece: bytes) -> tuple[int, int] | None:
    """Find the first TIME_HIGH among words of `size` times 32 bits."""
    words = np.frombuffer(piece[: len(piece) // (4 * size) * 4 * size], "<u4")[upper::size]
    found = np.flatnonzero(words >> 28 == 8)
    return (int(found[0]) * 4 * size, int(words[found[0]] & 0xFFFFFFF) << 6) if len(found) else None


def _dat(path: Path, head: bytes, options: Options) -> Layout:
    header = _core.read_dat_header(head)
    if header is None:
        raise CorruptFile(path, 0, "no header of text lines with type and size of an event")
    start, version = header["size"], header["version"]
    kind, size = header["type"], header["event_size"]
    if kind not in (0, 12) or size != 8:
        raise UnsupportedFormat(
            f"{path}: DAT with events of type {kind} and {size} bytes: only the types 0 and 12 of "
            "8 bytes are events of pixels"
        )
    if version not in (1, 2):
        raise UnsupportedFormat(f"{path}: DAT of version {version}; what is read: 1 and 2")
    return Layout(
        start,
        lambda at: _core.DatDecoder(version=version, first_offset=at),
        header["width"],
        header["height"],
        entry=lambda piece: (0, int.from_bytes(piece[:4], "little")),
    )


def _event_stream(path: Path, head: bytes, options: Options) -> Layout:
    header = _core.read_event_stream_header(head)
    if header is None:
        raise CorruptFile(path, 0, "no whole header of Event Stream 1 or 2")
    if header["type"] != "dvs":
        raise UnsupportedFormat(
            f"{path}: Event Stream of type {header['type']} is not read; type dvs is"
        )
    height = header["height"] or options.height
    if height is None:
        raise UnsupportedFormat(
            f"{path}: this Event Stream does not state the height of its sensor, and its rows "
            "count from the bottom; give height in px, 240 for an ATIS"
        )
    return Layout(
        header["size"],
        lambda _: _core.EventStreamDecoder(version=header["version"], height=height),
        header["width"],
        height,
    )


def _atis40(path: Path, head: bytes, options: Options) -> Layout:
    doubts = _doubts_of_40_bits(path, head)
    if doubts:
        warnings.warn(
            f"{path} is read as 40-bit events, which nothing in such a file confirms, but "
            f"{' and '.join(doubts)}; if it is another format, name it with file_format",
            stacklevel=2,
        )
    return Layout(0, lambda _: _core.Atis40Decoder())


def _doubts_of_40_bits(path: Path, head: bytes) -> list[str]:
    """List what speaks against 40-bit events of an ATIS or a DVS128: length, times, rows."""
    size = path.stat().st_size
    whole = len(head) // _RECORD_OF_40_BITS * _RECORD_OF_40_BITS
    events = _core.Atis40Decoder().decode(memoryview(head)[:whole])
    doubts = []
    if size % _RECORD_OF_40_BITS:
        doubts.append(f"its {size} bytes are no multiple of {_RECORD_OF_40_BITS}")
    if len(events) == 0:
        return doubts
    back = np.count_nonzero(np.diff(events["t"]) < 0)
    if back > max(_BACK * len(events), _BACK_LEAST):
        raise CorruptFile(
            path,
            0,
            f"no 40-bit events: the time goes back {back} times in {len(events)}; if it is "
            "another format, name it with file_format",
        )
    if back * 20 > len(events):
        doubts.append(f"the time goes back {back} times in {len(events)} events")
    below = np.count_nonzero(events["y"] >= _ROWS_OF_40_BITS)
    if below:
        doubts.append(f"{below} of {len(events)} events lie below its {_ROWS_OF_40_BITS} rows")
    return doubts


_CHIPS = {  # layout of the addresses by the size of the sensor
    (240, 180): "davis",
    (346, 260): "davis",
    (208, 192): "davis",
    (640, 480): "dvs640",
    (1280, 720): "dvs1280",
    (128, 128): "davis",  # a DVS128 is known by its addresses
}
_BITS_OF_DVS640 = 21
_PACKET = struct.Struct("<hh6i")  # the header of one of AEDAT 3.1
_RIGHT_OF_TWO = 0x8000  # the bit of the addresses that marks the right one of a stereo pair


def _aedat2(path: Path, head: bytes, options: Options) -> Layout:
    header = _core.read_aedat2_header(head)
    if header is None:
        raise CorruptFile(path, 0, "no whole header of AEDAT 2.0")
    chip, start = header["chip"], header["size"]
    width, height = header["width"] or options.width, header["height"] or options.height
    if chip == "other":
        raise UnsupportedFormat(
            f"{path}: AEDAT 2.0 is read of a DAVIS, a DVXplorer, a DVS128, a DVS640 or a "
            "DVS1280x720SD; the header names another chip"
        )
    addresses = _addresses(head[start:])
    if chip == "dvs128" and header["width"] is None:  # so say its addresses
        width, height = width or 128, height or 128
        if (width, height) != (128, 128):
            chip = "unnamed"
    if chip == "unnamed" and width is not None and height is not None:
        chip = _CHIPS.get((width, height), chip)
        if chip == "dvs640" and 2 * np.count_nonzero(addresses >> _BITS_OF_DVS640) > len(addresses):
            chip = "davis"
    if chip == "unnamed" or width is None or height is None:
        known = ", ".join(f"{w} x {h} ({name})" for (w, h), name in _CHIPS.items())
        raise UnsupportedFormat(
            f"{path}: the header of this AEDAT 2.0 file does not say which chip it is of, and the "
            f"layout of its addresses depends on it; give width and height, one of {known}"
        )
    streams: dict[str, int] = {}
    camera, bits = 0, header["camera_bits"]
    if bits:
        streams = _cameras(path, start, chip, bits)
        camera = streams[choose_stream(path, options.stream, tuple(streams))]
    return Layout(
        start,
        lambda _: _core.Aedat2Decoder(
            chip=chip, width=width, height=height, camera_bits=bits, camera=camera
        ),
        width,
        height,
        tuple(streams),
    )


def _addresses(records: bytes) -> npt.NDArray[np.uint32]:
    return np.frombuffer(records[: len(records) // 8 * 8], ">u4")[::2]


def _cameras(path: Path, start: int, chip: str, bits: int) -> dict[str, int]:
    """Return the numbers of the cameras that have events, by their names; reads the whole file."""
    numbers: set[int] = set()
    no_event = 0x8000_0400 if chip == "davis" else 0x8000_8000 & ~bits
    with path.open("rb") as file:
        file.seek(start)
        while piece := file.read(_MUCH):
            addresses = _addresses(piece)
            cameras = addresses[addresses & no_event == 0] & bits
            numbers.update((np.unique(cameras) // (bits & -bits)).tolist())
    if bits == _RIGHT_OF_TWO:
        return {"left": 0, "right": 1}
    return {str(number): number for number in sorted(numbers)} or {"0": 0}


def _aedat3(path: Path, head: bytes, options: Options) -> Layout:
    header = _core.read_aedat3_header(head)
    if header is None:
        raise CorruptFile(path, 0, "no whole header of AEDAT 3.1: '#!END-HEADER' is missing")
    if not header["raw"]:
        raise UnsupportedFormat(f"{path}: compressed AEDAT 3.1 is not read; '#Format: RAW' is")
    start, size, source = header["size"], (header["width"], header["height"]), -1
    cameras = dict(_SOURCE.findall(head[:start].decode("ascii", "replace")))
    streams = _sources(path, start)
    if len(streams) > 1:
        words = [f"{number} ({cameras.get(number, 'not named')})" for number in streams]
        stream = choose_stream(path, options.stream, streams, words)
        source = int(stream)
        first = next(iter(cameras.values()), None)  # the size that is known is of it
        size = size if first is not None and cameras.get(stream) == first else (None, None)
    else:
        streams = ()
    return Layout(
        start, lambda at: _core.Aedat3Decoder(source=source, first_offset=at), *size, streams
    )


def _sources(path: Path, start: int) -> tuple[str, ...]:
    """Return the numbers of the cameras that have events, by the headers of whole packets."""
    found: set[int] = set()
    with path.open("rb") as file:
        file.seek(start)
        while len(head := file.read(_PACKET.size)) == _PACKET.size:
            kind, source, size, _, _, capacity, count, _ = _PACKET.unpack(head)
            if size < 0 or not 0 <= count <= capacity:
                break
            if kind == 1 and count:
                found.add(source)
            file.seek(size * count, SEEK_CUR)
    return tuple(map(str, sorted(found)))


FORMATS: dict[str, Callable[[Path, bytes, Options], Layout]] = {
    "evt2": partial(_raw, "evt2"),
    "evt21": partial(_raw, "evt21"),
    "evt3": partial(_raw, "evt3"),
    "dat": _dat,
    "es": _event_stream,
    "atis40": _atis40,
    "aedat2": _aedat2,
    "aedat3": _aedat3,
}
