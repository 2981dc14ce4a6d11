"""Events in memory: one dtype, and the way into it by field name.

NumPy's ``astype`` and pybind11's default cast copy structured arrays by *position*: a source that
stores ``t`` first comes out scrambled, without an error. Nothing here does that.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from asap import _core, _foreign, _stamps
from asap._checks import flag, is_masked, named, unmasked
from asap._foreign import FIELD_NAMES as FIELD_NAMES

__all__ = ["EVENT_DTYPE", "Events", "as_events", "to_dtype"]

Events: TypeAlias = npt.NDArray[np.void]
Column: TypeAlias = npt.NDArray[Any]
Columns: TypeAlias = dict[str, Column]

# Offsets 0 2 4 8, 16 bytes. Without align=True np.concatenate would pack them to 14 bytes.
EVENT_DTYPE = np.dtype([("x", "<u2"), ("y", "<u2"), ("p", "<i2"), ("t", "<i8")], align=True)

_UNDERSTOOD = "; ".join(f"{role}: {', '.join(names)}" for role, names in FIELD_NAMES.items())
_KNOWN = frozenset(name for names in FIELD_NAMES.values() for name in names)

_MAX_ADDRESS = 65535


def as_events(
    source: Any,
    *,
    order: str | None = None,
    time_unit: str | None = None,
    copy: bool | None = None,
) -> Events:
    """Events of any common layout as one array in ``EVENT_DTYPE``, matched by field name.

    Parameters
    ----------
    source
        One of

        * a structured array of shape (N,), fields in any order, width and stride: time ``t``,
          ``ts``, ``timestamp`` or ``time``; ``x``; ``y``; polarity ``p``, ``on``, ``polarity``
          or ``pol``, as names or titles; also one record of it, or a list of records;
        * a mapping or a data frame with these columns, each of shape (N,), also an open HDF5
          group; a ``t_offset`` beside it (DSEC) or in it is added to the times;
        * four columns ``(t, x, y, p)`` in a tuple or list, in this order or in `order`
          (a ``p`` of None: every event is ON);
        * an array of shape (N, len(order)), with `order`;
        * an object with these columns as attributes, of the Arrow protocol (read by pyarrow), a
          packet or a store of a camera's library;
        * a list of several of these, one after the other;
        * None or something empty: no events.
    order
        What the columns are, for sources without names: an arrangement of ``t``, ``x``, ``y`` and
        ``p``, such as ``"txyp"`` or ``"yxt"`` (without ``p`` every event is ON).
    time_unit
        Unit of numeric times: ``"s"``, ``"ms"``, ``"us"`` or ``"ns"``. Times are rounded to
        microseconds, half to even. ``datetime64`` and ``timedelta64`` carry their own unit. None:
        microseconds; floating times need their unit.
    copy
        None copies where needed, True always, False never: an error where a copy is needed.

    Returns
    -------
    numpy.ndarray
        Shape (N,), dtype ``EVENT_DTYPE``: x, y in px, p 1 = ON (source > 0) or 0 = OFF, t in us.
        It is `source` itself, without a copy, if that has this dtype, is contiguous and aligned to
        8 bytes and its polarity is 0 or 1.

    Raises
    ------
    TypeError
        A path (use ``asap.load``), fields that cannot be matched, a column that is not numeric.
    ValueError
        A value that an event cannot hold (named with its field and index), one that a mask hides,
        floating times without a unit or too coarse for it, whole times without one that are all
        multiples of 1000, two polarities above 0, columns of different lengths, an array without
        `order`, columns without names where another one than the first looks like the times, a
        copy that ``copy=False`` forbids.

    Warns
    -----
    UserWarning
        Whole times without a unit that can hardly be microseconds.
    """
    exponent = 0 if time_unit is None else _stamps.time_exponent(time_unit)
    if order is not None:
        check_order(order)
    if copy is not None:
        flag("copy", copy)
    is_ours = isinstance(source, np.ndarray) and source.dtype == EVENT_DTYPE
    if is_ours and not copy and is_event_memory(source) and _has_plain_polarity(source):
        return plain_view(source)
    columns = columns_of(source, order, exponent=exponent)
    if copy is False:
        raise ValueError(
            "copy = False: this source cannot be taken without a copy; give a contiguous array in "
            "asap.EVENT_DTYPE with polarity 0 or 1, or leave copy out"
        )
    if time_unit is None:
        if columns["t"].dtype.kind == "f":
            raise ValueError(
                f"time_unit = None: t is {columns['t'].dtype}; floating times need their unit, "
                "such as time_unit='s'"
            )
        if not is_ours and _stamps.are_thousands(columns["t"]):
            raise ValueError(
                "time_unit = None: t are whole multiples of 1000; say time_unit='us' or "
                "time_unit='ns'"
            )
        if not is_ours and (doubt := _foreign.doubt_of_unit(columns["t"])):
            warnings.warn(f"t: {doubt}", stacklevel=2)
    if "p" in columns:
        _foreign.check_polarity(columns["p"], is_ours)
    events = pack_good(columns, exponent)
    if events is not None:
        return events
    for role, column in columns.items():
        bad = misfits(role, column, exponent)
        if bad is not None and bad.any():
            raise ValueError(misfit_message(role, column, int(np.argmax(bad))))
    return pack(columns, exponent)


def events_of_argument(field: str, events: Any) -> Events:
    """`as_events` of an argument that is called otherwise, which its refusals then name."""
    try:
        return as_events(events)
    except (TypeError, ValueError) as error:
        words = str(error)
        if not words.startswith("source"):
            raise
        raise type(error)(field + words.removeprefix("source")) from None


def check_order(order: str) -> str:
    """Return `order` if it names t, x, y once and p at most once; '-' skips a column."""
    roles = sorted(set(order) - {"-"}) if isinstance(order, str) else []
    if roles not in (sorted("txyp"), sorted("txy")) or any(order.count(role) > 1 for role in roles):
        raise ValueError(
            f"order = {order!r}: name the columns with t, x, y and p, each once (p may be absent), "
            "such as 'txyp' or 'yxt', and with '-' a column that is skipped"
        )
    return order


def columns_by_order(rows: npt.NDArray[Any], order: str) -> Columns:
    """Name the columns of rows of shape (N, len(order))."""
    return {role: rows[:, i] for i, role in enumerate(order) if role != "-"}


def columns_of(
    source: Any, order: str | None = None, *, first: int | None = None, exponent: int = 6
) -> Columns:
    """Find the columns t, x, y and, if any, p: arrays of one length; of an array the `first`.

    A unit of floating times is 10^`exponent` us: such as are too coarse for it are refused.
    """
    columns = _find_columns(source, order)
    if first is not None:
        columns = {role: column[:first] for role, column in columns.items()}
    columns = {role: _numeric(role, column, exponent) for role, column in columns.items()}
    lengths = {role: len(column) for role, column in columns.items()}
    if len(set(lengths.values())) > 1:
        raise ValueError(f"lengths = {lengths}: the columns of events must be equally long")
    return columns


def misfits(role: str, column: Column, exponent: int = 0) -> npt.NDArray[np.bool_] | None:
    """Mark the values that an event cannot hold; None where there can be none."""
    kind, size = column.dtype.kind, column.dtype.itemsize
    if kind in "mM":
        return _stamps.misfits(column)
    if kind == "b":
        return None
    if role == "p":
        return np.isnan(column) if kind == "f" else None
    if role == "t":
        if kind == "f":
            in_reach: npt.NDArray[np.bool_] = np.abs(column) < 2.0**62 / 10.0**exponent
            return ~in_reach
        if size < 8 and exponent <= 0:
            return None
        limit = _stamps.MAX // 10 ** max(exponent, 0)
        return _outside(column, -limit, limit)
    if kind == "f":
        inside = (column >= 0) & (column <= _MAX_ADDRESS)
        pixel: npt.NDArray[np.bool_] = inside & (column == np.floor(column))
        return ~pixel
    if kind == "u" and size <= 2:
        return None
    return _outside(column, 0, _MAX_ADDRESS)


def misfit_message(role: str, column: Column, index: int, first: int = 0) -> str:
    """Field, value, event number (the column begins with event `first`) and remedy."""
    if role == "t":
        remedy = "no time in 64-bit us; check time_unit"
    elif role == "p":
        remedy = "no polarity"
    else:
        remedy = f"no pixel: whole numbers from 0 to {_MAX_ADDRESS}; drop or repair these events"
    return f"{role} = {column[index]} (event {first + index}): {remedy}"


def pack_good(
    columns: Columns, exponent: int = 0, *, normalise: bool = True, out: Events | None = None
) -> Events | None:
    """`pack` in one native pass; None for a misfit or a type that the pass does not know.

    The events are written into `out`, where it is given.
    """
    if exponent and columns["t"].dtype.kind != "f":
        return None
    t, x, y = (columns[role] for role in "txy")
    return _core.events_of_columns(
        t, x, y, columns.get("p"), us_per_unit=10.0**exponent, normalise=normalise, out=out
    )


def pack(columns: Columns, exponent: int = 0, *, normalise: bool = True) -> Events:
    """Columns without misfits as events.

    Without `normalise`, a polarity other than 0 and 1 becomes -1 or 2, for a validator to count.
    """
    events: Events = np.zeros(len(columns["t"]), EVENT_DTYPE)
    events["t"] = _stamps.to_us(columns["t"], exponent)
    events["x"] = columns["x"]
    events["y"] = columns["y"]
    if "p" not in columns:
        events["p"] = 1
        return events
    on = columns["p"] > 0
    events["p"] = on
    if not normalise:
        odd = columns["p"] != on
        events["p"][odd] = np.where(on[odd], 2, -1)
    return events


def is_event_memory(array: npt.NDArray[Any]) -> bool:
    """Whether the core can read the array as it lies in memory."""
    return (
        array.dtype == EVENT_DTYPE
        and array.ndim == 1
        and array.flags.c_contiguous
        and array.ctypes.data % 8 == 0
        and not is_masked(array)
    )


def plain_view(events: Events) -> Events:
    """Return the same memory as a plain array (no recarray, no memmap) in ``EVENT_DTYPE``."""
    dtype = events.dtype
    if type(events) is np.ndarray and dtype.type is np.void and dtype.isalignedstruct:
        return events
    return events.view(EVENT_DTYPE, np.ndarray)


def _has_plain_polarity(events: Events) -> bool:
    p = events["p"]
    return p.size == 0 or bool(p.min() >= 0 and p.max() <= 1)


def _find_columns(source: Any, order: str | None) -> Mapping[str, Any]:
    if isinstance(source, (str, bytes, os.PathLike)):
        raise TypeError(f"source = {source!r}: a path is read with asap.load(path)")
    if source is None or (isinstance(source, (list, tuple)) and not source):
        return _no_columns()
    source, given = _foreign.opened(source), source
    if isinstance(source, (np.ndarray, np.void)):
        return _columns_of_array(source, order)
    if source is None:  # a packet without events
        return _no_columns()
    if isinstance(source, Mapping):
        return _with_offset(source, _by_name(source, _positions(list(source)), order))
    if isinstance(source, (list, tuple)):
        return _columns_of_sequence(source, order)
    names = getattr(source, "column_names", None)  # Arrow, whose .columns are the data
    if names is None:
        names = getattr(source, "columns", None)  # pandas, Polars
    if names is not None and (order is None or len(_KNOWN.intersection(names)) >= len("txy")):
        return _by_name(source, _positions(list(names)), order)
    if hasattr(source, "to_numpy"):
        return _columns_of_array(np.asarray(source.to_numpy()), order)
    if hasattr(source, "__array__"):
        return _columns_of_array(np.asarray(source), order)
    uncalled = callable(source) and hasattr(source, "__name__")
    remedy = f"call it: {source.__name__}()" if uncalled else _remedy()
    raise TypeError(named("source", given, remedy))


def _columns_of_array(array: npt.NDArray[Any] | np.void, order: str | None) -> Mapping[str, Any]:
    unmasked("source", array)
    array = np.asarray(array)
    fields = array.dtype.fields
    if fields is not None:
        array = array.reshape(1) if array.ndim == 0 else array
        if array.ndim != 1:
            raise ValueError(f"shape = {array.shape}: give events as a one-dimensional array")
        places = {name: (field[0], field[1]) for name, field in fields.items()}
        return _by_name(array, places, order)
    if array.size == 0:
        return _no_columns()
    if array.ndim != 2:
        raise TypeError(f"source is an array of {array.dtype}, shape {array.shape}: {_remedy()}")
    if order is None:
        raise ValueError(
            f"order = None: an array of shape {array.shape} does not say what its columns are; "
            f"give order, such as order={'txyp'[: max(array.shape[1], 3)]!r}, "
            "to asap.as_events or asap.load"
        )
    if array.shape[1] != len(order):
        raise ValueError(
            f"order = {order!r}: names {len(order)} columns, the array has {array.shape[1]} "
            f"(shape {array.shape})"
        )
    return columns_by_order(array, order)


def _columns_of_sequence(source: Sequence[Any], order: str | None) -> Mapping[str, Any]:
    if all(isinstance(item, np.void) and item.dtype.names for item in source):
        if any(item.dtype != source[0].dtype for item in source):
            raise TypeError("source: records of different dtypes")
        return _columns_of_array(np.array(source, dtype=source[0].dtype), order)
    if all(map(_foreign.is_chunk, source)):
        return _joined([columns_of(one, order) for one in source])
    roles = order or "txyp"
    plain = [len(item) for item in source if isinstance(item, (list, tuple))]
    if len(source) == len(roles) and all(_is_column(item) for item in source):
        if len(plain) == len(roles) and set(plain) == {len(roles)}:
            raise TypeError(
                f"source: {len(roles)} lists of {len(roles)} may be columns or events; give arrays "
                "for columns, or one array of shape (N, 4) with order"
            )
        columns = {
            role: item
            for role, item in zip(roles, source, strict=True)
            if role != "-" and not (role == "p" and item is None)
        }
        if order is None:
            _foreign.check_sequence(columns)
        return columns
    if len(plain) == len(source):
        return _columns_of_array(np.asarray(source), order)
    raise TypeError(f"source is a {type(source).__name__} of {len(source)}: {_remedy()}")


def _joined(parts: list[Columns]) -> Columns:
    if len({"p" in part for part in parts}) > 1:
        raise TypeError("source: some of the arrays have no polarity; give one kind of them")
    return {role: np.concatenate([part[role] for part in parts]) for role in parts[0]}


def _is_column(item: Any) -> bool:
    return item is None or isinstance(item, (list, tuple)) or hasattr(item, "__array__")


def _positions(names: list[Any]) -> dict[Any, Any]:
    return dict(zip(names, range(len(names)), strict=True))


def _by_name(source: Any, places: Mapping[Any, Any], order: str | None) -> dict[str, Any]:
    """Match the roles; two names may share a role only if they are one place (name and title)."""
    found = ", ".join(map(str, places)) or "none"
    if order is not None:
        raise ValueError(
            f"order = {order!r}: this source names its columns ({found}); leave order out"
        )
    _foreign.check_exposure(source, places)
    matched: dict[str, Any] = {}
    for role, names in FIELD_NAMES.items():
        candidates = [name for name in names if name in places]
        if not candidates or any(places[name] != places[candidates[0]] for name in candidates):
            fault = "no field" if not candidates else f"two fields ({', '.join(candidates)})"
            inner = (
                "give source['events']" if "events" in places else f"understood are {_UNDERSTOOD}"
            )
            raise TypeError(f"source: {fault} for {role} among: {found}; {inner}")
        matched[role] = source[candidates[0]]
    return {role: column for role, column in matched.items() if column is not None or role != "p"}


def _with_offset(source: Mapping[Any, Any], columns: dict[str, Any]) -> dict[str, Any]:
    """Add DSEC's t_offset, which stands in the mapping or beside the group."""
    for place in (source, getattr(source, "parent", None)):
        if isinstance(place, Mapping) and "t_offset" in place:
            offset = np.asarray(place["t_offset"])
            return columns | {"t": _stamps.shifted(_numeric("t", columns["t"]), offset)}
    return columns


def _no_columns() -> Columns:
    return {role: np.empty(0, np.int64) for role in "txyp"}


def _numeric(role: str, column: Any, exponent: int = 6) -> Column:
    if type(column) is np.ndarray and column.ndim == 1 and column.dtype.kind in "biu":
        return column  # what most readers bring, many times a second
    if hasattr(column, "to_numpy"):
        column = column.to_numpy()
    unmasked(role, column)
    values: Column = np.asarray(column)
    if values.dtype.kind == "O":
        missing = [i for i, value in enumerate(values.flat) if value is None]
        if missing:
            raise ValueError(f"{role} = None (event {missing[0]}): every event needs a number")
        values = np.asarray(values.tolist())
    if values.ndim == 1 and values.size == 0:
        return values if values.dtype.kind in "biu" else np.empty(0, np.int64)
    if values.ndim != 1:
        raise TypeError(f"{role}: a column has one dimension, this one has shape {values.shape}")
    if values.dtype.kind not in ("biufmM" if role == "t" else "biuf"):
        raise TypeError(f"{role}: a column of {values.dtype} holds no numbers")
    if values.dtype.kind != "f":
        return values
    if role == "t":
        _foreign.check_precision(values, exponent)
    with np.errstate(over="ignore"):  # what becomes infinite is refused by its value
        return values.astype(np.float64, copy=False)


def _outside(column: Column, low: int, high: int) -> npt.NDArray[np.bool_] | None:
    if len(column) == 0 or (low <= int(column.min()) and int(column.max()) <= high):
        return None
    # A bound that the type cannot hold is never crossed, and not every NumPy compares with it.
    limits = np.iinfo(column.dtype)
    bad = np.zeros(len(column), np.bool_)
    if limits.min < low:
        bad |= column < low
    if limits.max > high:
        bad |= column > high
    return bad


def _remedy() -> str:
    return (
        f"give an array with named fields ({_UNDERSTOOD}), four columns (t, x, y, p), or an array "
        "of shape (N, 4) with order"
    )


def to_dtype(events: Any, dtype: npt.DTypeLike) -> npt.NDArray[np.void]:
    """Return the events in the layout of another library, matched by field name.

    Parameters
    ----------
    events
        As in `as_events`.
    dtype
        The structured dtype that the library exports, such as ``faery.EVENTS_DTYPE``. Its fields
        may have the names that `as_events` understands, in any order; others become 0.

    Raises
    ------
    TypeError
        A field is missing, or holds no whole numbers.
    ValueError
        A value does not fit into its field; named with the event.
    """
    events, target = events_of_argument("events", events), np.dtype(dtype)
    places = {name: (field[0], field[1]) for name, field in (target.fields or {}).items()}
    result = np.zeros(len(events), target)
    fields = _by_name(result, places, None)
    for role in "txyp":
        column, field = events[role], fields[role]
        if field.dtype.kind not in ("biu" if role == "p" else "iu") or field.ndim != 1:
            raise TypeError(named("dtype", field.dtype, f"{role} needs a field of whole numbers"))
        field[:] = column
        if (differs := field != column).any():
            number = int(differs.argmax())
            remedy = f"does not fit into {role} of {field.dtype}"
            raise ValueError(f"{role} = {column[number]} (event {number}): {remedy}")
    return result
