"""What `source` may be: a path, a recording, an array, or any iterable of arrays."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from asap import _core
from asap._checks import named, number, sensor
from asap._checks import source as check_source
from asap.events import Events, as_events
from asap.events.columns import is_chunk, opened
from asap.io import Recording, read

_LOOK = 256  # events in which the first good one is searched at once


class Source:
    """A stream of arrays in EVENT_DTYPE, with what is known about where it comes from.

    Iterating keeps count: `events` is how many have been handed out so far, `first_us` the stamp of
    the first good one.
    """

    def __init__(
        self,
        source: Any,
        *,
        width: int | None,
        height: int | None,
        on_bad: str,
        start: float | None = None,
        stop: float | None = None,
    ) -> None:
        if source is None:
            raise TypeError(named("source", source, "give a path, a recording or arrays of events"))
        if not hasattr(source, "__next__"):  # what comes in pieces stays a stream
            source = opened(source)
        check_source(source)
        if names_files(source):
            source = read(source, width=width, height=height, on_bad=on_bad, start=start, stop=stop)
        elif start is not None or stop is not None:
            side, value = ("stop", stop) if start is None else ("start", start)
            raise ValueError(named(side, value, "give a path; of a recording say it to read()"))
        self.recording = source if isinstance(source, Recording) else None
        self.array: Events | None = None
        self._chunks: Iterable[Any]
        self._kind = "array"
        if self.recording is not None:
            self._chunks = self.recording
        elif is_iterable_of_arrays(source):
            self._chunks = source
            self._kind = str(getattr(source, "name", "stream"))
        else:
            self.array = as_events(source)
            self._chunks = (self.array,)

        # A table may have a width and a height too: those of the table.
        known = source if self.array is None else None
        name = self._kind if self.recording is None else self.recording.path
        self.width, self.height = sensor(width, height, known, name)
        self._on_bad = on_bad
        self.events = 0
        self.first_us: int | None = None
        self._ended = False

    def __iter__(self) -> Iterator[Events]:
        for chunk in self._chunks:
            events = as_events(chunk)
            if events.size == 0:
                continue
            if self.first_us is None:
                self.first_us = self._first_good_us(events)
            self.events += events.size
            yield events
        self._ended = True

    def _first_good_us(self, events: Events) -> int | None:
        """Stamp of the first event that the runner's own validator will pass."""
        validator = _core.Validator(
            width=self.width or 0,
            height=self.height or 0,
            on_bad="clamp" if self._on_bad == "clamp" else "drop",
        )
        for begin in range(0, events.size, _LOOK):
            if (good := validator.check(events[begin : begin + _LOOK])).size:
                return int(good["t"][0])
        return None

    @property
    def sensor(self) -> tuple[int | None, int | None]:
        """Width and height in px, as far as they are known."""
        return self.width, self.height

    @property
    def total_hint(self) -> int | None:
        """How many events there will be, as soon as that is known."""
        if self.array is not None:
            return int(self.array.size)
        return self.events if self._ended else None

    @property
    def rejected(self) -> dict[str, int]:
        """Events that the reader of the file rejected, by reason."""
        return dict(self.recording.rejected) if self.recording is not None else {}

    @property
    def clock_resets(self) -> int:
        """How often the reader of the file saw the sensor's clock jump back."""
        return self.recording.clock_resets if self.recording is not None else 0

    def describe(self, received: int, last_us: int) -> dict[str, Any]:
        """Describe the source as in the JSON summary.

        Its events are those `received`, bad ones too; its last good stamp is `last_us`.
        """
        duration_us = 0 if self.first_us is None else max(last_us - self.first_us, 0)
        recording = self.recording
        return {
            "path": os.fspath(recording.path) if recording is not None else None,
            "format": recording.format if recording is not None else self._kind,
            "width": self.width,
            "height": self.height,
            "events": received,
            "duration_s": duration_us / 1e6,
        }


class CheckedStream(Source):
    """A source behind one validator for all: good events only, their stamps compressed by `speed`.

    `speed` makes a quiet recording a busy one: t becomes t0 + (t - t0) / speed in whole us, where
    t0 is the first good stamp.
    """

    def __init__(
        self,
        source: Any,
        *,
        width: int | None = None,
        height: int | None = None,
        on_bad: str = "drop",
        speed: float = 1.0,
        start: float | None = None,
        stop: float | None = None,
    ) -> None:
        self.speed = number("speed", speed, 1e-6, 1e6, "must be between 1e-6 and 1e6")
        super().__init__(source, width=width, height=height, on_bad=on_bad, start=start, stop=stop)
        self._validator = _core.Validator(
            width=self.width or 0, height=self.height or 0, on_bad=on_bad
        )
        self._begin_us: int | None = None

    def __iter__(self) -> Iterator[Events]:
        for chunk in super().__iter__():
            good = self._validator.check(chunk)
            if good.size:
                yield good if self.speed == 1.0 else self._compressed(good)

    @property
    def rejected(self) -> dict[str, int]:
        """Events that the reader of the file and the validator have rejected, by reason."""
        rejected = super().rejected
        for reason, count in self._validator.rejected.items():
            rejected[reason] = rejected.get(reason, 0) + count
        return rejected

    @property
    def clock_resets(self) -> int:
        """How often the reader of the file and the validator saw the sensor's clock jump back."""
        return super().clock_resets + self._validator.clock_resets

    def _compressed(self, events: Events) -> Events:
        if self._begin_us is None:
            self._begin_us = int(events["t"][0])
        compressed: Events = events.copy()
        elapsed_us = np.floor((events["t"] - self._begin_us) / self.speed)
        compressed["t"] = self._begin_us + elapsed_us.astype(np.int64)
        return compressed


def names_files(source: Any) -> bool:
    """Whether it is a path, or several of one recording."""
    several = source if isinstance(source, (list, tuple)) and source else [source]
    return all(isinstance(one, (str, os.PathLike)) for one in several)


def is_iterable_of_arrays(source: Any) -> bool:
    """Whether it is a stream of arrays, and not one source of events."""
    if isinstance(source, (list, tuple)):
        # Four plain columns are one source of events; arrays with fields are a chunk each.
        return bool(source) and all(item is None or is_chunk(item) for item in source)
    is_array = isinstance(source, (np.ndarray, Mapping)) or any(
        hasattr(source, name) for name in ("__array__", "to_numpy", "columns")
    )
    return isinstance(source, Iterable) and not is_array
