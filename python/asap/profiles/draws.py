"""Random numbers and rounding that are the same on every machine."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Floats: TypeAlias = npt.NDArray[np.float64]


def portable(values: npt.ArrayLike) -> Floats:
    """Round to 24 bits: math libraries differ in the last one, a stream must not."""
    return np.asarray(values, np.float64).astype(np.float32).astype(np.float64)


class Draws:
    """Random numbers from the bits of a generator that NumPy promises to keep as it is."""

    def __init__(self, seed: int) -> None:
        self._bits = np.random.PCG64(seed)

    def uniform(self, size: int) -> Floats:
        """In [0, 1)."""
        bits = np.asarray(self._bits.random_raw(size), np.uint64)
        values: Floats = (bits >> np.uint64(11)) * 2.0**-53
        return values

    def exponential(self, mean: float, size: int) -> Floats:
        """Of this mean."""
        return -mean * np.log1p(-self.uniform(size))

    def normal(self, size: int) -> Floats:
        """Of mean 0 and variance 1."""
        radius = np.sqrt(-2.0 * np.log1p(-self.uniform(size)))  # Box-Muller
        return radius * np.cos(2.0 * np.pi * self.uniform(size))
