"""A recording: the events of a file in chunks, every one checked."""

from __future__ import annotations

import importlib
import os
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from asap import _checks, _core, _units
from asap.events.order import Slice, by_count, by_time, sorted_within, within
from asap.events.values import HEAD, MAX, Events, plain_view, unit_doubt
from asap.io.errors import LossWarning, NoGoodEvent
from asap.io.native import NativeReader
from asap.io.parts import PartsReader
from asap.io.reader import Losses, Options, Reader, Room, gathered, new_room
from asap.io.sniff import format_of, parts_of


def _late(module: str, reader: str) -> Callable[..., Reader]:
    """Return what makes that reader; its module is imported when it is first used."""

    def make(*arguments: Any, **more: Any) -> Reader:
        made = getattr(importlib.import_module(f"asap.io.{module}"), reader)
        return cast(Reader, made(*arguments, **more))

    return make


_BAGS = ("rosbag1", "rosbag2", "mcap")
_READERS: dict[str, Callable[..., Reader]] = {
    "npy": _late("numpy_files", "NpyReader"),
    "npz": _late("numpy_files", "NpzReader"),
    "text": _late("text", "TextReader"),
    "csv": _late("text", "TextReader"),
    "aedat4": _late("aedat4", "Aedat4Reader"),
    **{name: partial(NativeReader, name) for name in _core.RECORDING_FORMATS},
    "hdf5": _late("hdf5", "Hdf5Reader"),
    "matlab": _late("matlab", "MatlabReader"),
    **{name: partial(_late("ros", "RosReader"), name) for name in _BAGS},
}
_SLACK_US = 10_000  # disorder that does not mislead the search for a time
FILE_FORMATS = tuple(_READERS)  # names that `file_format` takes


Paths = str | os.PathLike[str] | Sequence[str | os.PathLike[str]]


def _opened(paths: Sequence[Path], file_format: str | None, options: Options) -> Reader:
    """Return the reader of one recording, in one file or in several."""
    name = format_of(paths[0], file_format, _READERS)
    make = _READERS[name]
    is_bag = name in _BAGS
    if paths[0].is_dir() and not is_bag and len(paths) == 1:
        paths = parts_of(paths[0])
    if len(paths) == 1:
        return make(paths[0], options)
    for path in paths:
        if (other := format_of(path, file_format, _READERS)) != name:
            raise ValueError(f"path = {path}: {other}, but {paths[0]} is {name}; give one format")
    if is_bag:
        return make(paths[0], options, parts=paths)
    return PartsReader(make, paths, options)


class Recording:
    """Events of a file, read in chunks and checked; iterate it as often as you like.

    Iterating yields arrays in ``EVENT_DTYPE`` of shape (n,), n > 0: x, y in px, p 1 = ON or 0, t in
    us and never decreasing. A clock that jumps back by 1 s or more starts a new epoch: time
    continues 1 us after the last event.

    Made by `read`.
    """

    def __init__(self, path: Paths, file_format: str | None, options: Options) -> None:
        named = list(path) if isinstance(path, (list, tuple)) else [path]
        paths = [_checks.folder_or_file("path", one) for one in named]
        if not paths:
            raise ValueError("path = []: give one file at least")
        self._path = paths[0]
        self._arguments, self._options = (path, file_format, options), options
        width, height = _checks.sides(options.width, options.height)
        self._reader = _opened(paths, file_format, replace(options, width=width, height=height))
        if options.stream is not None and not self.streams:
            remedy = f"{self._path} is one stream of events; leave stream out"
            raise ValueError(_checks.named("stream", options.stream, remedy))
        self._width, self._height = _checks.sensor(width, height, self._reader, self._path)
        self._room: Room = new_room
        self._window_us: tuple[int, int] | None = None
        self._losses, self._validator = self._books()

    def __reduce__(self) -> Any:
        """Pickle it by its path and what it was told, not by what it has counted."""
        return type(self), self._arguments

    @property
    def path(self) -> Path:
        """Where the file is."""
        return self._path

    @property
    def format(self) -> str:
        """Name of the format, such as ``"npy"``, ``"csv"``, ``"aedat4"`` or ``"evt3"``."""
        return self._reader.format

    @property
    def width(self) -> int | None:
        """Width of the sensor in px: from the file, else as given, else None (x is not checked)."""
        return self._width

    @property
    def height(self) -> int | None:
        """Height of the sensor in px: from the file, else as given, else None."""
        return self._height

    @property
    def streams(self) -> tuple[str, ...]:
        """Names of the streams of events in the file; empty where the format knows none."""
        return tuple(getattr(self._reader, "streams", ()))

    @property
    def received(self) -> int:
        """Events read so far in the latest iteration: those yielded plus all of `rejected`."""
        return self._validator.received + sum(self._losses.rejected.values())

    @property
    def rejected(self) -> dict[str, int]:
        """Events that were dropped so far in the latest iteration, by reason."""
        before = self._losses.rejected
        return {
            reason: count + before.get(reason, 0)
            for reason, count in self._validator.rejected.items()
        }

    @property
    def lost_packets(self) -> int:
        """Packets that never arrived, as the numbers of the others say; only ROS bags have them."""
        return self._losses.lost_packets

    @property
    def _doubt(self) -> str | None:
        """Why most events of the latest iteration were bad, and what may help; None if not."""
        good = self.received - sum(self.rejected.values())
        if good >= self.received / 2:
            return None
        received = _units.count(self.received)
        what = f"only {_units.count(good)} of its {received} events are good"
        if good == 0:
            what = f"not one of its {received} events is good"
        remedy = "check order, time_unit, width and height"
        if 2 * self._losses.between_pixels > self._losses.bad_record:
            remedy = "x and y lie between pixels; on_bad='clamp' moves each to the nearest pixel"
        elif self.bad_offsets:
            remedy = f"the first bad one is at byte {self.bad_offsets[0]}; {remedy}"
        return f"{self._path}: {what} ({_units.reasons(self.rejected)}); {remedy}"

    @property
    def repaired(self) -> dict[str, int]:
        """Events changed so far: polarity not 0 or 1, timestamps lifted, pixels clamped."""
        kinds = dict(self._validator.repaired)
        kinds["clamped_positions"] += self._losses.clamped_positions
        kinds["sorted_stamps"] = self._losses.sorted_stamps
        return kinds

    @property
    def expected(self) -> int:
        """How many events the file promises, or may hold by its size; 0 where it does not say."""
        return int(getattr(self._reader, "expected", 0))

    @property
    def clock_resets(self) -> int:
        """How often the sensor's clock jumped back by 1 s or more."""
        return self._validator.clock_resets

    @property
    def bad_offsets(self) -> tuple[int, ...]:
        """Byte offsets of the first bad records, where the format knows them."""
        return tuple(self._losses.bad_offsets)

    @property
    def truncated_at(self) -> int | None:
        """Byte offset where the file ended too early, None if it did not."""
        return None if self._losses.cut is None else self._losses.cut.offset

    @property
    def triggers(self) -> npt.NDArray[np.void]:
        """External triggers seen so far in the latest iteration; only native formats have them.

        Fields ``t`` in us, as the file states it, ``id`` of the input and ``value``: 1 = rising
        edge or 0. The first 2^20 at least; `trigger_count` counts all. With a window of time:
        those within it.
        """
        seen = np.concatenate([np.empty(0, _core.TRIGGER_DTYPE), *self._losses.trigger_arrays])
        if self._window_us is None:
            return seen
        begin_us, end_us = self._window_us
        return seen[(seen["t"] >= begin_us) & (seen["t"] < end_us)]

    @property
    def trigger_count(self) -> int:
        """How many external triggers were seen so far in the latest iteration."""
        return self._losses.triggers if self._window_us is None else len(self.triggers)

    def __iter__(self) -> Iterator[Events]:
        start, stop = self._options.start, self._options.stop
        if not self._options.is_window:
            yield from self._checked()
            return
        first_us = next((int(chunk["t"][0]) for chunk in self._checked()), 0)
        begin_us = first_us + round(1e6 * (start or 0.0))
        end_us = MAX if stop is None else first_us + round(1e6 * stop)
        self._window_us = begin_us, end_us
        is_empty = True
        for events in within(self._checked(begin_us), begin_us, end_us):
            is_empty = False
            yield events
        if is_empty:
            until = "its end" if stop is None else f"{stop:g} s"
            words = f"no event from {start or 0:g} s to {until}; asap.info shows how long it lasts"
            warnings.warn(f"{self._path}: {words}", stacklevel=2)

    def slices(self, *, ms: float | None = None, events: int | None = None) -> Iterator[Slice]:
        """Read it in slices of `ms` milliseconds or of so many `events`; memory holds one of them.

        Slices of time follow each other without a gap, as long as `ms`, also where no event came.
        The first begins with the first event, or at `start`; the last is the one that has the last
        event. A slice of events begins with its first event and ends 1 us after its last; the last
        one may have fewer.

        Parameters
        ----------
        ms
            Length of a slice of time in ms, 0.001 at least. Where it is no whole number of us, the
            edges are rounded to 1 us, not the length: 30 slices of ``1000 / 30`` last 1 s.
        events
            Events of a slice.

        Yields
        ------
        Slice
            A named tuple ``(begin_us, end_us, events)``: ``begin_us <= t < end_us``, and an array
            of shape (n,) in ``EVENT_DTYPE``.

        Raises
        ------
        ValueError
            Neither or both are given, or one is out of its range.

        Examples
        --------
        ::

            for begin_us, end_us, events in asap.read("events.raw").slices(ms=10):
                print(begin_us, len(events))
        """
        if (ms is None) == (events is None):
            raise ValueError(f"ms = {ms}, events = {events}: one of them cuts. Give either")
        if events is not None:
            _checks.whole("events", events, 1, 2**40, "give the events of a slice")
            return by_count(iter(self), int(events))
        width_ms = _checks.number("ms", ms, 1e-3, 1e12, "give the length of a slice in ms")
        return by_time(
            iter(self),
            1e3 * width_ms,
            lambda first_us: first_us if self._window_us is None else self._window_us[0],
        )

    def _read_into(self, room: Room) -> Iterator[Events]:
        """Read it once; its chunks are good until the next one."""
        self._room = room
        return iter(self)

    def _checked(self, from_us: int | None = None) -> Iterator[Events]:
        """Read it from the start, or from a place before `from_us` where the format has one."""
        losses, validator = self._losses, self._validator = self._books()
        count, head = 0, np.zeros(1, np.int64)
        for events in self._chunks(losses, from_us):
            good, stray = validator.check_recorded(events)
            losses.stray += stray
            if len(good):
                head = head if count else good["t"][:HEAD].copy()
                count += len(good)
                yield plain_view(good)
        if losses.cut is not None and validator.received == 0:
            raise losses.cut
        if self.received and count == 0:
            raise NoGoodEvent(self._doubt)
        span_us = validator.last_us - int(head[0])
        if doubt := unit_doubt(losses.guessed_unit, count, span_us, np.diff(head)):
            warnings.warn(f"{self._path}: {'; '.join(doubt)}", stacklevel=2)
        for words in losses.said:
            warnings.warn(f"{self._path}: {words}", LossWarning, stacklevel=2)

    def _chunks(self, losses: Losses, from_us: int | None) -> Iterator[Events]:
        tolerance_us = self._options.reorder_tolerance_us
        before_us = None if from_us is None else from_us - tolerance_us - _SLACK_US
        chunks = self._reader.chunks(losses, before_us)
        if tolerance_us and self._options.on_bad != "raise":
            return sorted_within(chunks, tolerance_us, losses.count_sorted)
        return chunks

    def _raw(self) -> Iterator[Events]:
        """Read it once without the checks: what the file holds, in its own order.

        Yields
        ------
        numpy.ndarray
            Shape (n,), n > 0, ``EVENT_DTYPE``: timestamps may go back, pixels may lie outside the
            sensor; a polarity other than 0 and 1 is below 0 or above 1. Records that no event can
            hold are dropped and counted in `rejected` as ever, whatever `on_bad` is.
        """
        losses, self._validator = Losses(self._path, "drop"), self._books()[1]
        self._losses = losses
        start, stop, first_us = self._options.start, self._options.stop, None
        for events in self._reader.chunks(losses):
            if len(events) and self._options.is_window:
                first_us = int(events["t"][0]) if first_us is None else first_us
                elapsed_us = events["t"] - first_us
                later = elapsed_us >= 1e6 * (start or 0.0)
                events = events[later & (elapsed_us < 1e6 * (1e12 if stop is None else stop))]
            if len(events):
                yield plain_view(events)

    def __repr__(self) -> str:
        size = f"{self.width}x{self.height}" if self.width and self.height else "size unknown"
        return f"<Recording: {self._path}, {self.format}, {size}>"

    def _books(self) -> tuple[Losses, _core.Validator]:
        validator = _core.Validator(
            width=self._width or 0,
            height=self._height or 0,
            on_bad=self._options.on_bad,
            reorder_tolerance_us=self._options.reorder_tolerance_us,
        )
        return Losses(self._path, self._options.on_bad, room=self._room), validator


def read(
    path: Paths,
    *,
    width: int | None = None,
    height: int | None = None,
    order: str | None = None,
    time_unit: str | None = None,
    on_bad: str = "drop",
    reorder_tolerance_us: int = 0,
    file_format: str | None = None,
    stream: str | None = None,
    start: float | None = None,
    stop: float | None = None,
) -> Recording:
    """Open an event file: NumPy, text, csv, Prophesee, AEDAT, HDF5, ROS bags and others.

    The format is found by content, then by name. Nothing but the header is read yet, and in AEDAT
    2 and 3 the numbers of several cameras.

    Parameters
    ----------
    path
        The file; the folder of a ROS 2 bag, or of numbered parts of one recording; or a list of
        files, which are read in its order.
    width, height
        Size of the sensor in px, where the file does not state it. Without it pixels are not
        checked.
    order
        Order of the columns, for files without names: an arrangement of ``t``, ``x``, ``y`` and
        ``p`` such as ``"yxt"`` (without ``p`` every event is ON), and ``-`` for a column that is
        skipped. Text: the header line, else ``"txyp"``; a matrix: what its values allow.
    time_unit
        ``"s"``, ``"ms"``, ``"us"`` or ``"ns"``. None decides: for text by the header or by a
        decimal point in the times, for arrays by their type (floating: seconds). Whole numbers
        stored as floats could be both: give the unit.
    on_bad
        Events out of order, outside the sensor or unreadable: ``"drop"`` and count, ``"clamp"``
        where possible (a position to the nearest pixel), or ``"raise"``. Where timestamps do
        not fit together, the fewer ones are dropped.
    reorder_tolerance_us
        Events that come late by at most this much are sorted into their place and counted in
        `Recording.repaired`.
    file_format
        The name of the format, as `Recording.format` has it, where neither content nor file name
        tells it: ``"atis40"`` for 40-bit events, for example.
    stream
        Which camera or topic, where the file holds several: its name, or a part of it between
        slashes such as ``"left"``.
    start, stop
        Read the events from `start` until before `stop`, in s from the first event. EVT2, EVT2.1,
        DAT, npy, HDF5, AEDAT 4 and text are not read up to there.

    Returns
    -------
    Recording
        Iterate it for arrays; ``.rejected`` tells what was dropped, by reason.

    Raises
    ------
    UnsupportedFormat
        A ValueError: no reader serves this format.
    CorruptFile
        A ValueError with the byte offset: nothing can be read, or ``on_bad="raise"``.
    ValueError
        A bad option, or columns that need `order` or `time_unit`.
    OSError
        The file cannot be opened, or is a pipe, a socket or a device: save it to a file first.
    RuntimeError
        The format needs an extra that is not installed.

    Warns
    -----
    TruncatedFileWarning
        While iterating: the file ends too early, or a packet cannot be read; the rest was yielded.
    UserWarning
        The file is read as 40-bit events, by its name alone, but does not look like them; the unit
        of its times was guessed, and no camera sends events so fast or so slowly; or no event lies
        between `start` and `stop`.

    Examples
    --------
    >>> np.save("flight.npy", asap.synthetic.FlightOverChairs(duration_s=0.1).events())
    >>> recording = asap.read("flight.npy", width=346, height=260)
    >>> sum(len(events) for events in recording) == recording.received
    True
    """
    options = Options(
        order, time_unit, width, height, stream, on_bad, reorder_tolerance_us, start, stop
    )
    return Recording(path, file_format, options)


def load(
    path: Paths,
    *,
    width: int | None = None,
    height: int | None = None,
    order: str | None = None,
    time_unit: str | None = None,
    on_bad: str = "drop",
    reorder_tolerance_us: int = 0,
    file_format: str | None = None,
    stream: str | None = None,
    start: float | None = None,
    stop: float | None = None,
) -> Events:
    """Read a whole event file into one array; parameters, errors and warnings as in `read`.

    Returns
    -------
    numpy.ndarray
        Shape (N,), dtype ``EVENT_DTYPE``, t in us and never decreasing; writable.

    Warns
    -----
    LossWarning
        Events were rejected, and why; the clock was set back.

    Examples
    --------
    >>> np.save("flight.npy", asap.synthetic.FlightOverChairs(duration_s=0.1).events())
    >>> events = asap.load("flight.npy", stop=0.05)  # s from the first event
    >>> events.dtype == asap.EVENT_DTYPE, len(events) < len(asap.load("flight.npy"))
    (True, True)
    """
    options = Options(
        order, time_unit, width, height, stream, on_bad, reorder_tolerance_us, start, stop
    )
    recording = Recording(path, file_format, options)
    events = gathered(recording._read_into, 0 if options.is_window else recording.expected)
    recording._losses.tell(recording.rejected, recording.clock_resets)
    return events
