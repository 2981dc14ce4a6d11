"""Matrices of four columns without names, as HDF5 and MATLAB files hold them.

What the columns are is found from the values. The layouts in circulation (MVSEC ``x y t p``, v2e
``t x y p``, rpg_event_lifetime ``x y p t``) all have x before y.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from asap.events import Columns

_MAX_ADDRESS = 65535


def as_rows(shape: tuple[int, ...]) -> tuple[int, bool] | None:
    """Count the events in a matrix of this shape, and say whether they are its columns.

    None if it is not four columns or rows.

    MATLAB 7.3 stores what it calls (N, 4) as (4, N).
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


def columns_of_matrix(rows: npt.NDArray[Any], order: str) -> Columns:
    """Name the columns of a matrix whose rows are events."""
    return {role: rows[:, i] for i, role in enumerate(order)}


def _only_a_time(column: npt.NDArray[Any]) -> bool:
    return bool(np.any(column > _MAX_ADDRESS) or np.any(column != np.floor(column)))


def _ascends(column: npt.NDArray[Any]) -> bool:
    return bool(column[0] < column[-1] and np.all(column[1:] >= column[:-1]))
