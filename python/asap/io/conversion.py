"""convert: a recording in another format, piece by piece, in flat memory."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from asap import _checks, _core
from asap.events import Events
from asap.io.reader import losses_of
from asap.io.source import Source
from asap.io.writers import (
    Writer,
    replacing,
    write_aedat4,
    write_dsec,
    write_encoded,
    write_evt3,
    write_mcap,
    write_npy,
    write_npz,
)

__all__ = ["WRITERS", "convert", "format_of", "in_order", "losses"]

WRITERS: dict[str, Writer] = {
    "npy": write_npy,
    "npz": write_npz,
    **{name: partial(write_encoded, name) for name in ("csv", "es")},
    "evt3": write_evt3,
    "aedat4": write_aedat4,
    "mcap": write_mcap,
    "dsec": write_dsec,
}

_WITH_TRIGGERS = ("evt3",)
_STATE_SENSOR = {"es": "Event Stream", "aedat4": "AEDAT 4"}
_SUFFIXES = {f".{name}": name for name in WRITERS if name != "dsec"}
_SUFFIXES |= {".raw": "evt3", ".h5": "dsec", ".hdf5": "dsec"}


def convert(
    source: Any,
    path: str | os.PathLike[str],
    *,
    to: str | None = None,
    relative: bool = False,
    width: int | None = None,
    height: int | None = None,
    start: float | None = None,
    stop: float | None = None,
) -> int:
    """Write a recording in another format; timestamps stay as they are, but for clock resets.

    Memory stays flat, and an error leaves no half file: an older one of this name stays.

    Parameters
    ----------
    source : path, Recording, array or iterable of arrays
        Arrays in any layout that `as_events` accepts. A file whose columns or unit have to be said
        is opened with `read`.
    path
        The file to write.
    to : {"npz", "npy", "csv", "es", "evt3", "aedat4", "mcap", "dsec"}
        The format. Default: the suffix of `path`; ``.raw`` is EVT3, ``.h5`` the HDF5 of DSEC, which
        counts from ``t_offset``, the first event, is packed by gzip and needs the extra ``hdf5``.
        MCAP (extra ``ros``) holds messages of event_camera_msgs in EVT3, one per ms of the events'
        time. AEDAT 4 needs the extra of the same name.
    relative
        Count the time from the first event. EVT3, MCAP and Event Stream cannot hold Unix time.
    width, height : int, optional
        Sensor, px. Default: from the file. Event Stream and AEDAT 4 need them; ``npy`` and ``csv``
        have no place for them.
    start, stop : float, optional
        Write a file's events from `start` until before `stop`, in s from the first event.

    Returns
    -------
    int
        How many events were written.

    Raises
    ------
    ValueError
        A bad argument; an event that the format cannot hold, with its number; in arrays, a
        timestamp that goes back. Of a file such events are left out, with a warning.
    UnsupportedFormat, CorruptFile, NoGoodEvent, OSError, RuntimeError
        As in `read`.

    Warns
    -----
    UserWarning
        Losses of the written file: events that were rejected, external triggers, and jumps of
        the clock, after which time continues 1 us after the last event.

    Examples
    --------
    >>> asap.convert("flight.aedat4", "flight.raw", relative=True)  # doctest: +SKIP
    117667
    """
    target = _checks.new_file("path", path)
    if target.exists() and not target.is_file():
        raise ValueError(_checks.named("path", str(path), "is no regular file; give another"))
    to = format_of(target, to)
    _checks.flag("relative", relative)
    stream = Source(source, width=width, height=height, on_bad="drop", start=start, stop=stop)
    for side, size in (("width", stream.width), ("height", stream.height)):
        if to in _STATE_SENSOR and size is None:
            remedy = f"{_STATE_SENSOR[to]} states its sensor; give width and height in px"
            raise ValueError(_checks.named(side, None, remedy))
    if stream.recording is not None:
        _checks.other_file("path", target, stream.recording.path)
    with replacing(target) as file:
        chunks = in_order(stream, relative=relative)
        write = WRITERS[to]
        if to in _WITH_TRIGGERS:
            write = partial(write, triggers=partial(_triggers, stream, relative=relative))
        count = write(file, chunks, stream.width or 0, stream.height or 0)
    for loss in losses(stream, to, relative=relative):
        warnings.warn(f"{target}: {loss}", stacklevel=2)
    return count


def format_of(path: Path, to: str | None) -> str:
    """Return the name of the format to write."""
    if to is not None:
        _checks.choice("to", to, WRITERS)
        return to
    try:
        return _SUFFIXES[path.suffix.lower()]
    except KeyError:
        remedy = f"its suffix names no format; choose one of {', '.join(WRITERS)}"
        raise ValueError(_checks.named("path", str(path), remedy)) from None


def _triggers(stream: Source, *, relative: bool) -> npt.NDArray[np.void]:
    """Return the external triggers that have been read, on the axis of the written events."""
    recording = stream.recording
    triggers = np.empty(0, _core.TRIGGER_DTYPE) if recording is None else recording.triggers
    if relative:
        triggers["t"] -= stream.first_us or 0
        triggers = triggers[triggers["t"] >= 0]
    return triggers


def losses(stream: Source, to: str | None = None, *, relative: bool = False) -> Iterator[str]:
    """Say what does not go on of the recording, into a file of this format or elsewhere."""
    yield from losses_of(stream.rejected, stream.clock_resets)
    seen = stream.recording.trigger_count if stream.recording is not None else 0
    if to in _WITH_TRIGGERS and stream.recording is not None:
        seen -= len(_triggers(stream, relative=relative))
    if seen:
        yield f"without {seen} external triggers"


def in_order(stream: Source, *, relative: bool) -> Iterator[Events]:
    """Refuse what only a source that is no file can have: a stamp that goes back, a bad pixel."""
    first_us: int | None = None
    last_us = 0
    for events in stream:
        t = events["t"]
        if first_us is None:
            first_us = last_us = int(t[0])
        steps_us = np.diff(t, prepend=last_us)
        if steps_us.min() < 0:
            at = int(np.argmax(steps_us < 0))
            number = stream.events - len(events) + at
            raise ValueError(
                f"t = {t[at]} (event {number}): goes back by {-steps_us[at]} us; sort the events"
            )
        last_us = int(t[-1])
        _check_pixels(events, stream)
        if relative:
            events = events.copy()
            events["t"] -= first_us
        yield events


def _check_pixels(events: Events, stream: Source) -> None:
    for axis, side, size in (("x", "width", stream.width), ("y", "height", stream.height)):
        if size and int(events[axis].max()) >= size:
            at = int(np.argmax(events[axis] >= size))
            number = stream.events - len(events) + at
            raise ValueError(
                f"{axis} = {events[axis][at]} (event {number}): outside the sensor, "
                f"{side} = {size}; give the sensor's own {side}"
            )
