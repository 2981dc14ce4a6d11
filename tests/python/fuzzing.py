"""How hard the fuzz tests try: a sample by default, ten times as much with ASAP_LONG_TESTS=1."""

from __future__ import annotations

import os
from typing import Any

from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

TIMES = 10 if os.environ.get("ASAP_LONG_TESTS") else 1

INTERESTING = (0, 1, 2, 3, 4, 16, 127, 128, 255, 256, 65535, 65536, 2**31 - 1, 2**31, 2**32, 2**63)


def effort(examples: int, long: int | None = None) -> Any:
    """Return settings for so many examples in a normal run and `long` in a long one."""
    count = examples if TIMES == 1 else long or examples * TIMES
    slow = [HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much]
    return settings(max_examples=count, suppress_health_check=slow)


@st.composite
def damaged(draw: st.DrawFn, good: bytes) -> bytes:
    """A file with a few bytes changed, cut out, doubled or put in, most often near its start."""
    data = bytearray(good)
    for _ in range(draw(st.integers(1, 4))):
        size = len(data)
        at = draw(st.one_of(st.integers(0, min(size, 160)), st.integers(0, size)))
        kind = draw(st.sampled_from(("bits", "bytes", "number", "cut", "out", "twice")))
        if kind == "bits" and at < size:
            data[at] ^= draw(st.integers(1, 255))
        elif kind == "bytes":
            put = draw(st.binary(max_size=8))
            data[at : at + len(put)] = put
        elif kind == "number":
            number = draw(st.sampled_from(INTERESTING))
            width = draw(st.sampled_from((1, 2, 4, 8)))
            data[at : at + width] = (number % 256**width).to_bytes(width, "little")
        elif kind == "cut":
            del data[at:]
        elif kind == "out":
            del data[at : at + draw(st.integers(1, 40))]
        else:
            data[at:at] = data[at : at + draw(st.integers(1, 40))]
    return bytes(data)
