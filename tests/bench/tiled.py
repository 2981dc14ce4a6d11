"""Time Tiled beside one instance: the speed table of notebooks/algorithms/tiled.md.

    python tests/bench/tiled.py RECORDING EHarris [--threads 2] [--size 10000]

The turns alternate, and the mean of the fastest sixth of 15 counts. It prints ns per event of one
instance, and how many times faster Tiled is.
"""

from __future__ import annotations

import argparse
import time
from statistics import fmean
from typing import Any

import asap

TURNS = 15


def ns_per_event(algorithm: Any, events: Any, size: int) -> float:
    """Give the algorithm the events in packages; return how long it took."""
    algorithm.reset()
    start_ns = time.perf_counter_ns()
    for first in range(0, len(events), size):
        algorithm.process(events[first : first + size])
    return (time.perf_counter_ns() - start_ns) / len(events)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recording")
    parser.add_argument("algorithm")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--size", type=int, default=10_000)
    given = parser.parse_args()
    recording = asap.read(given.recording)
    events, size = asap.load(given.recording), (recording.width, recording.height)
    kind = getattr(asap, given.algorithm)
    both = kind(*size), asap.Tiled(kind, *size, threads=given.threads)
    turns = [[ns_per_event(one, events, given.size) for one in both] for _ in range(TURNS)]
    alone, tiled = (fmean(sorted(times)[: TURNS // 6]) for times in zip(*turns, strict=True))
    print(
        f"{given.algorithm}: {alone:.0f} ns per event, {given.threads} threads: {alone / tiled:.2f}"
    )


if __name__ == "__main__":
    main()
