"""A recording that outlives its process: a file that can be read while it is written."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator
from itertools import count
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Any

from asap import _core
from asap.events import Events, as_events
from asap.io import read
from asap.io.conversion import WRITERS, convert, format_of
from asap.io.writers import Growing

_GROWING = ("npy", "csv", "es", "evt3", "aedat4")  # can be read while they are written
_MAX_PACKETS = 1000  # waiting for the disk
_PIECE = 1 << 12  # events: the most that a full disk takes of what it could hold


class Recorder:
    """A thread that writes packets; a full queue never holds the camera up.

    What it writes stands beside `path` and takes that name in the end. A format that cannot be read
    before it is whole is converted then, from an array of events.
    """

    def __init__(self, path: Path, width: int, height: int) -> None:
        to = format_of(path, None)
        with NamedTemporaryFile(dir=path.parent) as trial:  # what is missing is told now
            WRITERS[to](trial, iter(()), width, height)
        self.path, self._size = path, (width, height)
        self._is_final = to in _GROWING
        self._write_all = WRITERS[to if self._is_final else "npy"]
        self._file = _part_of(path, path.suffix if self._is_final else ".npy")
        self._part = Path(str(self._file.name))
        self._written = self._end = self._refused = self._lost = 0
        self._error: Exception | None = None
        self._validator = _core.Validator(width=width, height=height, on_bad="drop")
        self._queue: queue.Queue[Any] = queue.Queue(_MAX_PACKETS)
        self._thread = threading.Thread(target=self._write, name=f"asap writes {path.name}")
        self._thread.start()

    @property
    def is_open(self) -> bool:
        """Whether it has to be closed."""
        return not self._file.closed

    @property
    def not_recorded(self) -> int:
        """How many events are not in the file."""
        return self._refused + self._lost

    def put(self, events: Any) -> None:
        """Hand a packet over."""
        try:
            self._queue.put_nowait(events)
        except queue.Full:
            self._refused += len(events)

    def _good(self) -> Iterator[Events]:
        while (events := self._queue.get()) is not None:
            self._lost += len(events)
            good = self._validator.check(as_events(events))
            for begin in range(0, len(good) if self._error is None else 0, _PIECE):
                piece = good[begin : begin + _PIECE]
                yield piece  # the next is asked for when this one is in the file
                self._lost -= len(piece)
                self._written += len(piece)
                self._end = self._file.tell()

    def _write(self) -> None:
        good = self._good()
        try:
            self._write_all(self._file, good, *self._size)
        except Exception as error:
            self._error = error
            self._file.truncate(self._end)  # to whole pieces, those that are counted
            for _ in self._good():
                pass

    def close(self, *, replaces: bool) -> tuple[Path | None, str | None]:
        """Finish, and return the file that has the events, if there are any, and what failed."""
        self._queue.put(None)
        self._thread.join()
        self._file.close()
        if not self._written:  # an older recording of this name stays
            self._part.unlink()
            return None, f"{self.path}: not recorded: {self._error}" if self._error else None
        if self._error is None and not replaces and self.path.exists():
            return self._part, None
        try:
            if self._error is None:
                self._finish()
                return self.path, None
        except Exception as error:
            self._error = error
        what = f"{self._part} has the first {self._written} events"
        return self._part, f"{self.path}: not recorded: {self._error}; {what}"

    def _finish(self) -> None:
        if self._is_final:
            self._part.replace(self.path)
            return
        width, height = self._size
        convert(read(self._part, width=width, height=height), self.path)
        self._part.unlink()


def _part_of(path: Path, suffix: str) -> Growing:
    """Open a new file beside the path; one that is there may be all that is left of a flight."""
    for number in count(1):
        name = f"{path.stem}.part{number if number > 1 else ''}{suffix}"
        try:
            return Growing(path.with_name(name))
        except FileExistsError:
            pass
    raise AssertionError
