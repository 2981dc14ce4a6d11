"""What the columns of a table of numbers are, found from their values.

`arrangement` proposes an order for a message; `order_of` decides for matrices of HDF5 and MATLAB.
The layouts in circulation (MVSEC ``x y t p``, v2e ``t x y p``, rpg_event_lifetime
``x y p t``) all have x before y.
"""

from __future__ import annotations

from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

SAMPLE = 1024  # rows that are enough to tell
_MOST = 0.99  # of the rows that must fit: a recording may have a few bad events
_ADDRESSES = 1 << 16
_HUGE = 2.0**62  # no time in any unit


def arrangement(
    rows: npt.NDArray[Any], width: int | None = None, height: int | None = None
) -> str | None:
    """Return the order of the columns that the rows fit best, such as ``"xytp"``.

    Times do not go back, pixels are whole numbers on the sensor, polarities are -1, 0 or 1. Where
    several orders fit, time is the column that spans most, polarity the smallest, x before y. None
    if no order fits, or the rows do not have 3 or 4 columns.
    """
    if rows.ndim != 2 or rows.shape[1] not in (3, 4):
        return None
    rows = rows[:SAMPLE].astype(np.float64)
    columns = rows[(np.abs(rows) < _HUGE).all(axis=1)].T
    if columns.size == 0:
        return None
    fits = {
        "t": [_share(np.diff(column) >= 0) for column in columns],
        "x": [_on_sensor(column, width) for column in columns],
        "y": [_on_sensor(column, height) for column in columns],
        "p": [_share(np.isin(column, (-1, 0, 1))) for column in columns],
    }
    found = [
        "".join(order)
        for order in permutations("txyp"[: len(columns)])
        if all(fits[role][i] >= _MOST for i, role in enumerate(order))
    ]

    def rank(order: str) -> tuple[float, ...]:
        t = columns[order.index("t")]
        p = columns[order.index("p")].max() if "p" in order else 0.0
        return (np.ptp(t), t.max(), -p, order.index("y") - order.index("x"))

    return max(found, key=rank, default=None)


def between_pixels(rows: npt.NDArray[Any], order: str) -> bool:
    """Whether most of the rows have an x or y that is no whole number."""
    if rows.ndim != 2 or rows.shape[1] != len(order):
        return False
    addresses = rows[:, [i for i, role in enumerate(order) if role in "xy"]]
    return bool((addresses != np.floor(addresses)).any(axis=1).mean() > 0.5)


def looks_like(order: str) -> str:
    """Name the columns, and the option that says so."""
    columns = " or ".join(" ".join(one) for one in _alike(order))
    return f"columns look like {columns}: {as_option(order)}"


def as_option(order: str) -> str:
    """Return the option that names the columns."""
    return " or ".join(f"order={one!r}" for one in _alike(order))


def _alike(order: str) -> list[str]:
    """List the orders that the values cannot tell apart: without polarities, x and y."""
    swapped = order.translate({ord("x"): "y", ord("y"): "x"})
    return [order] if "p" in order else [order, swapped]


def _on_sensor(column: npt.NDArray[np.float64], side: int | None) -> float:
    return _share((column >= 0) & (column < (side or _ADDRESSES)) & (column == np.floor(column)))


def _share(fits: npt.NDArray[np.bool_]) -> float:
    return float(fits.mean()) if fits.size else 1.0


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
    return bool(np.any(column >= _ADDRESSES) or np.any(column != np.floor(column)))


def _ascends(column: npt.NDArray[Any]) -> bool:
    return bool(column[0] < column[-1] and np.all(column[1:] >= column[:-1]))
