"""Open the objects of other libraries for `as_events`, and refuse columns that would mislead it."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from operator import attrgetter
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from asap import _units
from asap._checks import named

Column: TypeAlias = npt.NDArray[Any]

# What the producers call the four columns.
FIELD_NAMES = {
    "t": ("t", "ts", "timestamp", "timestamps", "time", "times"),
    "x": ("x", "xs"),
    "y": ("y", "ys"),
    "p": ("p", "ps", "on", "polarity", "polarities", "pol"),
}

HEAD = 1001  # events whose steps say something
_MOST_PER_US = 100  # more than any camera sends
_LONG_US = 10_000  # between events of a camera


def opened(source: Any) -> Any:
    """Return what holds the columns of a foreign object; `source` itself if it is none."""
    way = _way_into(source)
    return source if way is None else opened(way(source))


# What computes a lazy object, and what such an object has beside it: polars, dask, Arrow.
_LAZY = {"collect": "lazy", "compute": "dask", "to_table": "scanner"}


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


def is_chunk(item: Any) -> bool:
    """Whether an element of a list holds events by itself, and is no column of numbers."""
    if isinstance(item, np.ndarray):
        return item.dtype.names is not None or item.ndim == 2
    if isinstance(item, (list, tuple)) and not hasattr(item, "_fields"):
        return len(item) in (3, 4) and all(isinstance(one, np.ndarray) for one in item)
    if isinstance(item, Mapping) or _way_into(item) is not None:
        return True
    return hasattr(item, "columns") or hasattr(item, "column_names")


def check_sequence(columns: Mapping[str, Any]) -> None:
    """Refuse four columns without names where the times go back and another one does not."""
    arrays = {role: np.asarray(column) for role, column in columns.items()}
    if any(array.ndim != 1 or array.dtype.kind not in "biufmM" for array in arrays.values()):
        return  # refused elsewhere
    if _never_falls(arrays.pop("t")):
        return
    for role, array in arrays.items():
        if array.size and array[0] < array[-1] and _never_falls(array):
            remedy = (
                f"t goes back and {role} never does: say what the columns are, "
                "such as order='xytp' (order='txyp' if they are right)"
            )
            raise ValueError(named("order", None, remedy))


def _never_falls(column: Column) -> bool:
    return bool((column[1:] >= column[:-1]).all())


def check_exposure(source: Any, names: Mapping[Any, Any]) -> None:
    """Refuse records of an ATIS that are measurements of exposure, and no events."""
    if "exposure" in names and np.any(np.asarray(source["exposure"])):
        remedy = "some records are exposure measurements; give events[~events['exposure']]"
        raise ValueError(named("exposure", True, remedy))


def check_polarity(p: Column, is_ours: bool) -> None:
    """Refuse a polarity of two values above 0, which would all be ON; in ours, if none is OFF."""
    above = p if p.dtype.kind == "f" or (p.size and p.max() > 1) else p[:0]
    above = above[above > 0]
    if above.size == 0 or (is_ours and above.size < p.size):
        return
    low, high = above.min(), above.max()
    if low != high:
        remedy = f"and {high:g} are both above 0, which is ON; give p == {high:g}"
        raise ValueError(f"p = {low:g}: {remedy} if {low:g} is OFF")


def check_precision(t: Column, exponent: int) -> None:
    """Refuse times whose type is too coarse for microseconds."""
    finite = t[np.isfinite(t)] if t.dtype.kind == "f" and t.dtype.itemsize < 8 else t[:0]
    if finite.size == 0:
        return
    largest = np.abs(finite).max()
    step_us = float(np.spacing(largest)) * 10.0**exponent
    if step_us > 1:
        remedy = f"at {largest:g} it steps by {step_us:.3g} us; give float64 or whole microseconds"
        raise ValueError(f"t = {t.dtype}: {remedy}")


def doubt_of_unit(t: Column) -> str | None:
    """Say why whole times without a unit are hardly microseconds."""
    if len(t) < HEAD or t.dtype.kind not in "iu":
        return None
    span_us = int(t[-1]) - int(t[0])
    is_dense, is_sparse = len(t) > _MOST_PER_US * (span_us + 1), span_us > _LONG_US * len(t)
    if span_us < 0 or not (is_dense or is_sparse):  # one that is not sorted tells nothing
        return None
    doubt = unit_doubt("us", len(t), span_us, np.diff(t[:HEAD]))
    return doubt and f"{doubt[0]}; {doubt[1]}"


def unit_doubt(
    unit: str | None, count: int, span_us: int, steps_us: npt.NDArray[np.int64]
) -> tuple[str, str] | None:
    """Say why the times are hardly in `unit`, which was guessed, and what helps; None if not.

    `count` events within `span_us` are too many for seconds; `steps_us`, between the first events,
    are too long for a camera if their median is (a pause is one long step).
    """
    if unit is None or count < HEAD:
        return None
    step_us = float(np.median(steps_us)) if len(steps_us) else 0.0
    if unit == "us" and count > _MOST_PER_US * (span_us + 1):
        words = f"{count} events within {span_us} us, which is short for a camera"
    elif step_us > _LONG_US:
        words = f"the times step by {_units.duration(step_us)}, which is long for a camera"
    else:
        return None
    return words, f"if they are not in {unit}, give time_unit"
