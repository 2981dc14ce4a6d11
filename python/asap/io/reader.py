"""What a reader of one format is, and the book it keeps while it reads."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from asap import _units
from asap._checks import named, number
from asap.events.columns import check_order
from asap.events.values import EVENT_DTYPE, Events, time_exponent
from asap.io.errors import CorruptFile, LossWarning, TruncatedFileWarning

CHUNK = 1 << 16  # events that a reader hands on at once, about
#: What names state the size of the sensor.
SIZE = re.compile("(?:sensor_|image_|img_)?(width|height|resolution|geometry|size)", re.IGNORECASE)
_MAX_EXPECTED = 1 << 28
_MAX_TRIGGERS = 1 << 20  # kept for `Recording.triggers`; the others are counted


@dataclass(frozen=True)
class Options:
    """What the user says about the file, and how it is to be read."""

    order: str | None
    time_unit: str | None
    width: int | None = None  # sensor, px
    height: int | None = None
    stream: str | None = None
    on_bad: str = "drop"
    reorder_tolerance_us: int = 0
    start: float | None = None  # s from the first event
    stop: float | None = None

    def __post_init__(self) -> None:
        if self.order is not None:
            check_order(self.order)
        if self.time_unit is not None:
            time_exponent(self.time_unit)
        if self.stream is not None and not isinstance(self.stream, str):
            raise TypeError(f"stream = {self.stream!r}: give the name of one stream of the file")
        for side, value in (("start", self.start), ("stop", self.stop)):
            if value is not None:
                number(side, value, 0.0, 1e9, "give s from the first event")
        if self.start is not None and self.stop is not None and self.stop <= self.start:
            raise ValueError(f"stop = {self.stop}: give a later time than start = {self.start}")

    @property
    def is_window(self) -> bool:
        """Whether a window of time is to be read."""
        return self.start is not None or self.stop is not None

    def refuse_stated(self, path: Path, file_format: str) -> None:
        """Refuse columns and unit where the format states both, so that none is ignored."""
        for name, value in (("order", self.order), ("time_unit", self.time_unit)):
            if value is not None:
                remedy = f"{path} is {file_format}, which states it; leave {name} out"
                raise ValueError(named(name, value, remedy))


Room = Callable[[int], Events]


def new_room(count: int) -> Events:
    """Memory for so many events."""
    return np.empty(count, EVENT_DTYPE)


_SUMS = (
    *("bad_record", "out_of_bounds", "clamped_positions", "before_start", "between_pixels"),
    *("lost_packets", "triggers", "trigger_arrays", "bad_offsets"),
)


@dataclass
class Losses:
    """What a reader could not turn into events, while it reads."""

    path: Path
    on_bad: str
    bad_record: int = 0
    out_of_bounds: int = 0
    clamped_positions: int = 0
    before_start: int = 0  # events whose time is not known yet
    stray: int = 0  # events whose timestamps do not fit those around them
    bad_offsets: list[int] = field(default_factory=list)  # where the first bad records are
    triggers: int = 0
    trigger_arrays: list[npt.NDArray[np.void]] = field(default_factory=list)  # the first of them
    cut: CorruptFile | None = None
    guessed_unit: str | None = None  # unit of the times, where neither file nor user states it
    lost_packets: int = 0  # that the numbers of those in the file skip
    between_pixels: int = 0  # of the bad records: x or y is no whole number
    has_plain_polarity: bool = False  # 0 and 1, or -1 and 1, have been seen
    sorted_stamps: int = 0  # events that came late and were sorted in
    room: Room = new_room  # memory for the events that are read next

    def count_sorted(self, events: int) -> None:
        """Count events that came late."""
        self.sorted_stamps += events

    def add(self, part: Losses) -> None:
        """Add those of a part of the recording, which is read."""
        for name in _SUMS:
            setattr(self, name, getattr(self, name) + getattr(part, name))
        self.cut = self.cut or part.cut
        self.guessed_unit = part.guessed_unit
        self.has_plain_polarity = part.has_plain_polarity

    @property
    def rejected(self) -> dict[str, int]:
        """Events that did not come to the validator, by its reasons."""
        return {
            "bad_record": self.bad_record,
            "out_of_bounds": self.out_of_bounds,
            "before_start": self.before_start,
            "nonmonotonic": self.stray,
        }

    @property
    def said(self) -> Iterator[str]:
        """Say what of the file the user would not expect."""
        if self.lost_packets:
            yield (
                f"{self.lost_packets} packets are missing, as their numbers say; events after a "
                "gap are left out until their time and row are stated again"
            )

    def take_bad_records(self, decoder: Any, fault: Callable[[int], str]) -> None:
        """Take the bad records that a native decoder met; an error if bad data raise."""
        self.bad_record, self.bad_offsets = decoder.bad_records, list(decoder.noted)
        if self.bad_offsets and self.on_bad == "raise":
            raise CorruptFile(self.path, self.bad_offsets[0], fault(self.bad_offsets[0]))

    def take_triggers(self, decoder: Any) -> None:
        """Take the triggers that a native decoder met, and count its events before the start."""
        self.before_start = decoder.before_start
        if decoder.triggers > self.triggers:
            self.triggers = decoder.triggers
            seen = decoder.take_triggers()
            if sum(map(len, self.trigger_arrays)) < _MAX_TRIGGERS:
                self.trigger_arrays.append(seen)

    def truncated(self, offset: int, fault: str) -> None:
        """Note that nothing good follows `offset`: a warning, or an error if bad data raise."""
        self.cut = CorruptFile(self.path, offset, fault)
        if self.on_bad == "raise":
            raise self.cut
        warnings.warn(f"{self.cut}; what came before was read", TruncatedFileWarning, stacklevel=2)

    def zeros(self, offset: int) -> None:
        """Note that the file holds nothing but zeros from `offset` on."""
        self.truncated(offset, "nothing but zero bytes from here to the end: it was not written")

    def tell(self, rejected: dict[str, int], clock_resets: int) -> None:
        """Warn the caller's caller of what was dropped, but not again of a record that was cut."""
        untold = rejected if self.cut is None else rejected | {"bad_record": 0}
        for loss in losses_of(untold, clock_resets):
            warnings.warn(f"{self.path}: {loss}", LossWarning, stacklevel=3)


def losses_of(rejected: dict[str, int], clock_resets: int) -> Iterator[str]:
    """Say what the events do not have of the recording that they come from."""
    if reasons := _units.reasons(rejected):
        yield f"without the events that were rejected: {reasons}"
    if clock_resets:
        yield (
            f"the clock jumped back {clock_resets} times by 1 s or more; the events after "
            "it have other timestamps than in the source: they go on 1 us after the last event"
        )


def size_of(names: Iterable[str], value: Callable[[str], Any]) -> tuple[int | None, int | None]:
    """Return the size of the sensor in px, if one of the `names`, by its `value`, states it.

    Two numbers of an array may come in either order: no sensor is higher than wide.
    """
    found: dict[str, list[Any]] = {}
    for name in names:
        if meaning := SIZE.fullmatch(name):
            found.setdefault(meaning[1].lower(), _sides(value(name)))
    if {"width", "height"} <= found.keys():
        size = sensor_size(*found["width"][:1], *found["height"][:1])
        if size != (None, None):
            return size
    pairs = (found[key] for key in ("geometry", "resolution", "size") if key in found)
    return sensor_size(*next((pair for pair in pairs if len(pair) == 2), ()))


def _sides(stated: Any) -> list[Any]:
    values: list[Any] = np.asarray(stated).reshape(-1).tolist()
    text = values[0] if len(values) == 1 else None
    if isinstance(text, (str, bytes)):
        return re.findall(
            r"\d+", text if isinstance(text, str) else text.decode("ascii", "replace")
        )
    return values[:1] if len(values) != 2 else sorted(values, reverse=True)


class Reader(Protocol):
    """The events of one file. It is opened by a path and `Options`, and may be read repeatedly."""

    format: str
    width: int | None  # sensor in px, if the file states it
    height: int | None

    def chunks(self, losses: Losses, from_us: int | None = None) -> Iterator[Events]:
        """Read events in ``EVENT_DTYPE``, order and sensor size not yet checked.

        From the start or, where the format has one, from a place before the events of `from_us`.
        """
        ...


def expected_of(path: Path, bytes_per_event: int) -> int:
    """About how many events a file has; memory that none of them takes costs nothing."""
    return min(path.stat().st_size // bytes_per_event, _MAX_EXPECTED)


def sensor_size(width: Any = None, height: Any = None) -> tuple[int | None, int | None]:
    """Return what a file states of its sensor in px, or (None, None) where no sensor is such."""
    try:
        sides = int(width), int(height)
    except (TypeError, ValueError):
        return None, None
    return sides if all(0 < side <= 65536 for side in sides) else (None, None)


def choose_stream(
    path: Path, wanted: str | None, streams: Sequence[str], words: Sequence[str] | None = None
) -> str:
    """Choose a stream of events by its name, or by a part of its path that no other one has.

    `words` describe the streams in the message, where a name alone says too little. There is at
    least one stream; `Reader.streams` lists them.
    """
    if wanted is None:
        found = list(streams)
    elif wanted in streams:
        return wanted
    else:
        part = f"/{wanted.strip('/')}/"
        found = [name for name in streams if part in f"/{name}/"]
    if len(found) == 1:
        return found[0]
    listed = ", ".join(words or streams)
    raise ValueError(
        f"stream = {wanted!r}: {path} holds {len(streams)} stream{'s' * (len(streams) > 1)} of "
        f"events ({listed}); choose one, such as stream={streams[0]!r}"
    )


_RECORD = np.dtype(f"V{EVENT_DTYPE.itemsize}")


def gathered(read: Callable[[Room], Iterable[Events]], expected: int) -> Events:
    """One array of all chunks, made for as many events as are expected; it grows if need be.

    `read` gives the chunks; it may write them where they belong in that array, one after the other.
    """
    events, count = new_room(0), 0
    with suppress(MemoryError):  # fewer may come
        events = new_room(expected + CHUNK)  # so that a last chunk has room

    def room(size: int) -> Events:
        place: Events = events[count : count + size]
        return place if len(place) == size else new_room(size)

    for chunk in read(room):
        if count + len(chunk) > len(events):
            larger = np.empty(max(2 * len(events), count + len(chunk)), EVENT_DTYPE)
            _copy(larger[:count], events[:count])
            events = larger
        place = events[count : count + len(chunk)]
        if chunk.ctypes.data != place.ctypes.data:
            _copy(place, chunk)
        count += len(chunk)
    return events[:count]  # the rest was never touched: no memory is behind it


def _copy(to: Events, source: Events) -> None:
    """Copy memory as it is: NumPy copies structured arrays field by field, six times slower."""
    to.view(_RECORD)[:] = source.view(_RECORD)
