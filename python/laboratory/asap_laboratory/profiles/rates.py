"""The named rates: functions of time, and those that a seed draws piece by piece."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from asap import _checks

Floats: TypeAlias = npt.NDArray[np.float64]
Rate: TypeAlias = Callable[[Floats], npt.ArrayLike]
Pieces: TypeAlias = Iterator[tuple[Floats, Floats]]


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


_MAX_RANDOM_RATE = 100e6  # where a lognormal level ends; 15 times as much is still a valid rate


class _Path:
    """A piecewise constant rate: pieces are drawn as time goes on and forgotten behind it."""

    def __init__(self, new_pieces: Callable[[], Pieces]) -> None:
        self._new_pieces = new_pieces
        self._restart()

    def _restart(self) -> None:
        self._pieces = self._new_pieces()
        self._begin = 0.0
        self._ends: Floats = np.zeros(1)  # a first piece of no duration
        self._rates: Floats = np.zeros(1)

    def __call__(self, t: Floats) -> Floats:
        if t.min() < self._begin:
            self._restart()
        while self._ends[-1] <= t.max():
            durations, rates = next(self._pieces)
            self._ends = np.append(self._ends, self._ends[-1] + np.cumsum(durations))
            self._rates = np.append(self._rates, rates)
        piece = np.searchsorted(self._ends, t, side="right")
        values: Floats = self._rates[piece]
        if past := int(piece.min()):
            self._begin = float(self._ends[past - 1])
            self._ends, self._rates = self._ends[past:], self._rates[past:]
        return values


class RandomRate:
    """A rate that the seed of the profile draws.

    Parameters
    ----------
    pieces : callable
        Takes random draws and yields, without end, arrays of durations (s) and rates (events/s).
    """

    def __init__(self, pieces: Callable[[Draws], Pieces]) -> None:
        if not callable(pieces):
            raise TypeError(_checks.named("pieces", pieces, "give a callable"))
        self._pieces = pieces

    def seeded(self, seed: int) -> Rate:
        """Return the rate as a function of t, s; cheapest where t grows from call to call."""
        return _Path(lambda: self._pieces(Draws(seed)))


def _walk(draws: Draws) -> Pieces:
    while True:  # anew every 2 s: left alone, it would end up at its limits for good
        logarithm = np.cumsum(0.35 * draws.normal(400))
        yield np.full(400, 0.005), np.clip(3e6 * np.exp(logarithm), 0.01e6, 30e6)


def _telegraph(draws: Draws) -> Pieces:
    while True:
        on, off = 9e6 * np.exp(0.7 * draws.normal(64)), 1e6 * np.exp(0.6 * draws.normal(64))
        rates = np.column_stack((on, off)).ravel()
        yield draws.exponential(0.012, rates.size), np.minimum(rates, _MAX_RANDOM_RATE)


def _ou4ms(draws: Draws) -> Pieces:
    memory = math.exp(-1.0 / 4.0)
    push = math.sqrt(1.0 - memory * memory)
    y = draws.normal(1)[0]
    while True:
        path = []
        for normal in draws.normal(1000):
            path.append(y)
            y = memory * y + push * normal
        rates = 3e6 * np.exp(0.8 * np.array(path))
        yield np.full(1000, 0.001), np.minimum(rates, _MAX_RANDOM_RATE)


_TWOSTEP = np.array([0.05e6, 8e6, 0.5e6, 25e6])

#: Events per second as a function of t, s. The ramps start anew every 5 s.
PROFILES: dict[str, Rate | RandomRate] = {
    "quiet": lambda t: 0.002e6,
    "low": lambda t: 0.1e6,
    "uav": lambda t: 0.3e6 + 2.5e6 * (t % 5.0) / 5.0,
    "flicker": lambda t: np.where(t % 0.010 < 0.005, 6e6, 0.05e6),
    "steps": lambda t: np.where(t % 1.0 >= 0.5, 6e6, 0.3e6),
    "bursts": lambda t: np.where(t % 0.100 < 0.010, 30e6, 0.5e6),
    "high": lambda t: 10e6,
    "ramp": lambda t: 20e6 * (t % 5.0) / 5.0,
    "steps60": lambda t: np.where(t % 1.0 >= 0.5, 60e6, 3e6),
    "sawtooth": lambda t: 0.2e6 + 9e6 * (3.7 * t % 1.0),
    "spikes": lambda t: np.where(t % 0.053 < 0.003, 40e6, 0.8e6),
    "walk": RandomRate(_walk),
    "breath": lambda t: 4e6 * (1.0 + np.sin(2.0 * np.pi * 1.3 * t)),
    "twostep": lambda t: _TWOSTEP[(t % 1.6 / 0.4).astype(int)],
    "telegraph": RandomRate(_telegraph),
    "ou4ms": RandomRate(_ou4ms),
    "train": lambda t: np.where((t % 0.0043 < 0.0011) & (t % 0.310 < 0.120), 16e6, 0.6e6),
}

#: The profiles that the comparison runs for 2 s, and 15 times as fast with the cost model "fast".
FURTHER = ("sawtooth", "spikes", "walk", "breath", "twostep", "telegraph", "ou4ms", "train")
