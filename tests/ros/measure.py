"""Measures the figures of the README of asap_ros; tests/ros/run makes what it needs.

    . build/ros2/workspace/setup && . build/ros2/colcon/install/setup.bash
    python tests/ros/measure.py [SECONDS]

Alternates the node and a bare relay of the same messages, each between a driver and a consumer in
C++. One line per run; `busy` is the share of the machine's processors that all its programs took
meanwhile. Before each run it waits until the machine is quiet, SECONDS at most, 0 by default.
Processor time is that of the process in between, user and system.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from door import ledger_in
from ros2_door import AsapNode, CppPeer

REPEATS = 3
QUIET = 0.1  # busy
TICK_S = 1 / os.sysconf("SC_CLK_TCK")
PATIENCE_S = float(sys.argv[1]) if len(sys.argv) > 1 else 0.0


def cpu_s(process: subprocess.Popen[str]) -> float:
    """Return the processor time that a process has used, s."""
    words = Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(words[11]) + int(words[12])) * TICK_S


@contextmanager
def watched() -> Iterator[dict[str, Any]]:
    """A result, to which it adds the share of the processors that was busy meanwhile."""

    def times() -> tuple[int, int]:
        ticks = [int(word) for word in Path("/proc/stat").read_text().split("\n")[0].split()[1:9]]
        return sum(ticks), ticks[3] + ticks[4]  # idle, waiting for the disc

    before, result = times(), {}
    yield result
    total, idle = (after - then for after, then in zip(times(), before, strict=True))
    result["busy"] = round(1 - idle / max(1, total), 2)


def wait_for_quiet() -> None:
    """Return when the machine has been quiet for two seconds, or patience is over."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        with watched() as machine:
            time.sleep(2.0)
        if machine["busy"] < QUIET:
            return


def say(what: str, result: dict[str, Any]) -> None:
    print(f"{what}: {json.dumps(result)}", flush=True)


def between(middle: Any, topic: str, events: int, messages: int, period_us: int) -> dict[str, Any]:
    """Return what arrives behind `middle`, and its processor time per event."""
    with watched() as result:
        with middle, CppPeer("sink", topic, events * messages) as sink:
            with CppPeer("source", events, messages, period_us) as source:
                before_s = cpu_s(middle.process)
                took_s = source.result()["seconds"]
                used_s = cpu_s(middle.process) - before_s
            result.update(sink.result())
            if isinstance(middle, AsapNode):
                result["ledger"] = ledger_in(middle.interrupt()[1])
        result["Mev/s"] = round(events * messages / took_s * 1e-6, 2)
        result["cpu_ns"] = round(used_s * 1e9 / (events * messages), 1)
    return result


def interrupted() -> dict[str, Any]:
    """Return how long a node that is fed takes from SIGINT to its end."""
    with watched() as result, AsapNode() as node, CppPeer("source", 1_000, 20_000, 1_000):
        time.sleep(3.0)
        start = time.monotonic()
        result["code"], said = node.interrupt()
        result |= {"ms": round((time.monotonic() - start) * 1e3), "ledger": ledger_in(said)}
    return result


def main() -> None:
    """Print the figures."""
    with CppPeer("codec", 1_000, 5_000) as codec:
        say("decode and encode alone, messages of 1,000 events", codec.result())
    for _ in range(REPEATS):
        for name in ("relay", "asap"):
            wait_for_quiet()
            middle = CppPeer("relay") if name == "relay" else AsapNode(latency_ms=10)
            say(f"1 Mev/s, {name}", between(middle, f"{name}/events", 1_000, 5_000, 1_000))
    for role in ("relay", "asap") * REPEATS:
        wait_for_quiet()
        with watched() as result, CppPeer("process", role, 1_000, 5_000, 1_000) as process:
            result.update(process.result())
        say(f"1 Mev/s in one process, {role}", result)
    for period_us in (1_000,) * REPEATS + (0,):
        wait_for_quiet()
        result = between(AsapNode(latency_ms=100), "asap/events", 20_000, 5_000, period_us)
        say(f"20,000 events per message, {period_us} us apart", result)
    for _ in range(2 * REPEATS):
        wait_for_quiet()
        say("SIGINT while 1 Mev/s come", interrupted())


if __name__ == "__main__":
    main()
