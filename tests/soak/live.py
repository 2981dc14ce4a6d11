"""The README's live example for minutes: a recording, or a scene, pushed from its own thread.

python tests/soak/live.py --minutes 1 [FILE]: in turn the loop keeps up, is overloaded, stalls, and
is left by an exception. Exit code 1 when what was sent and what came out does not add up.
"""

from __future__ import annotations

import argparse
import itertools
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator

import numpy as np

import asap

PACKET = 5000  # events


class Interrupted(Exception):
    """What leaves the loop."""


def packets(events: np.ndarray) -> Iterator[np.ndarray]:
    """As a camera's driver hands them out."""
    for begin in range(0, len(events), PACKET):
        yield events[begin : begin + PACKET]


def for_ever(chunks: Iterable[np.ndarray]) -> Iterator[np.ndarray]:
    """The same recording again and again, its stamps going on."""
    kept = [part for chunk in chunks for part in packets(np.array(chunk))]
    begin, end = kept[0]["t"][0], kept[-1]["t"][-1]
    for turn in itertools.count():
        for chunk in kept:
            chunk = chunk.copy()
            chunk["t"] += turn * (end + 1 - begin)
            yield chunk


def body(mood: str) -> Callable[[np.ndarray], None]:
    """What the loop does with a package."""
    tracker = asap.ClusterTracker(1280, 720)
    calls = itertools.count()

    def work(events: np.ndarray) -> None:
        tracker.process(events)
        call = next(calls)
        if mood == "overloaded":
            time.sleep(1e-5 * len(events))
        if mood == "stalled" and call % 100 == 50:
            time.sleep(0.5)
        if mood == "interrupted" and call == 100:
            raise Interrupted

    return work


def session(mood: str, chunks: Iterator[np.ndarray], seconds: float) -> bool:
    """Whether a run in this mood adds up."""
    sent = 0
    seen = 0

    def grab() -> None:
        nonlocal sent
        begin, first = time.monotonic(), None
        while time.monotonic() < begin + seconds:
            events = next(chunks)
            first = events["t"][0] if first is None else first
            due = begin + (events["t"][-1] - first) * 1e-6
            time.sleep(max(0.0, min(due - time.monotonic(), 0.1)))
            try:
                pipeline.push(events)
            except RuntimeError:  # stopped
                break
            sent += len(events)
        pipeline.stop()

    work = body(mood)
    with asap.Pipeline(latency_ms=10) as pipeline:
        camera = threading.Thread(target=grab)
        camera.start()
        try:
            for package in pipeline:
                work(package.events)
                seen += len(package.events)
        except Interrupted:
            pipeline.stop(drain=False)
        camera.join()
    ledger = pipeline.ledger
    stats = pipeline.stats()
    right = ledger.balanced and ledger["received"] == sent and ledger["delivered"] == seen
    p99_ms = stats["latency_us"]["p99"] / 1000
    verdict = "adds up" if right else "WRONG"
    print(f"{mood:<12}{sent} sent, {seen} seen, p99 {p99_ms:.1f} ms, {dict(ledger)}: {verdict}")
    return right


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, required=True)
    parser.add_argument("file", nargs="?", help="default: a synthetic flight")
    options = parser.parse_args()
    source = (
        asap.read(options.file) if options.file else asap.synthetic.FlightOverChairs(duration_s=1.0)
    )
    chunks = for_ever(source)
    moods = ("keeps up", "overloaded", "stalled", "interrupted")
    wrong = [m for m in moods if not session(m, chunks, 60 * options.minutes / len(moods))]
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
