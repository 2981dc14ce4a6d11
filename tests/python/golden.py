"""The stream and the hash of the golden vectors."""

from __future__ import annotations

import functools

import numpy as np

from asap import EVENT_DTYPE


@functools.cache
def golden_stream(count: int = 200_000) -> np.ndarray:
    """Six swinging squares of 40 px, one polarity per side, and a sixteenth of noise."""
    state = 88172645463325252

    def draw() -> int:
        nonlocal state
        state ^= (state << 13) & (2**64 - 1)
        state ^= state >> 7
        state ^= (state << 17) & (2**64 - 1)
        return state >> 32

    def triangle(a: int, m: int) -> int:
        return abs(a % (2 * m) - m)

    events = np.zeros(count, EVENT_DTYPE)
    for i in range(count):
        u = draw()
        if u % 16 == 0:
            x, y, p = draw() % 346, draw() % 260, draw() % 2
        else:
            k = (u // 16) % 6
            x = 30 + 100 * (k % 3) + triangle(i // 150 + 17 * k, 25)
            y = 30 + 110 * (k // 3) + triangle(i // 210 + 29 * k, 25)
            q = draw() % 160
            a = q % 40
            dx, dy, p = [(a, 0, 1), (40, a, 0), (40 - a, 40, 0), (0, 40 - a, 1)][q // 40]
            x, y = x + dx, y + dy
        events[i] = (x, y, p, 10 * (i + 1))
    events.flags.writeable = False
    return events
