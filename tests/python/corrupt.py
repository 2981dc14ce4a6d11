"""Anomalies made from clean events, seeded: the classes A1 to A13 of bad event data.

Each function takes clean events (``EVENT_DTYPE``, strictly increasing times serve best) and returns
a corrupted copy. How many events it touches is exactly what was asked for, so that a test can
compare counters with it.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import asap
from asap.events import Events

WIDTH, HEIGHT = 346, 260


def clean_events(count: int, *, seed: int = 0, start_us: int = 2_000_000) -> Events:
    """Random pixels, times strictly increasing by 1 to 9 us."""
    random = np.random.default_rng(seed)
    events = np.zeros(count, asap.EVENT_DTYPE)
    events["x"] = random.integers(0, WIDTH, count)
    events["y"] = random.integers(0, HEIGHT, count)
    events["p"] = random.integers(0, 2, count)
    events["t"] = start_us + np.cumsum(random.integers(1, 10, count))
    return events


def _victims(events: Events, count: int, seed: int) -> np.ndarray:
    """Indices of `count` events, never the first, never two neighbours."""
    random = np.random.default_rng(seed)
    return np.sort(random.choice(np.arange(1, len(events), 2), count, replace=False))


def back_steps(events: Events, count: int, *, seed: int = 0, by_us: int = 500) -> Events:
    """A1: `count` single events whose stamp lies up to `by_us` before that of the event before."""
    out = events.copy()
    at = _victims(events, count, seed)
    steps = np.random.default_rng(seed + 1).integers(1, by_us + 1, count)
    out["t"][at] = events["t"][at - 1] - steps
    return out


def clock_reset(events: Events, at: int, *, to_us: int = 0) -> Events:
    """A2: from event `at` on the sensor's clock counts from `to_us` again."""
    out = events.copy()
    out["t"][at:] += to_us - out["t"][at]
    return out


def outside_sensor(events: Events, count: int, *, seed: int = 0) -> Events:
    """A5: `count` events beyond the width or the height."""
    out = events.copy()
    at = _victims(events, count, seed)
    out["x"][at[::2]] = WIDTH + at[::2] % 1000
    out["y"][at[1::2]] = HEIGHT + at[1::2] % 1000
    return out


def one_stamp(events: Events, start: int, count: int) -> Events:
    """A6: `count` events on the stamp of event `start`, then time goes on."""
    out = events.copy()
    out["t"][start : start + count] = out["t"][start]
    return out


def odd_polarity(events: Events, count: int, *, seed: int = 0) -> Events:
    """A8: `count` events keep their polarity, written as -1, 2 or 3."""
    out = events.copy()
    at = _victims(events, count, seed)
    out["p"][at] = np.where(out["p"][at] > 0, 2 + at % 2, -1)
    return out


def duplicates(events: Events, count: int, *, seed: int = 0) -> Events:
    """A8: `count` events come twice."""
    return np.repeat(events, 1 + np.isin(np.arange(len(events)), _victims(events, count, seed)))


def gap(events: Events, at: int, gap_us: int) -> Events:
    """A10: silence of `gap_us` before event `at`."""
    out = events.copy()
    out["t"][at:] += gap_us
    return out


def cut_file(path: Path, size: int) -> None:
    """A13: only the first `size` bytes of the file are there."""
    path.write_bytes(path.read_bytes()[:size])
