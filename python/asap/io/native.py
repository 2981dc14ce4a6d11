"""Files of words, which the native core opens and decodes: one reader for all their formats."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from pathlib import Path

from asap import _core
from asap.events import Events
from asap.io.columns import row_before
from asap.io.reader import CHUNK, Losses, Options, choose_stream, expected_of

_PIECE = 1 << 18


class NativeReader:
    """The events of a file of the format with that name, one of `_core.RECORDING_FORMATS`."""

    def __init__(self, name: str, path: Path, options: Options) -> None:
        options.refuse_stated(path, name)
        self.format = name
        self._path = path
        self._opened = opened = _core.OpenedRecording(
            path, name, width=options.width or 0, height=options.height or 0
        )
        if opened.doubt:
            warnings.warn(
                f"{path} is read as {opened.doubt}; if it is another format, name it with "
                "file_format",
                stacklevel=2,
            )
        self.streams, self._stream, size = (), 0, opened.size
        if opened.streams:
            self.streams, words, sizes = zip(*opened.streams, strict=True)
            chosen = choose_stream(path, options.stream, self.streams, words)
            self._stream = self.streams.index(chosen)
            size = sizes[self._stream]
        self.width, self.height = size
        self.expected = expected_of(path, opened.event_bytes)

    def chunks(self, losses: Losses, from_us: int | None = None) -> Iterator[Events]:
        """Decode from the first record, or from a place before `from_us`."""
        opened, start = self._opened, self._opened.start
        last = (self._path.stat().st_size - start) // _PIECE
        if from_us is None or not opened.has_entries or last == 0:
            return self._decoded(losses, start)
        with self._path.open("rb") as file:

            def found(piece: int) -> tuple[int, int] | None:
                file.seek(start + piece * _PIECE)
                return opened.entry(file.read(_PIECE))

            def time_of(piece: int) -> int | None:
                place = found(piece)
                return None if place is None else place[1]

            piece = row_before(time_of, last, from_us)
            place = found(piece) if piece else None
        return self._decoded(losses, start if place is None else start + piece * _PIECE + place[0])

    def _decoded(self, losses: Losses, position: int) -> Iterator[Events]:
        """Decode piece by piece; an array goes out when it is full."""
        decoder = self._opened.decoder(position, self._stream)
        buffer = memoryview(bytearray(_PIECE))
        zeros = _core.data_end(self._path)
        end = zeros or self._path.stat().st_size
        out, filled = losses.room(CHUNK), 0
        with self._path.open("rb", buffering=0) as file:
            file.seek(position)
            while size := file.readinto(buffer[: max(end - position, 0)]):
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
        if zeros:
            losses.zeros(max(zeros, self._opened.start))
        elif decoder.unfinished:
            losses.truncated(
                position - decoder.unfinished,
                f"the last record is cut: {decoder.unfinished} bytes of it are there",
            )

    def _count(self, decoder: _core.Decoder, losses: Losses) -> None:
        losses.take_bad_records(decoder, lambda _: f"no record of a file in {self.format}")
        losses.take_triggers(decoder)
