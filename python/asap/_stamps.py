"""Time stamps of any unit, NumPy's among them, as whole microseconds."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

Column: TypeAlias = npt.NDArray[Any]

# A unit of time is 10^exponent us.
TIME_EXPONENTS = {"s": 6, "ms": 3, "us": 0, "ns": -3}
_FINE_EXPONENTS = {"ns": -3, "ps": -6, "fs": -9, "as": -12}  # units of datetime64 and timedelta64

MAX = 2**63 - 1  # us
_SOME = 100  # stamps that tell a unit


def time_exponent(time_unit: str) -> int:
    """Exponent e of a unit of 10^e us."""
    if not isinstance(time_unit, str) or time_unit not in TIME_EXPONENTS:
        raise ValueError(f"time_unit = {time_unit!r}: use one of {', '.join(TIME_EXPONENTS)}")
    return TIME_EXPONENTS[time_unit]


def are_thousands(t: Column) -> bool:
    """Whether stamps are all multiples of 1000, which a camera's clock gives in ns alone."""
    some = t[:1000] if t.dtype.kind in "iu" else t[:0]
    steps = np.count_nonzero(np.diff(np.sort(some)))  # np.unique imports numpy.ma in a first push
    return steps + 1 >= _SOME and not np.any(some % 1000) and not np.any(t % 1000)


def misfits(stamps: Column) -> npt.NDArray[np.bool_]:
    """Mark the stamps of NumPy that are none in 64-bit us: there and back they are others."""
    there_and_back = _counts(stamps)[0].astype(stamps.dtype)
    return np.asarray(there_and_back != stamps)  # NaT differs from itself


def shifted(t: Column, offset: Column) -> Column:
    """Add `offset`, in the unit of the times, to times that count from it."""
    if offset.size != 1 or offset.dtype.kind not in "iu" or t.dtype.kind not in "biuf":
        raise ValueError(f"t_offset = {offset}: one whole number is needed, and numbers as times")
    by = int(offset.item())
    if t.dtype.kind == "f":
        return np.asarray(t + float(by))
    ends = (int(t.min()) + by, int(t.max()) + by) if t.size else (by, by)
    if max(map(abs, (by, *ends))) > MAX:
        raise ValueError(f"t_offset = {by}: the times leave 64-bit us")
    return np.asarray(t.astype(np.int64) + by)


def to_us(t: Column, exponent: int) -> npt.NDArray[np.int64]:
    """Whole us, half to even, of stamps whose unit is 10^exponent us or, of NumPy's, their own."""
    if t.dtype.kind in "mM":
        t, exponent = _counts(t)
    if t.dtype.kind == "f":
        return np.rint(t * 10.0**exponent).astype(np.int64)
    whole: npt.NDArray[np.int64] = t.astype(np.int64)
    if exponent >= 0:
        whole *= 10**exponent
        return whole
    us, rest = np.divmod(whole, 10**-exponent)
    half = 10**-exponent // 2
    us[(rest > half) | ((rest == half) & (us % 2 == 1))] += 1
    return us


def _counts(stamps: Column) -> tuple[Column, int]:
    """Stamps of NumPy in us, or finer where they are, and the exponent of that unit."""
    unit, _ = np.datetime_data(stamps.dtype)
    exponent = _FINE_EXPONENTS.get(unit, 0)
    counts: Column = stamps.astype(f"{stamps.dtype.kind}8[{unit if exponent else 'us'}]")
    return counts, exponent
