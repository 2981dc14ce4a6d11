"""Columns of a file as events: values that no event can hold are counted, not raised."""

from __future__ import annotations

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
from asap.io.reader import Losses, Options

_MAX_ADDRESS = 65535


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
        return plain_view(source)
    exponent = time_exponent(options.time_unit or "s")
    columns = file_columns(losses.path, source, options.order, exponent=exponent)
    unit = options.time_unit or ("s" if columns["t"].dtype.kind == "f" else "us")
    if options.time_unit is None:
        losses.guessed_unit = unit
        if unit == "s" and first == 0 and _all_whole(columns["t"]):
            raise unclear_unit(losses.path)
    exponent = time_exponent(unit)
    events = pack_good(columns, exponent, normalise=False)
    if events is not None:
        return events
    bad = {role: misfits(role, column, exponent) for role, column in columns.items()}
    found = {role: mask for role, mask in bad.items() if mask is not None and mask.any()}
    if found:
        columns = _without(columns, found, losses, first)
    return pack(columns, exponent, normalise=False)


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
    for role, mask in found.items():
        if role in "tp":
            unreadable |= mask
        else:
            whole = columns[role] == np.floor(columns[role])  # False for NaN
            unreadable |= mask & ~whole
            outside |= mask & whole
    outside &= ~unreadable
    if losses.on_bad == "clamp":
        columns = columns | {role: _clamped(columns[role]) for role in ("x", "y")}
        losses.clamped_positions += int(outside.sum())
        outside = none
    losses.bad_record += int(unreadable.sum())
    losses.out_of_bounds += int(outside.sum())
    good = ~(unreadable | outside)
    return {role: column[good] for role, column in columns.items()}


def _clamped(column: npt.NDArray[Any]) -> npt.NDArray[Any]:
    return np.where(column > _MAX_ADDRESS, _MAX_ADDRESS, np.where(column < 0, 0, column))


def as_rows(shape: tuple[int, ...]) -> tuple[int, bool] | None:
    """Count the events in a matrix of this shape, and say whether they are its columns.

    None if it is not four columns or rows. MATLAB 7.3 stores what it calls (N, 4) as (4, N).
    """
    if len(shape) != 2:
        return None
    if shape[1] == 4:
        return shape[0], False
    return (shape[1], True) if shape[0] == 4 else None


def order_of(path: Path, name: str, rows: npt.NDArray[Any], order: str | None) -> str:
    """Return `order`, else the arrangement that the first `rows` allow; a question if several."""
    if order is not None:
        if len(order) != 4:
            raise ValueError(
                f"order = {order!r}: names {len(order)} columns, {name} in {path} has 4"
            )
        return order
    if len(rows) == 0:
        return "txyp"
    columns = range(4)
    times = [i for i in columns if _only_a_time(rows[:, i])]
    if len(times) != 1:
        times = [i for i in columns if _ascends(rows[:, i])]
    signs = [i for i in columns if i not in times and bool(np.isin(rows[:, i], (-1, 0, 1)).all())]
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


def _ascends(column: npt.NDArray[Any]) -> bool:
    return bool(column[0] < column[-1] and np.all(column[1:] >= column[:-1]))
