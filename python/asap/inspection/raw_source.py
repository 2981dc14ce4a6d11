"""The events to inspect, as the file or the array holds them: unchecked, in order, in blocks."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from asap._checks import sensor, sides
from asap._checks import source as check_source
from asap.events import Events, columns_of, is_event_memory
from asap.experiment.source import is_iterable_of_arrays, names_files
from asap.io import Recording, read
from asap.io.columns import events_of
from asap.io.errors import CutFile
from asap.io.reader import PLAIN, Losses, Options
from asap.io.sniff import sniff

BLOCK = 1 << 16  # events in a block, at most


class RawSource:
    """A path, a recording, an array or an iterable of arrays, read once.

    What could not become an event at all is in `bad_records`, `out_of_bounds`, `first_bad_byte`
    and `cut_at_byte`, once it has been read.
    """

    def __init__(
        self,
        source: Any,
        *,
        width: int | None,
        height: int | None,
        order: str | None,
        time_unit: str | None,
    ) -> None:
        check_source(source)
        self._options = Options(order, time_unit)
        width, height = sides(width, height)
        self.recording: Recording | None = None
        self._cut: CutFile | None = None
        if names_files(source):
            try:
                self.recording = read(
                    source, width=width, height=height, order=order, time_unit=time_unit
                )
            except CutFile as cut:  # a finding
                self._cut = cut
        elif isinstance(source, Recording):
            for name, value in (("order", order), ("time_unit", time_unit)):
                if value is not None:
                    raise ValueError(f"{name} = {value!r}: a recording is open; say it to read()")
            self.recording = source
        is_file = self.recording is not None or self._cut is not None
        is_stream = not is_file and is_iterable_of_arrays(source)
        # A table may have a width and a height too: those of the table.
        known = source if is_stream else self.recording
        self.format = self.recording.format if self.recording is not None else "array"
        if self._cut is not None:
            self.format = sniff(self._cut.path)
        if is_stream:
            self.format = str(getattr(source, "name", "stream"))
        self.width, self.height = sensor(width, height, known, self.path or self.format)
        self._chunks: Iterable[Any] = source if is_stream else (source,)
        self._losses = Losses(Path(self.format), "drop", off_on=PLAIN)

    @property
    def path(self) -> str | None:
        """Where the file is; None for what is no file."""
        file = self._cut or self.recording
        return os.fspath(file.path) if file is not None else None

    @property
    def bad_records(self) -> int:
        """Records that no event can hold."""
        return self._rejected("bad_record")

    @property
    def out_of_bounds(self) -> int:
        """Pixels that no event can hold."""
        return self._rejected("out_of_bounds")

    @property
    def lost_packets(self) -> int:
        """Packets that never arrived."""
        return self._read_losses.lost_packets

    @property
    def between_pixels(self) -> int:
        """Bad records whose x or y is no whole number."""
        return self._read_losses.between_pixels

    @property
    def understood(self) -> list[str]:
        """How numbers were understood that could have been others."""
        return list(self._read_losses.understood)

    @property
    def _read_losses(self) -> Losses:
        return self._losses if self.recording is None else self.recording._losses

    @property
    def guessed_unit(self) -> str | None:
        """The unit of the times, where neither source nor user states it."""
        return self.recording.guessed_unit if self.recording else self._losses.guessed_unit

    @property
    def first_bad_byte(self) -> int | None:
        """Byte offset of the first bad record, where the format knows it."""
        offsets = self.recording.bad_offsets if self.recording is not None else ()
        return offsets[0] if offsets else None

    @property
    def cut_at_byte(self) -> int | None:
        """Byte offset where the file ended too early, None if it did not."""
        if self._cut is not None:
            return self._cut.offset
        return self.recording.truncated_at if self.recording is not None else None

    def __iter__(self) -> Iterator[Events]:
        """Blocks of up to `BLOCK` events in ``EVENT_DTYPE``; none is empty."""
        for events in self._recorded() if self._cut or self.recording else self._arrays():
            for start in range(0, len(events), BLOCK):
                yield events[start : start + BLOCK]

    def _recorded(self) -> Iterator[Events]:
        try:
            if self.recording is not None:
                yield from self.recording.raw()
        except CutFile as cut:
            self._cut = cut

    def _arrays(self) -> Iterator[Events]:
        first = 0
        for chunk in self._chunks:
            if not (isinstance(chunk, np.ndarray) and is_event_memory(chunk)):
                chunk = columns_of(chunk, self._options.order)
            options = Options(None, self._options.time_unit)
            events = events_of(chunk, options, self._losses, first)
            first += len(events)
            yield events

    def _rejected(self, reason: str) -> int:
        if self.recording is not None:
            return self.recording.rejected[reason]
        return int(getattr(self._losses, reason))
