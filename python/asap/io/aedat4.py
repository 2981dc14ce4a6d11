"""AEDAT4, through the package ``aedat`` (extra ``aedat4``).

The library decodes; we walk the packet headers beside it, to say at which byte a file ends too
early or breaks.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from asap.events import Events
from asap.io.columns import events_of
from asap.io.errors import CorruptFile, foreign, library
from asap.io.reader import Losses, Options, choose_stream

__all__ = ["Aedat4Reader"]

_HEADER_AT = len(b"#!AER-DAT4.0\r\n")


class Aedat4Reader:
    """The event stream of an AEDAT4 file; width and height stand in the file."""

    format = "aedat4"

    def __init__(self, path: Path, options: Options) -> None:
        self._path = path
        self._options = Options(order=None, time_unit=options.time_unit)
        self._streams = streams = self._decoder().id_to_stream()
        events = sorted(key for key, stream in streams.items() if stream["type"] == "events")
        if not events:
            found = ", ".join(stream["type"] for stream in streams.values()) or "none"
            raise CorruptFile(
                path, _HEADER_AT, f"a stream of events is needed, streams found: {found}"
            )
        self.streams = tuple(map(str, events))
        words = [f"{key} ({streams[key]['width']}x{streams[key]['height']})" for key in events]
        self._stream = int(choose_stream(path, options.stream, self.streams, words))
        self.width: int | None = streams[self._stream]["width"]
        self.height: int | None = streams[self._stream]["height"]

    def chunks(self, losses: Losses) -> Iterator[Events]:
        """Decode packet by packet."""
        packets = iter(self._decoder())
        count = 0
        for offset, stream in _packets(self._path):
            if stream is None:
                losses.truncated(offset, "no whole packet follows")
                return
            if stream not in self._streams:  # the library skips it
                continue
            try:
                with foreign(self._path, offset):
                    packet = next(packets, None)
            except CorruptFile as error:
                losses.truncated(offset, error.fault)
                return
            if packet is None:
                losses.truncated(offset, "the library reads no further")
                return
            if packet["stream_id"] == self._stream and "events" in packet:
                rows = packet["events"]
                yield events_of(rows, self._options, losses, count)
                count += len(rows)

    def _decoder(self) -> Any:
        aedat = library("aedat", "AEDAT4", "aedat4")
        with foreign(self._path, _HEADER_AT):
            return aedat.Decoder(str(self._path))


def _packets(path: Path) -> Iterator[tuple[int, int | None]]:
    """Offset and stream of each packet; None as the stream where the chain of packets breaks."""
    size = path.stat().st_size
    with path.open("rb") as file:
        file.seek(_HEADER_AT)
        header = file.read(4)
        (length,) = struct.unpack("<I", header.ljust(4, b"\0"))
        end = _table_position(file.read(min(length, size)))
        at = _HEADER_AT + 4 + length
        last = end if 0 < end <= size else size
        while at + 8 <= last:
            file.seek(at)
            stream, length = struct.unpack("<ii", file.read(8))
            if length < 0 or at + 8 + length > last:
                break
            yield at, stream
            at += 8 + length
        if at != (end if end > 0 else size):
            yield at, None


def _table_position(header: bytes) -> int:
    """Where the packets end: field 1 of the flatbuffer; -1 if the file was never closed."""
    try:
        (root,) = struct.unpack_from("<I", header, 0)
        (to_table,) = struct.unpack_from("<i", header, root)
        table = root - to_table
        (table_size,) = struct.unpack_from("<H", header, table)
        (field,) = struct.unpack_from("<H", header, table + 6) if table_size >= 8 else (0,)
        return int(struct.unpack_from("<q", header, root + field)[0]) if field else -1
    except struct.error:
        return -1
