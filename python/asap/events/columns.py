"""Recognise a source of events and find its four columns, by name wherever it has names.

The first two of three steps; `values` checks the columns and makes events of them.
"""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from operator import attrgetter
from typing import Any

import numpy as np
import numpy.typing as npt

from asap._checks import named, unmasked
from asap.events.values import MAX, Column, Columns, check_precision, shifted

# What the producers call the four columns.
FIELD_NAMES = {
    "t": ("t", "ts", "timestamp", "timestamps", "time", "times"),
    "x": ("x", "xs"),
    "y": ("y", "ys"),
    "p": ("p", "ps", "on", "polarity", "polarities", "pol"),
}
_UNDERSTOOD = "; ".join(f"{role}: {', '.join(names)}" for role, names in FIELD_NAMES.items())
ROLES = {name: role for role, names in FIELD_NAMES.items() for name in names}
_REMEDY = (
    f"give an array with named fields ({_UNDERSTOOD}), four columns (t, x, y, p), or an array "
    "of shape (N, 4) with order"
)
# What computes a lazy object, and what such an object has beside it: polars, dask, Arrow.
_LAZY = {"collect": "lazy", "compute": "dask", "to_table": "scanner"}


def columns_of(
    source: Any, order: str | None = None, *, first: int | None = None, exponent: int = 6
) -> Columns:
    """Find the columns t, x, y and, if any, p: arrays of one length; of an array the `first`.

    A unit of floating times is 10^`exponent` us: such as are too coarse for it are refused.
    """
    found = _find(source, order)
    if first is not None:
        found = {role: column[:first] for role, column in found.items()}
    columns = {role: _numeric(role, column, exponent) for role, column in found.items()}
    lengths = {role: len(column) for role, column in columns.items()}
    if len(set(lengths.values())) > 1:
        raise ValueError(f"lengths = {lengths}: the columns of events must be equally long")
    return columns


def check_order(order: str) -> str:
    """Return `order` if it names t, x, y once and p at most once; '-' skips a column."""
    roles = sorted(set(order) - {"-"}) if isinstance(order, str) else []
    if roles not in (sorted("txyp"), sorted("txy")) or any(order.count(role) > 1 for role in roles):
        raise ValueError(
            f"order = {order!r}: name the columns with t, x, y and p, each once (p may be absent), "
            "such as 'txyp' or 'yxt', and with '-' a column that is skipped"
        )
    return order


def columns_by_order(columns: Iterable[Any], order: str) -> dict[str, Any]:
    """Name columns, len(order) of them; a polarity of None is none."""
    named = zip(order, columns, strict=True)
    return {role: one for role, one in named if role != "-" and not (role == "p" and one is None)}


# ---- recognise ------------------------------------------------------------------------------


def opened(source: Any) -> Any:
    """Return what holds the columns of a foreign object; `source` itself if it is none."""
    way = _way_into(source)
    return source if way is None else opened(way(source))


def is_chunk(item: Any) -> bool:
    """Whether an element of a list holds events by itself, and is no column of numbers."""
    if isinstance(item, np.ndarray):
        return item.dtype.names is not None or item.ndim == 2
    if isinstance(item, (list, tuple)) and not hasattr(item, "_fields"):
        return len(item) in (3, 4) and all(isinstance(one, np.ndarray) for one in item)
    if isinstance(item, Mapping) or _way_into(item) is not None:
        return True
    return hasattr(item, "columns") or hasattr(item, "column_names")


def _way_into(source: Any) -> Callable[[Any], Any] | None:
    if isinstance(source, (np.ndarray, np.void, Mapping, list, str)):
        return None
    if hasattr(source, "polarity_events"):  # a packet of neuromorphic-drivers
        return attrgetter("polarity_events")
    for compute, mark in _LAZY.items():
        if hasattr(source, compute) and hasattr(source, mark):
            raise TypeError(named("source", type(source).__name__, f"call its {compute}() first"))
    if hasattr(source, "columns") and hasattr(source, "__array__"):  # a table
        return None
    if hasattr(source, "__arrow_c_stream__") or hasattr(source, "__arrow_c_array__"):
        kind = str(getattr(source, "dtype", getattr(source, "type", "struct")))
        is_column = not kind.lower().startswith("struct") and not hasattr(source, "columns")
        return None if is_column else _of_arrow
    if hasattr(source, "__array__"):
        return None
    if hasattr(source, "numpy"):  # a store or a packet of dv-processing; a stream of EventCV
        return _of_numpy
    return _attributes if _attributes(source) else None


def _of_arrow(source: Any) -> Any:
    try:
        arrow = importlib.import_module("pyarrow")
    except ImportError as error:
        remedy = "an object of the Arrow protocol is read by pyarrow; install it"
        raise TypeError(named("source", source, remedy)) from error
    try:
        return arrow.table(source)
    except (TypeError, ValueError, arrow.ArrowException) as error:
        remedy = f"{error}; give a table with the columns t, x, y and p"
        raise TypeError(named("source", type(source).__name__, remedy)) from error


def _of_numpy(source: Any) -> Any:
    array = np.asarray(source.numpy())
    return array if array.ndim != 2 else dict(zip("xytp", array.T, strict=True))


def _attributes(source: Any) -> dict[str, Any] | None:
    """Return the columns of an object that has them as attributes, also of a named tuple."""
    found: dict[str, Any] = {}
    for role, names in FIELD_NAMES.items():
        columns = [column for name in names if np.ndim(column := getattr(source, name, 0)) == 1]
        if not columns:
            return None
        found[role] = columns[0]
    return found


# ---- columns --------------------------------------------------------------------------------


def _find(source: Any, order: str | None) -> Mapping[str, Any]:
    if isinstance(source, (str, bytes, os.PathLike)):
        raise TypeError(f"source = {source!r}: a path is read with asap.load(path)")
    source, given = opened(source), source
    if source is None or (isinstance(source, (list, tuple)) and not source):
        return _no_columns()
    if isinstance(source, (np.ndarray, np.void)):
        return _of_array(source, order)
    if isinstance(source, Mapping):  # xarray keeps the labels of an axis apart
        found = by_name(source, [*source, *getattr(source, "coords", ())], order)
        for place in (source, getattr(source, "parent", None)):  # of DSEC, beside the group
            if isinstance(place, Mapping) and "t_offset" in place:
                t = _numeric("t", found["t"])
                return found | {"t": shifted(t, np.asarray(place["t_offset"]))}
        return found
    if isinstance(source, (list, tuple)):
        return _of_sequence(source, order)
    names = getattr(source, "column_names", None)  # Arrow, whose .columns are the data
    if names is None:
        names = getattr(source, "columns", None)  # pandas, Polars
    labels = getattr(getattr(source, "index", None), "names", ())  # pandas
    if names is not None and ROLES.keys() & set(labels):
        source = source.reset_index()
        names = source.columns
    if names is not None and (order is None or len(ROLES.keys() & set(names)) >= len("txy")):
        return by_name(source, names, order)
    if hasattr(source, "to_numpy"):
        return _of_array(np.asarray(source.to_numpy()), order)
    if hasattr(source, "__array__"):
        return _of_array(np.asarray(source), order)
    uncalled = callable(source) and hasattr(source, "__name__")
    remedy = f"call it: {source.__name__}()" if uncalled else _REMEDY
    raise TypeError(named("source", given, remedy))


def _of_array(array: npt.NDArray[Any] | np.void, order: str | None) -> Mapping[str, Any]:
    unmasked("source", array)
    array = np.asarray(array)
    fields = array.dtype.fields
    if fields is not None:
        array = array.reshape(1) if array.ndim == 0 else array
        if array.ndim != 1:
            raise ValueError(f"shape = {array.shape}: give events as a one-dimensional array")
        return by_name(array, {name: field[:2] for name, field in fields.items()}, order)
    if array.size == 0:
        return _no_columns()
    if array.ndim != 2:
        raise TypeError(f"source is an array of {array.dtype}, shape {array.shape}: {_REMEDY}")
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
    return columns_by_order(array.T, order)


def _of_sequence(source: Sequence[Any], order: str | None) -> Mapping[str, Any]:
    if all(isinstance(item, np.void) and item.dtype.names for item in source):
        if any(item.dtype != source[0].dtype for item in source):
            raise TypeError("source: records of different dtypes")
        return _of_array(np.array(source, dtype=source[0].dtype), order)
    if all(map(is_chunk, source)):
        parts = [columns_of(one, order) for one in source]
        if len({"p" in part for part in parts}) > 1:
            raise TypeError("source: some of the arrays have no polarity; give one kind of them")
        return {role: _joined(role, [part[role] for part in parts]) for role in parts[0]}
    roles = order or "txyp"
    plain = [len(item) for item in source if isinstance(item, (list, tuple))]
    if len(source) == len(roles) and all(
        item is None or isinstance(item, (list, tuple)) or hasattr(item, "__array__")
        for item in source
    ):
        if len(plain) == len(roles) and set(plain) == {len(roles)}:
            raise TypeError(
                f"source: {len(roles)} lists of {len(roles)} may be columns or events; give arrays "
                "for columns, or one array of shape (N, 4) with order"
            )
        columns = columns_by_order(source, roles)
        if order is None:
            _check_sequence(columns)
        return columns
    if len(plain) == len(source):
        return _of_array(np.asarray(source), order)
    raise TypeError(f"source is a {type(source).__name__} of {len(source)}: {_REMEDY}")


def _joined(role: str, parts: list[Column]) -> Column:
    """One column; NumPy would make floats of int64 beside uint64."""
    kinds = {part.dtype.kind for part in parts}
    if kinds == {"i", "u"} and np.result_type(*parts).kind == "f":
        for part in parts:
            if part.size and int(part.max()) > MAX:
                raise ValueError(f"{role} = {part.max()}: no whole number of 64 bits with a sign")
        parts = [part.astype(np.int64) for part in parts]
    return np.concatenate(parts)


def _check_sequence(columns: Mapping[str, Any]) -> None:
    """Refuse four columns without names where the times go back and another one does not."""
    arrays = {role: np.asarray(column) for role, column in columns.items()}
    if any(array.ndim != 1 or array.dtype.kind not in "biufmM" for array in arrays.values()):
        return  # refused elsewhere
    rising = [role for role, array in arrays.items() if bool((array[1:] >= array[:-1]).all())]
    moving = [role for role in rising if arrays[role].size and arrays[role][0] < arrays[role][-1]]
    if "t" not in rising and moving:
        remedy = (
            f"t goes back and {moving[0]} never does: say what the columns are, "
            "such as order='xytp' (order='txyp' if they are right)"
        )
        raise ValueError(named("order", None, remedy))


def by_name(source: Any, names: Iterable[Any], order: str | None) -> dict[str, Any]:
    """Match the roles; two names may share one if a mapping `names` gives them one place."""
    places = names if isinstance(names, Mapping) else {name: name for name in names}
    found = ", ".join(map(str, places)) or "none"
    if order is not None:
        raise ValueError(
            f"order = {order!r}: this source names its columns ({found}); leave order out"
        )
    if "exposure" in places and np.any(np.asarray(source["exposure"])):  # records of an ATIS
        remedy = "some records are exposure measurements; give events[~events['exposure']]"
        raise ValueError(named("exposure", True, remedy))
    matched: dict[str, Any] = {}
    for role, known in FIELD_NAMES.items():
        candidates = [name for name in known if name in places]
        if not candidates or any(places[name] != places[candidates[0]] for name in candidates):
            fault = "no field" if not candidates else f"two fields ({', '.join(candidates)})"
            inner = (
                "give source['events']" if "events" in places else f"understood are {_UNDERSTOOD}"
            )
            raise TypeError(f"source: {fault} for {role} among: {found}; {inner}")
        matched[role] = source[candidates[0]]
    return {role: column for role, column in matched.items() if column is not None or role != "p"}


def _no_columns() -> Columns:
    return {role: np.empty(0, np.int64) for role in "txyp"}


def _numeric(role: str, column: Any, exponent: int = 6) -> Column:
    if type(column) is np.ndarray and column.ndim == 1 and column.dtype.kind in "biu":
        return _native(column)
    if hasattr(column, "to_numpy"):
        has_zone = getattr(getattr(column, "dtype", None), "tz", None) is not None  # pandas
        column = column.to_numpy(f"M8[{column.dtype.unit}]") if has_zone else column.to_numpy()
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
        return _native(values)
    if role == "t":
        check_precision(values, exponent)
    with np.errstate(over="ignore"):  # what becomes infinite is refused by its value
        return values.astype(np.float64, copy=False)


def _native(column: Column) -> Column:
    """Return it in the byte order of this machine."""
    dtype = column.dtype
    return column if dtype.isnative else column.byteswap().view(dtype.newbyteorder("="))
