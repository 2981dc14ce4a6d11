"""Columns of a file as events: values that no event can hold are counted, not raised."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from asap._stamps import time_exponent
from asap.events import (
    Columns,
    Events,
    columns_of,
    is_event_memory,
    misfit_message,
    misfits,
    pack,
    pack_good,
    plain_view,
)
from asap.io.errors import UnsupportedFormat, unclear_unit
from asap.io.reader import CHUNK, PLAIN, Losses, Options

_MAX_ADDRESS = 65535
_LOOKS = 32  # rows whose times must ascend before one is sought
_DAMAGED = 0.1  # share of odd polarities that is no other way to write it
# -1 in a type without a sign; the decoder of text stops at 2^15 - 1.
_MINUS_ONE = (2**8 - 1, 2**16 - 1, 2**32 - 1, 2**64 - 1, 2**15 - 1)
_PAIRS = {(1, 2): (1, 2)} | {(1, minus): (minus, 1) for minus in _MINUS_ONE}  # OFF and ON
_EVERY = 61  # later events whose polarity is looked at: a prime, against patterns


def row_before(time_of: Callable[[int], int | None], rows: int, t_us: int) -> int:
    """Find a row that is earlier than `t_us`; `time_of` reads the time at one, if one is there.

    The first row where the times of those that are looked at go back: a clock was set back.
    """
    last = max(rows - 1, 0)
    looks = sorted({last * part // _LOOKS for part in range(_LOOKS + 1)})
    seen = [(row, time) for row in looks if (time := time_of(row)) is not None]
    if any(after < before for (_, before), (_, after) in pairwise(seen)):
        return 0
    low = max((row for row, time in seen if time < t_us), default=0)
    high = min((row for row, time in seen if time >= t_us), default=rows)

    def is_later(row: int) -> bool:
        time = time_of(row)
        return time is not None and time >= t_us

    return max(bisect_left(range(rows), True, low, high, key=is_later) - 1, 0)


def first_us(events: Events) -> int | None:
    """Return the time of the first event, if there is one."""
    return int(events["t"][0]) if len(events) else None


def file_columns(
    path: Path, source: Any, order: str | None, *, first: int | None = None, exponent: int = 6
) -> Columns:
    """Find the columns; raise if the file has no such columns."""
    try:
        return columns_of(source, order, first=first, exponent=exponent)
    except TypeError as error:
        raise UnsupportedFormat(f"{path}: {error}") from error
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def events_of(source: Any, options: Options, losses: Losses, first: int = 0) -> Events:
    """Events of an array or a mapping of columns; `first` is the number of its first event.

    Without a time unit, floating times are seconds and integers microseconds; floats that begin as
    whole numbers could be both, and the user is asked.
    """
    if isinstance(source, np.ndarray) and options.time_unit is None and is_event_memory(source):
        losses.guessed_unit = "us"
        with_plain_polarity = _polarity(source["p"], losses, first)
        if with_plain_polarity is None:
            return plain_view(source)
    exponent = time_exponent(options.time_unit or "s")
    columns = file_columns(losses.path, source, options.order, exponent=exponent)
    if "p" in columns and (p := _polarity(columns["p"], losses, first)) is not None:
        columns = columns | {"p": p}
    unit = options.time_unit or ("s" if columns["t"].dtype.kind == "f" else "us")
    if options.time_unit is None:
        losses.guessed_unit = unit
        if unit == "s" and first == 0 and _all_whole(columns["t"]):
            raise unclear_unit(losses.path)
    exponent = time_exponent(unit)
    out = losses.room(len(columns["t"]))
    events = pack_good(columns, exponent, normalise=False, out=out)
    if events is not None:
        return events
    bad = {role: misfits(role, column, exponent) for role, column in columns.items()}
    found = {role: mask for role, mask in bad.items() if mask is not None and mask.any()}
    if found:
        columns = _without(columns, found, losses, first)
    return pack(columns, exponent, normalise=False)


def pieces_of(source: Any, options: Options, losses: Losses, first: int = 0) -> Iterator[Events]:
    """Convert an array or a mapping of columns piece by piece; `first` as in `events_of`."""
    is_array = isinstance(source, np.ndarray)
    count = len(source if is_array else next(iter(source.values())))
    for start in range(0, count, CHUNK):
        part = slice(start, start + CHUNK)
        piece = source[part] if is_array else {role: one[part] for role, one in source.items()}
        yield events_of(piece, options, losses, first + start)


def plain_polarity(events: Events, losses: Losses, first: int) -> Events:
    """Return the events with the polarity that their numbers mean; `first` as in `events_of`."""
    if (p := _polarity(events["p"], losses, first)) is not None:
        events["p"] = p
    return events


def _polarity(p: npt.NDArray[Any], losses: Losses, first: int) -> npt.NDArray[Any] | None:
    """Map polarity that is neither 0 and 1 nor -1 and 1, as the first events decide; None if plain.

    Raises
    ------
    ValueError
        The numbers could mean several things.
    """
    if p.dtype.kind == "b" or losses.off_on == PLAIN:
        return None
    if losses.off_on is None:
        some = p if first == 0 else p[::_EVERY]
        losses.off_on = _off_on(some[some == some], losses.path, first)
        if losses.off_on in (None, PLAIN):
            return None
    off, on = losses.off_on
    return np.where(p == off, 0, np.where(p == on, 1, p))


def _off_on(p: npt.NDArray[Any], path: Path, first: int) -> tuple[float, float] | None:
    """Return which numbers are OFF and ON; None where one number alone is plain."""
    if p.size == 0:
        return None
    if p.dtype.kind != "f" and p.min() == 0 and p.max() == 1:
        return PLAIN
    values, counts = np.unique(p, return_counts=True)
    plain = max(int(counts[np.isin(values, pair)].sum()) for pair in ((0, 1), (-1, 1)))
    found = tuple(values.tolist())
    if plain == p.size or (len(found) > 2 and plain >= (1 - _DAMAGED) * p.size):
        return PLAIN if len(found) > 1 else None
    pair = _PAIRS.get(found) or (found if len(found) == 2 and found[0] < 0 < found[1] else None)
    if pair is None or (first and pair[1] != 1):  # 1 was read as ON before
        listed = ", ".join(f"{value:g}" for value in found[:4]) + ", ..." * (len(found) > 4)
        raise ValueError(
            f"p = {listed}: the polarity in {path} does not say which number is ON; "
            "is this column the polarity? Write it as 0 and 1, or leave it out"
        )
    return pair


def from_one(columns: Columns, losses: Losses) -> Columns:
    """Count pixels from 0 that MATLAB counted from 1, as it does where OFF is 1 and ON is 2."""
    x, y, p = (columns.get(role) for role in "xyp")
    if x is None or y is None or p is None or not p.size:
        return columns
    if losses.from_one is None:
        is_matlab = np.array_equal(np.unique(p), (1, 2))
        losses.from_one = bool(is_matlab and x.min() >= 1 and y.min() >= 1)
    return columns | {"x": x - 1, "y": y - 1} if losses.from_one else columns


def _all_whole(times: npt.NDArray[Any]) -> bool:
    finite = times[np.isfinite(times)]
    return finite.size > 0 and bool((finite == np.floor(finite)).all())


def _without(
    columns: Columns, found: dict[str, npt.NDArray[np.bool_]], losses: Losses, first: int
) -> Columns:
    if losses.on_bad == "raise":
        role = min(found, key=lambda name: int(np.argmax(found[name])))
        raise ValueError(misfit_message(role, columns[role], int(np.argmax(found[role])), first))
    none = np.zeros(len(columns["t"]), np.bool_)
    unreadable, outside = none.copy(), none.copy()
    between = none.copy()
    for role, mask in found.items():
        if role in "tp":
            unreadable |= mask
        else:
            whole = columns[role] == np.floor(columns[role])  # False for NaN
            unreadable |= np.isnan(columns[role])
            between |= mask & ~whole
            outside |= mask & whole
    losses.between_pixels += int(between.sum())
    if losses.on_bad == "clamp":
        columns = columns | {role: _clamped(columns[role]) for role in ("x", "y")}
        losses.clamped_positions += int(((outside | between) & ~unreadable).sum())
        outside = none
    else:
        unreadable |= between
        outside &= ~unreadable
    losses.bad_record += int(unreadable.sum())
    losses.out_of_bounds += int(outside.sum())
    good = ~(unreadable | outside)
    return {role: column[good] for role, column in columns.items()}


def _clamped(column: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Move positions to the nearest pixel."""
    inside = np.where(column > _MAX_ADDRESS, _MAX_ADDRESS, np.where(column < 0, 0, column))
    return np.rint(inside) if inside.dtype.kind == "f" else inside


def as_rows(shape: tuple[int, ...], order: str | None = None) -> tuple[int, bool] | None:
    """Count the events in a matrix of this shape, and say whether they are its columns.

    None if it has not as many columns or rows as `order`, else four. MATLAB 7.3 stores what it
    calls (N, 4) as (4, N).
    """
    count = len(order or "txyp")
    if len(shape) != 2:
        return None
    if shape[1] == count:
        return shape[0], False
    return (shape[1], True) if shape[0] == count else None


def order_of(path: Path, name: str, rows: npt.NDArray[Any], order: str | None) -> str:
    """Return `order`, else the arrangement that the first `rows` allow; a question if several."""
    if order is not None:
        if len(order) != rows.shape[1]:
            raise ValueError(
                f"order = {order!r}: names {len(order)} columns, {name} in {path} has "
                f"{rows.shape[1]}"
            )
        return order
    if len(rows) == 0:
        return "txyp"
    columns = range(4)
    times = [i for i in columns if _only_a_time(rows[:, i])]
    if len(times) != 1:
        times = [i for i in columns if _ascends(rows[:, i])]
    signs = [i for i in columns if i not in times and _only_signs(rows[:, i])]
    if len(times) != 1 or len(signs) != 1:
        raise ValueError(
            f"order = None: the values of {name} in {path} do not say which of its 4 columns are "
            "t and p; give order, such as order='txyp'"
        )
    found = dict.fromkeys(times, "t") | dict.fromkeys(signs, "p")
    addresses = iter("xy")
    return "".join(found.get(i) or next(addresses) for i in columns)


def _only_a_time(column: npt.NDArray[Any]) -> bool:
    return bool(np.any(column > _MAX_ADDRESS) or np.any(column != np.floor(column)))


def _only_signs(column: npt.NDArray[Any]) -> bool:
    return bool(np.isin(column, (-1, 0, 1)).all()) or np.array_equal(np.unique(column), (1, 2))


def _ascends(column: npt.NDArray[Any]) -> bool:
    return bool(column[0] < column[-1] and np.all(column[1:] >= column[:-1]))
