"""What the values of four columns may be, and how they become events: the last of three steps.

`columns` finds the columns before; `events` is what users call.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from asap import _core, _units
from asap._checks import is_masked

Events: TypeAlias = npt.NDArray[np.void]
Column: TypeAlias = npt.NDArray[Any]
Columns: TypeAlias = Mapping[str, Column]
Mask: TypeAlias = npt.NDArray[np.bool_]

# Offsets 0 2 4 8, 16 bytes. Without align=True np.concatenate would pack them to 14 bytes.
EVENT_DTYPE = np.dtype([("x", "<u2"), ("y", "<u2"), ("p", "<i2"), ("t", "<i8")], align=True)

# A unit of time is 10^exponent us.
TIME_EXPONENTS = {"s": 6, "ms": 3, "us": 0, "ns": -3}
_FINE_EXPONENTS = {"ns": -3, "ps": -6, "fs": -9, "as": -12}  # units of datetime64 and timedelta64

MAX = 2**63 - 1  # us
HEAD = 1001  # events whose steps say something
_SOME = 100  # timestamps that tell a unit
_MAX_PER_US = 100  # more than any camera sends
_LONG_US = 10_000  # between events of a camera
_REMEDIES = {
    "t": "no time in 64-bit us; check time_unit",
    "p": "no polarity",
} | dict.fromkeys("xy", "no pixel: whole numbers from 0 to 65535; drop or repair these events")


def time_exponent(time_unit: str) -> int:
    """Exponent e of a unit of 10^e us."""
    if not isinstance(time_unit, str) or time_unit not in TIME_EXPONENTS:
        raise ValueError(f"time_unit = {time_unit!r}: use one of {', '.join(TIME_EXPONENTS)}")
    return TIME_EXPONENTS[time_unit]


# ---- what is doubtful -----------------------------------------------------------------------


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


def check_polarity(p: Column, is_ours: bool) -> None:
    """Refuse two values above 0, which would all be ON (in ours, if none is OFF), and -1 beside 0.

    These two are 0 and 1 in a signed type of one bit.
    """
    if p.dtype.kind == "i" and not is_ours and p.size and p.max() == 0 > p.min():
        raise ValueError(f"p = {p.min()}: is below 0, which is OFF, as 0 is; give p == {p.min()}")
    above = p if p.dtype.kind == "f" or (p.size and p.max() > 1) else p[:0]
    above = above[above > 0]
    if above.size == 0 or (is_ours and above.size < p.size):
        return
    low, high = above.min(), above.max()
    if low != high:
        remedy = f"and {high:g} are both above 0, which is ON; give p == {high:g}"
        raise ValueError(f"p = {low:g}: {remedy} if {low:g} is OFF")


def check_unit(t: Column) -> None:
    """Refuse times without a unit that hardly are microseconds, or warn of them."""
    if t.dtype.kind == "f":
        raise ValueError(
            f"time_unit = None: t is {t.dtype}; floating times need their unit, give "
            "asap.as_events(..., time_unit='s')"
        )
    if are_thousands(t):
        raise ValueError(
            "time_unit = None: t are whole multiples of 1000; give "
            "asap.as_events(..., time_unit='us') or time_unit='ns'"
        )
    if len(t) < HEAD or t.dtype.kind not in "iu":
        return
    span_us = int(t[-1]) - int(t[0])
    is_dense, is_sparse = len(t) > _MAX_PER_US * (span_us + 1), span_us > _LONG_US * len(t)
    if span_us < 0 or not (is_dense or is_sparse):  # one that is not sorted tells nothing
        return
    if doubt := unit_doubt("us", len(t), span_us, np.diff(t[:HEAD])):
        warnings.warn(f"t: {doubt[0]}; {doubt[1]} to asap.as_events", stacklevel=3)


def are_thousands(t: Column) -> bool:
    """Whether stamps are all multiples of 1000, which a camera's clock gives in ns alone."""
    some = t[:1000] if t.dtype.kind in "iu" else t[:0]
    steps = np.count_nonzero(np.diff(np.sort(some)))  # np.unique imports numpy.ma in a first push
    return steps + 1 >= _SOME and not np.any(some % 1000) and not np.any(t % 1000)


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
    if unit == "us" and count > _MAX_PER_US * (span_us + 1):
        words = f"{count} events within {span_us} us, which is short for a camera"
    elif step_us > _LONG_US:
        words = f"the times step by {_units.duration(step_us)}, which is long for a camera"
    else:
        return None
    return words, f"if they are not in {unit}, give time_unit"


# ---- what no event can hold -----------------------------------------------------------------


def misfits(role: str, column: Column, exponent: int = 0) -> Mask:
    """Mark the values that an event cannot hold: there and back they are others."""
    with np.errstate(invalid="ignore"):
        there = column
        if role in "xy":
            there = column.astype(np.uint16)
        elif column.dtype.kind in "mM":
            there = np.asarray(_counts(column)[0], column.dtype)  # NaT differs from itself
        elif role == "t" and column.dtype.kind == "f":
            return np.asarray(~(np.abs(column) < 2.0**62 / 10.0**exponent))
        elif role == "t":
            there, limit = column.astype(np.int64), MAX // 10 ** max(exponent, 0)
            return np.asarray((there != column) | (there < -limit) | (there > limit))
        return np.asarray(there != column)


class Misfit(ValueError):
    """Field, value and remedy of the first event that is none; the columns begin with `first`."""

    def __init__(self, columns: Columns, exponent: int = 0, first: int = 0) -> None:
        self._columns, self._exponent = columns, exponent
        self._masks = {role: misfits(role, one, exponent) for role, one in columns.items()}
        found = ((int(np.argmax(bad)), role) for role, bad in self._masks.items() if bad.any())
        at, role = min(found)
        super().__init__(f"{role} = {columns[role][at]} (event {first + at}): {_REMEDIES[role]}")

    def __reduce__(self) -> tuple[type[ValueError], tuple[Any, ...]]:
        return ValueError, self.args  # without the columns

    def marked(self) -> Events:
        """Return all events; a validator counts those that are none, by their stamp, as bad."""
        bad = np.any(list(self._masks.values()), axis=0)
        columns = {role: column.copy() for role, column in self._columns.items()}
        for column in columns.values():
            column[bad] = 0
        events = pack(columns, self._exponent)
        assert events is not None
        events["t"][bad] = MAX
        return events


# ---- events ---------------------------------------------------------------------------------


def pack(
    columns: Columns, exponent: int = 0, *, normalise: bool = True, out: Events | None = None
) -> Events | None:
    """Columns as events, written into `out` where it is given; None if there is a misfit.

    Without `normalise`, a polarity other than 0 and 1 becomes -1 or 2, for a validator to count.
    """
    t = columns["t"]
    if t.dtype.kind in "mM" or (exponent and t.dtype.kind != "f"):
        if misfits("t", t, exponent).any():
            return None
        t, exponent = _to_us(t, exponent), 0
    return _core.events_of_columns(
        t,
        columns["x"],
        columns["y"],
        columns.get("p"),
        us_per_unit=10.0**exponent,
        normalise=normalise,
        out=out,
    )


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


def _to_us(t: Column, exponent: int) -> npt.NDArray[np.int64]:
    """Whole us, half to even, of stamps whose unit is 10^exponent us or, of NumPy's, their own."""
    if t.dtype.kind in "mM":
        t, exponent = _counts(t)
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
