"""Formats that the native core decodes: one reader for all of them.

A format is a row of `FORMATS`: its name, and a function that reads the header and says where the
records begin and which decoder takes them. The file is read in pieces into one buffer.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from asap import _core
from asap.events import EVENT_DTYPE, Events
from asap.io.errors import CorruptFile, UnsupportedFormat
from asap.io.reader import CHUNK, Losses, Options

__all__ = ["FORMATS", "Layout", "NativeReader"]

HEAD = 1 << 20  # bytes that a header may take
_PIECE = 1 << 18


class Decoder(Protocol):
    """What the classes of ``_core`` that decode bytes have in common."""

    def decode_into(self, bytes: memoryview, out: Events) -> tuple[int, int]:
        """Return the bytes consumed and the events written."""
        ...

    @property
    def unfinished(self) -> int:
        """Bytes of a record that waits for its end."""
        ...

    @property
    def bad_records(self) -> int:
        """How many records are none."""
        ...

    @property
    def noted(self) -> tuple[int, ...]:
        """Byte offsets of the first bad records."""
        ...


@dataclass(frozen=True)
class Layout:
    """What a header says."""

    start: int  # byte of the first record
    make: Callable[[], Decoder]
    width: int | None = None
    height: int | None = None


class NativeReader:
    """The events of a file of `format`, a row of `FORMATS`."""

    def __init__(self, format: str, path: Path, options: Options) -> None:
        self.format = format
        self._path = path
        with path.open("rb") as file:
            head = file.read(HEAD)
        self._layout = layout = FORMATS[format](path, head)
        self.width, self.height = layout.width, layout.height

    def chunks(self, losses: Losses) -> Iterator[Events]:
        """Decode piece by piece; an array goes out when it is full."""
        decoder = self._layout.make()
        buffer = memoryview(bytearray(_PIECE))
        out, filled, position = np.empty(CHUNK, EVENT_DTYPE), 0, self._layout.start
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
                        out, filled = np.empty(CHUNK, EVENT_DTYPE), 0
                self._count(decoder, losses)
        yield out[:filled]
        if decoder.unfinished:
            losses.truncated(
                position - decoder.unfinished,
                f"the last record is cut: {decoder.unfinished} bytes of it are there",
            )

    def _count(self, decoder: Any, losses: Losses) -> None:
        losses.bad_record = decoder.bad_records
        losses.bad_offsets = list(decoder.noted)
        if losses.bad_offsets and losses.on_bad == "raise":
            offset = losses.bad_offsets[0]
            raise CorruptFile(self._path, offset, f"no record of a file in {self.format}")
        losses.take_triggers(decoder)


def _raw(encoding: str, path: Path, head: bytes) -> Layout:
    """Words of that encoding, after a header or without one."""
    header = _core.read_raw_header(head) or {}
    if header.get("words") and header["words"] != encoding:
        raise CorruptFile(path, 0, f"the header says {header['words']}, not {encoding}")
    start, little_endian = header.get("size", 0), header.get("little_endian", False)
    make: dict[str, Callable[[], Decoder]] = {
        "evt2": lambda: _core.Evt2Decoder(first_offset=start),
        "evt21": lambda: _core.Evt21Decoder(little_endian=little_endian, first_offset=start),
        "evt3": lambda: _core.Evt3Decoder(first_offset=start),
    }
    return Layout(start, make[encoding], header.get("width"), header.get("height"))


def _dat(path: Path, head: bytes) -> Layout:
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
        lambda: _core.DatDecoder(version=version, first_offset=start),
        header["width"],
        header["height"],
    )


FORMATS: dict[str, Callable[[Path, bytes], Layout]] = {
    "evt2": partial(_raw, "evt2"),
    "evt21": partial(_raw, "evt21"),
    "evt3": partial(_raw, "evt3"),
    "dat": _dat,
}
