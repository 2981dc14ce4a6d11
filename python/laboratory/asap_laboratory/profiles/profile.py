"""Profile: Poisson arrivals of any rate, as a stream of real events."""

from __future__ import annotations

import sys
from collections.abc import Iterator

import numpy as np

from asap import _checks
from asap.events import Events
from asap.synthetic import SyntheticStream, joined
from asap_laboratory import _native
from asap_laboratory.profiles.rates import PROFILES, Floats, RandomRate, Rate, portable

_STEP_US = 100
_STEPS_PER_BLOCK = 10_000
_MAX_RATE = 2e9


class Profile(SyntheticStream):
    """Poisson arrivals of a rate that changes in time.

    Parameters
    ----------
    rate : str or callable
        A name of `PROFILES`, or a function that takes times in s, an array of shape (n,), and
        returns events per second, an array of that shape or one number; times the scale they are
        between 0 and 2e9. It is asked for the middles of steps of 0.1 ms, 1 s at a time.
    duration_s : float
        0.01 to 86400 s.
    seed : int
        0 <= seed < 2**64.
    noise : float
        0 to 1. Within each step the rate is multiplied by ``exp(noise * y - noise**2 / 2)``, where
        y is Gaussian of unit variance with a correlation time of 1 ms. 0: an exact Poisson process.
    width, height : int
        Size of the sensor, 16 to 8192 px. Pixels are uniform, polarities random.
    scale : float
        Factor on the rate.
    name : str, optional
        How the stream is called in tables; the name of the rate unless given.

    Raises
    ------
    ValueError
        A parameter is out of its range, or the rate is; the message names the value and the time.
        A rate beyond the first second raises when it is reached.

    Examples
    --------
    >>> round(Profile("high", duration_s=0.1, noise=0.0).events().size, -5)
    1000000
    >>> Profile(lambda t: 2e6 * t, duration_s=1.0, name="climb").name
    'climb'
    """

    def __init__(
        self,
        rate: str | Rate | RandomRate,
        *,
        duration_s: float = 5.0,
        seed: int = 1,
        noise: float = 0.2,
        width: int = 346,
        height: int = 260,
        scale: float = 1.0,
        name: str | None = None,
    ) -> None:
        known = isinstance(rate, str) and rate in PROFILES
        if not (known or callable(rate) or isinstance(rate, RandomRate)):
            raise ValueError(
                f"rate = {rate!r}: give a function of t, s, or one of {', '.join(PROFILES)}"
            )
        _checks.number("scale", scale, 0, sys.float_info.max, "give a factor of 0 or more")
        if not (name is None or isinstance(name, str)):
            raise TypeError(_checks.named("name", name, "give text or None"))
        called = rate if isinstance(rate, str) else getattr(rate, "__name__", "<lambda>")
        self.name = name or ("profile" if called == "<lambda>" else called)
        super().__init__(
            rate=rate,
            duration_s=duration_s,
            seed=seed,
            noise=noise,
            width=width,
            height=height,
            scale=scale,
            name=name,
        )

    def rates(self) -> Iterator[Floats]:
        """Yield events per second, without the noise, in steps of 0.1 ms; 1 s per array."""
        rate = self._parameters["rate"]
        rate = PROFILES[rate] if isinstance(rate, str) else rate
        rate = rate.seeded(self._parameters["seed"]) if isinstance(rate, RandomRate) else rate
        steps = -(-self._duration_us // _STEP_US)
        for first in range(0, steps, _STEPS_PER_BLOCK):
            last = min(first + _STEPS_PER_BLOCK, steps)
            t = (np.arange(first, last, dtype=np.float64) + 0.5) * (_STEP_US * 1e-6)
            yield _rates_at(t, rate, float(self._parameters["scale"]))

    @property
    def _duration_us(self) -> int:
        return round(self.duration_s * 1e6)

    def _open(self) -> _Reading:
        parameters = self._parameters
        arrivals = _native.PoissonArrivals(
            width=parameters["width"],
            height=parameters["height"],
            duration_us=self._duration_us,
            t0_us=0,
            noise=parameters["noise"],
            seed=parameters["seed"],
        )
        return _Reading(arrivals, self.rates())


def _rates_at(t: Floats, rate: Rate, scale: float) -> Floats:
    rates = np.asarray(rate(t), np.float64) * scale
    if rates.shape not in ((), t.shape):
        raise ValueError(f"rate: of shape {rates.shape} at times of shape {t.shape}")
    rates = np.broadcast_to(rates, t.shape)
    bad = ~((rates >= 0.0) & (rates <= _MAX_RATE))  # true for NaN
    if bad.any():
        first = int(bad.argmax())
        raise ValueError(
            f"rate = {rates[first]:g} at t = {t[first]:g} s: give events per second, 0 to 2e9"
        )
    return portable(rates)


class _Reading:
    """Arrivals that get their rates as they are read."""

    def __init__(self, arrivals: _native.PoissonArrivals, rates: Iterator[Floats]) -> None:
        self._arrivals, self._rates = arrivals, rates
        self._feed()  # a bad rate shows at once

    def read(self, at_least: int) -> Events:
        arrays = [self._arrivals.read(at_least)]
        missing = at_least - len(arrays[0])
        while missing > 0 and self._feed():
            arrays.append(self._arrivals.read(missing))
            missing -= len(arrays[-1])
        return arrays[0] if len(arrays) == 1 else joined(arrays)

    def _feed(self) -> bool:
        rates = next(self._rates, None)
        if rates is not None:
            self._arrivals.feed(rates)
        return rates is not None
