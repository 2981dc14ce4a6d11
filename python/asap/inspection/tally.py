"""How often an anomaly was found, and where first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Integers = npt.NDArray[np.int64]


@dataclass
class Tally:
    """A count, and the first occurrence: number of the event in the source, its own stamp in us."""

    count: int = 0
    event: int | None = None
    t_us: int | None = None

    def add(self, numbers: Integers, stamps: Integers) -> None:
        """Count these events, in the order of the source."""
        if self.event is None and numbers.size:
            self.event, self.t_us = int(numbers[0]), int(stamps[0])
        self.count += int(numbers.size)
