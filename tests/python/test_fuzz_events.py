"""``as_events`` on arrays of any dtype, layout and content: the same columns, or a clear error."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import asap
from asap.events.columns import FIELD_NAMES
from fuzzing import INTERESTING, effort

NUMBERS = ("u1", "u2", "u4", "u8", "i1", "i2", "i4", "i8", "f2", "f4", "f8", "?")
ODD = ("S3", "U2", "M8[us]", "M8[s]", "m8[ns]", "c8", "V2", "O")
UNITS = ("s", "ms", "us", "ns")
EXPONENT = {"s": 6, "ms": 3, "us": 0, "ns": -3}

VALUES = st.one_of(
    st.integers(0, 400),
    st.sampled_from((*INTERESTING, *(-value for value in INTERESTING))),
    st.floats(),
)


@st.composite
def columns(draw: st.DrawFn, size: int, dtypes: tuple[str, ...]) -> np.ndarray[Any, Any]:
    """A column of any of these types, of values that mostly fit."""
    order = draw(st.sampled_from("<>"))
    dtype = np.dtype(draw(st.sampled_from(dtypes))).newbyteorder(order)
    if dtype.kind in "biuf":
        values = draw(st.lists(VALUES, min_size=size, max_size=size))
        with np.errstate(all="ignore"):
            return np.array([_into(dtype, value) for value in values], dtype)
    if dtype.kind in "mM":
        ticks = draw(hnp.arrays(np.int64, size, elements=st.integers(-(2**63), 2**63 - 1)))
        return ticks.view(dtype.newbyteorder("=")).astype(dtype)
    if dtype.kind == "O":
        return np.array(
            draw(st.lists(st.one_of(VALUES, st.none()), min_size=size, max_size=size)), dtype
        )
    return np.zeros(size, dtype)


def _into(dtype: np.dtype[Any], value: float) -> Any:
    if dtype.kind in "iu":
        limits = np.iinfo(dtype)
        whole = int(value) if np.isfinite(value) else 0
        return min(max(whole, int(limits.min)), int(limits.max))
    return value


@st.composite
def tables(draw: st.DrawFn) -> dict[str, np.ndarray[Any, Any]]:
    """Columns by the names that producers use, in any order, now and then one too many or few."""
    size = draw(st.integers(0, 6))
    names = [draw(st.sampled_from(FIELD_NAMES[role])) for role in "txyp"]
    kind = draw(st.integers(0, 9))
    if kind == 0:
        names.append(draw(st.sampled_from(("ts", "on", "z", "index"))))
    if kind == 1:
        names.remove(draw(st.sampled_from(names)))
    odd = draw(st.integers(0, 5)) == 0
    order = draw(st.permutations(list(dict.fromkeys(names))))
    return {name: draw(columns(size, NUMBERS + ODD if odd else NUMBERS)) for name in order}


@st.composite
def layouts(draw: st.DrawFn, table: dict[str, np.ndarray[Any, Any]]) -> Any:
    """The same columns as a mapping or as one array, packed or padded, strided, read-only, ..."""
    if draw(st.booleans()):
        return table
    formats = [column.dtype for column in table.values()]
    dtype = np.dtype({"names": list(table), "formats": formats})
    if draw(st.booleans()):
        starts = np.cumsum([0, *(one.itemsize + draw(st.integers(0, 3)) for one in formats)])
        dtype = np.dtype({
            "names": list(table), "formats": formats, "offsets": starts[:-1].tolist(),
            "itemsize": int(starts[-1]) + draw(st.integers(0, 9)),
        })  # fmt: skip
    size = len(next(iter(table.values()), ()))
    step = draw(st.sampled_from((1, 1, 2, 3, -1)))
    array = np.zeros(size * abs(step), dtype)[::step][:size]
    for name, column in table.items():
        array[name] = column
    if draw(st.booleans()) and not dtype.hasobject:
        shifted = np.zeros(array.nbytes + 1, "u1")[1:].view(dtype)  # not aligned
        for name in table:
            shifted[name] = array[name]
        array = shifted
    array.flags.writeable = draw(st.booleans())
    wrap = draw(st.sampled_from((None, None, np.recarray, "masked")))
    if wrap == "masked":
        with np.errstate(all="ignore"):  # of its fill value
            return np.ma.MaskedArray(array, mask=draw(st.booleans()))
    return array if wrap is None else array.view(wrap)


def expected(table: dict[str, Any], unit: str) -> dict[str, list[int]] | None:
    """The events by exact arithmetic; None where a column cannot be that."""
    found: dict[str, list[int]] = {}
    for role, names in FIELD_NAMES.items():
        there = [name for name in names if name in table]
        if len(there) != 1:
            return None
        column = table[there[0]]
        values = column.tolist() if column.dtype.kind in "biuf" else None
        if values is None or any(value != value for value in values):
            return None
        if role != "p" and any(abs(value) == float("inf") for value in values):
            return None
        if role in "xy":
            if any(value != int(value) or not 0 <= value <= 65535 for value in values):
                return None
            found[role] = [int(value) for value in values]
        elif role == "p":
            if len({value for value in values if value > 0}) > 1 and max(values) > 1:
                return None
            found[role] = [int(value > 0) for value in values]
        elif column.dtype.kind == "f":
            if any(abs(value) * 10.0 ** EXPONENT[unit] >= 2**62 for value in values):
                return None
            largest = np.abs(column).max() if values else column.dtype.type(0)
            if column.itemsize < 8 and float(np.spacing(largest)) * 10.0 ** EXPONENT[unit] > 1:
                return None
            found[role] = [round(value * 10.0 ** EXPONENT[unit]) for value in values]
        else:
            found[role] = [
                int(value) * 10 ** EXPONENT[unit] if unit != "ns" else _half_even(int(value), 1000)
                for value in values
            ]
            if any(abs(value) > 2**63 - 1 for value in (*values, *found[role])):
                return None
    return found


def _half_even(value: int, divisor: int) -> int:
    whole, rest = divmod(value, divisor)
    return whole + (2 * rest > divisor or (2 * rest == divisor and whole % 2 == 1))


@effort(120)
@given(data=st.data(), table=tables(), unit=st.sampled_from(UNITS))
def test_the_same_columns_or_a_clear_error(
    data: st.DataObject, table: dict[str, Any], unit: str
) -> None:
    source = data.draw(layouts(table))
    try:
        events = asap.as_events(source, time_unit=unit)
    except (ValueError, TypeError) as error:
        masked = isinstance(source, np.ma.MaskedArray)
        empty = all(len(column) == 0 for column in table.values())
        assert masked or empty or expected(table, unit) is None, error
        assert re.search(r"\b(t|x|y|p|source|lengths)\b", str(error)), error
        return
    assert events.dtype == asap.EVENT_DTYPE
    assert events.flags.aligned
    assert events.flags.c_contiguous
    odd = any(column.dtype.kind not in "biuf" for column in table.values())
    right = expected(table, unit)
    assert odd or right is not None or len(events) == 0
    if right is not None:
        assert {role: events[role].tolist() for role in "txyp"} == right


@effort(100)
@given(
    array=hnp.arrays(
        st.one_of(hnp.scalar_dtypes(), hnp.array_dtypes(max_size=4)),
        hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4),
    ),
    order=st.sampled_from((None, "txyp", "yxt", "txy", "tt", "")),
    unit=st.sampled_from(UNITS),
    copy=st.sampled_from((None, True, False)),
)
@example(np.zeros((0, 4)), "txyp", "s", None)
@example(np.full((1, 4), np.longdouble("1e4000")), "txyp", "s", None)
def test_any_array(array: Any, order: str | None, unit: str, copy: bool | None) -> None:
    check(array, order=order, time_unit=unit, copy=copy)


def check(source: Any, **options: Any) -> None:
    """Events, or one of the two errors of the documentation."""
    try:
        events = asap.as_events(source, **options)
    except (ValueError, TypeError) as error:
        assert str(error)
    else:
        assert events.dtype == asap.EVENT_DTYPE
        assert events.ndim == 1
        assert np.isin(events["p"], (0, 1)).all()
