"""Events in memory: one dtype, and the way into it by field name.

NumPy's ``astype`` and pybind11's default cast copy structured arrays by *position*: a source that
stores ``t`` first comes out scrambled, without an error. Nothing here does that. A source is
recognised and its columns found in `columns`, checked and packed in `values`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from asap._checks import flag, named
from asap.events.columns import by_name, check_order, columns_of
from asap.events.values import (
    EVENT_DTYPE,
    Events,
    Misfit,
    check_polarity,
    check_unit,
    is_event_memory,
    pack,
    plain_view,
    time_exponent,
)

__all__ = ["EVENT_DTYPE", "Events", "as_events", "events_of_argument", "to_dtype"]


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
        Order of the columns, for sources without names: an arrangement of ``t``, ``x``, ``y`` and
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

    Examples
    --------
    >>> asap.as_events(([10, 20], [3, 3], [4, 5], [1, -1])).tolist()  # t, x, y, p
    [(3, 4, 1, 10), (3, 5, 0, 20)]
    """
    exponent = 0 if time_unit is None else time_exponent(time_unit)
    if order is not None:
        check_order(order)
    if copy is not None:
        flag("copy", copy)
    is_ours = isinstance(source, np.ndarray) and source.dtype == EVENT_DTYPE
    if is_ours and not copy and is_event_memory(source):
        p = source["p"]
        if p.size == 0 or (p.min() >= 0 and p.max() <= 1):
            return plain_view(source)
    columns = columns_of(source, order, exponent=exponent)
    if copy is False:
        raise ValueError(
            "copy = False: this source cannot be taken without a copy; give a contiguous array in "
            "asap.EVENT_DTYPE with polarity 0 or 1, or leave copy out"
        )
    if time_unit is None and not is_ours:
        check_unit(columns["t"])
    if "p" in columns:
        check_polarity(columns["p"], is_ours)
    events = pack(columns, exponent)
    if events is None:
        raise Misfit(columns, exponent)
    return events


def events_of_argument(field: str, events: Any, *, marks: bool = False) -> Events:
    """`as_events` of an argument that is called otherwise, which its refusals then name.

    With `marks`, an event that holds what none can becomes one that a validator counts.
    """
    try:
        return as_events(events)
    except Misfit as error:
        if not marks:
            raise
        return error.marked()
    except (TypeError, ValueError) as error:
        words = str(error)
        if not words.startswith("source"):
            raise
        raise type(error)(field + words.removeprefix("source")) from None


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

    Examples
    --------
    >>> events = asap.synthetic.FlightOverChairs(duration_s=0.01).events()
    >>> asap.to_dtype(events, [("t", "<u8"), ("x", "<u2"), ("y", "<u2"), ("on", "?")]).dtype.names
    ('t', 'x', 'y', 'on')
    """
    events, target = events_of_argument("events", events), np.dtype(dtype)
    places = {name: field[:2] for name, field in (target.fields or {}).items()}
    result = np.zeros(len(events), target)
    fields = by_name(result, places, None)
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
