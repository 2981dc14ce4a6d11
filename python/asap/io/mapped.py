"""Arrays mapped from a file window by window: what was read leaves the memory again."""

from __future__ import annotations

import math
import mmap
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

_WINDOW = 1 << 24  # bytes


def mapped(
    path: Path,
    dtype: np.dtype[Any],
    offset: int,
    shape: tuple[int, ...],
    order: Literal["C", "F"] = "C",
) -> npt.NDArray[Any]:
    """Map one array without reading it; its pages stay as long as a view of it."""
    size = dtype.itemsize * math.prod(shape)
    into_page = offset % mmap.ALLOCATIONGRANULARITY
    start = offset - into_page
    with path.open("rb") as file:
        pages = mmap.mmap(file.fileno(), into_page + size, offset=start, access=mmap.ACCESS_READ)
    array: npt.NDArray[Any] = np.ndarray(shape, dtype, pages, into_page, order=order)
    return array


def windows(rows: int, row_bytes: int, chunk: int) -> Iterator[tuple[int, int]]:
    """Half-open ranges of rows, multiples of `chunk`, of some megabytes each."""
    step = max(_WINDOW // max(row_bytes, 1) // chunk, 1) * chunk
    for start in range(0, rows, step):
        yield start, min(start + step, rows)
