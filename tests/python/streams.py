"""Small event streams for the tests, made from a seed."""

from __future__ import annotations

import numpy as np

import asap


def make(t, x=None, y=None, p=None):
    """Events with these stamps; pixels and polarity count up where they are not given."""
    t = np.asarray(t, dtype=np.int64)
    number = np.arange(t.size)
    events = np.zeros(t.size, asap.EVENT_DTYPE)
    events["t"] = t
    events["x"] = number % 346 if x is None else x
    events["y"] = number % 260 if y is None else y
    events["p"] = number % 2 if p is None else p
    return events


def poisson(rate_hz, duration_s, seed=0, t0_us=0):
    """A Poisson stream of about rate_hz * duration_s events on a 346 x 260 sensor."""
    rng = np.random.default_rng(seed)
    count = rng.poisson(rate_hz * duration_s)
    t = t0_us + np.sort(rng.integers(0, int(duration_s * 1e6), count))
    return make(
        t,
        rng.integers(0, 346, count),
        rng.integers(0, 260, count),
        rng.integers(0, 2, count),
    )
