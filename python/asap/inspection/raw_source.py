"""The events to inspect, as the file or the array holds them: unchecked, in order, in blocks."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from asap._checks import sensor, sides
from asap._checks import source as check_source
from asap.events.columns import columns_of
from asap.events.values import Events, is_event_memory
from asap.io import Recording, read
from asap.io.columns import events_of
from asap.io.errors import CutFile
from asap.io.reader import Losses, Options
from asap.io.sniff import sniff
from asap.io.source import is_iterable_of_arrays, names_files

BLOCK = 1 << 16  # events in a block, at most


class RawSource:
    """A path, a recording, an array or an iterable of arrays, read once."""

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
        cut: CutFile | None = None
        if names_files(source):
            try:
                self.recording = read(
                    source, width=width, height=height, order=order, time_unit=time_unit
                )
            except CutFile as error:  # a finding
                cut = error
        elif isinstance(source, Recording):
            for name, value in (("order", order), ("time_unit", time_unit)):
                if value is not None:
                    raise ValueError(f"{name} = {value!r}: a recording is open; say it to read()")
            self.recording = source
        file = cut or self.recording
        is_stream = file is None and is_iterable_of_arrays(source)
        self.path = None if file is None else os.fspath(file.path)
        self.format = str(getattr(source, "name", "stream")) if is_stream else "array"
        if cut is not None:
            self.format = sniff(cut.path)
        elif self.recording is not None:
            self.format = self.recording.format
        # A table may have a width and a height too: those of the table.
        known = source if is_stream else self.recording
        self.width, self.height = sensor(width, height, known, self.path or self.format)
        self._chunks: Iterable[Any] = source if is_stream else (source,)
        self._losses = Losses(Path(self.format), "drop", has_plain_polarity=True, cut=cut)

    @property
    def losses(self) -> Losses:
        """What could not become an event at all, once the source has been read."""
        return self._losses if self.recording is None else self.recording._losses

    def __iter__(self) -> Iterator[Events]:
        """Blocks of up to `BLOCK` events in ``EVENT_DTYPE``; none is empty."""
        for events in self._arrays() if self.path is None else self._recorded():
            for start in range(0, len(events), BLOCK):
                yield events[start : start + BLOCK]

    def _recorded(self) -> Iterator[Events]:
        try:
            if self.recording is not None:
                yield from self.recording._raw()
        except CutFile as cut:
            self.losses.cut = cut

    def _arrays(self) -> Iterator[Events]:
        first = 0
        for chunk in self._chunks:
            if not (isinstance(chunk, np.ndarray) and is_event_memory(chunk)):
                chunk = columns_of(chunk, self._options.order)
            options = Options(None, self._options.time_unit)
            events = events_of(chunk, options, self._losses, first)
            first += len(events)
            yield events
