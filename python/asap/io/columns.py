"""Columns of a file as events: values that no event can hold are counted, not raised."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from asap.events.columns import ROLES, columns_by_order, columns_of
from asap.events.values import (
    Columns,
    Events,
    Misfit,
    are_thousands,
    is_event_memory,
    misfits,
    pack,
    plain_view,
    time_exponent,
)
from asap.io.errors import UnsupportedFormat, unclear_unit
from asap.io.reader import CHUNK, Losses, Options

_MAX_ADDRESS = 65535
_LOOKS = 32  # rows whose times must ascend before one is sought
_DAMAGED = 0.1  # share of odd polarities that is no other way to write it


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

    Without a time unit, floating times are seconds and integers microseconds; the user is asked
    where floats begin as whole numbers, or whole numbers as multiples of 1000.
    """
    if isinstance(source, np.ndarray) and options.time_unit is None and is_event_memory(source):
        losses.guessed_unit = "us"
        check_polarity(source["p"], losses)
        return plain_view(source)
    exponent = time_exponent(options.time_unit or "s")
    columns = file_columns(losses.path, source, options.order, exponent=exponent)
    if "p" in columns:
        check_polarity(columns["p"], losses)
    unit = options.time_unit or ("s" if columns["t"].dtype.kind == "f" else "us")
    if options.time_unit is None:
        losses.guessed_unit = unit
        if first == 0 and (
            _all_whole(columns["t"]) if unit == "s" else are_thousands(columns["t"])
        ):
            raise unclear_unit(losses.path, unit == "s")
    exponent = time_exponent(unit)
    out = losses.room(len(columns["t"]))
    events = pack(columns, exponent, normalise=False, out=out)
    if events is None:
        columns = _without(columns, exponent, losses, first)
        events = pack(columns, exponent, normalise=False)
        assert events is not None
    return events


def pieces_of(source: Any, options: Options, losses: Losses, first: int = 0) -> Iterator[Events]:
    """Convert an array or a mapping of columns piece by piece; `first` as in `events_of`."""
    is_array = isinstance(source, np.ndarray)
    count = len(source if is_array else next(iter(source.values())))
    for start in range(0, count, CHUNK):
        part = slice(start, start + CHUNK)
        piece = source[part] if is_array else {role: one[part] for role, one in source.items()}
        yield events_of(piece, options, losses, first + start)


def check_polarity(p: npt.NDArray[Any], losses: Losses) -> None:
    """Refuse numbers that do not say which of them is ON; a few odd ones are damage.

    Plain are 0 and 1, or -1 and 1. Once both of a pair have been seen, the rest is not looked at.
    """
    if losses.has_plain_polarity or p.dtype.kind == "b" or p.size == 0:
        return
    values, counts = np.unique(p[p == p], return_counts=True)
    plain = max(int(counts[np.isin(values, pair)].sum()) for pair in ((0, 1), (-1, 1)))
    is_damaged = len(values) > 2 and plain >= (1 - _DAMAGED) * p.size
    if plain < counts.sum() and not is_damaged:
        listed = ", ".join(f"{value:g}" for value in values[:4]) + ", ..." * (len(values) > 4)
        raise ValueError(
            f"p = {listed}: the polarity in {losses.path} does not say which number is ON; is this "
            "column the polarity? Write it as 0 and 1, or leave it out, with '-' in order"
        )
    losses.has_plain_polarity = len(values) > 1


def _all_whole(times: npt.NDArray[Any]) -> bool:
    finite = times[np.isfinite(times)]
    return finite.size > 0 and bool((finite == np.floor(finite)).all())


def _without(columns: Columns, exponent: int, losses: Losses, first: int) -> Columns:
    if losses.on_bad == "raise":
        raise Misfit(columns, exponent, first)
    none = np.zeros(len(columns["t"]), np.bool_)
    unreadable, outside, between = none.copy(), none.copy(), none.copy()
    for role, column in columns.items():
        mask = misfits(role, column, exponent)
        if role in "tp":
            unreadable |= mask
        else:
            whole = column == np.floor(column)  # False for NaN
            unreadable |= np.isnan(column)
            between |= mask & ~whole
            outside |= mask & whole
    losses.between_pixels += int(between.sum())
    if losses.on_bad == "clamp":
        columns = {**columns, "x": _clamped(columns["x"]), "y": _clamped(columns["y"])}
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


def names_by_role(names: Iterable[str]) -> dict[str, str] | None:
    """Return which of the names is t, x, y and p; None where one has none, or more than one."""
    found = [(ROLES[name.lower()], name) for name in names if name.lower() in ROLES]
    if sorted(role for role, _ in found) != sorted("txyp"):
        return None
    return dict(sorted(found, key=lambda one: "txyp".index(one[0])))


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


def by_order(path: Path, name: str, rows: npt.NDArray[Any], order: str | None) -> Columns:
    """Name the columns of a matrix as the user says; a question where nothing was said."""
    count = rows.shape[1]
    if order is None:
        raise ValueError(
            f"order = None: {name} in {path} does not say what its {count} columns are; give "
            "order, such as order='txyp'"
        )
    if len(order) != count:
        fault = f"names {len(order)} columns, {name} in {path} has {count}"
        raise ValueError(f"order = {order!r}: {fault}")
    return columns_by_order(rows.T, order)
