"""Arrays mapped from a file window by window: what was read leaves the memory again."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["mapped", "windows"]

_WINDOW = 1 << 24  # bytes


def mapped(
    path: Path, dtype: np.dtype[Any], offset: int, shape: tuple[int, ...], order: Any = "C"
) -> npt.NDArray[Any]:
    """Map one array without reading it; its pages stay as long as a view of it."""
    return np.memmap(path, dtype, "r", offset, shape, order).view(np.ndarray)


def windows(rows: int, row_bytes: int, chunk: int) -> Iterator[tuple[int, int]]:
    """Half-open ranges of rows, multiples of `chunk`, of some megabytes each."""
    step = max(_WINDOW // max(row_bytes, 1) // chunk, 1) * chunk
    for start in range(0, rows, step):
        yield start, min(start + step, rows)
