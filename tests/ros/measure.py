"""Measures the figures of the README of asap_ros; tests/ros/run makes what it needs.

    . build/ros2/workspace/setup && . build/ros2/colcon/install/setup.bash
    ASAP_TEST_DATA=none python tests/ros/measure.py

Alternates the node and a bare relay of the same messages, each between a driver and a consumer in
C++; one line per run. Processor time is that of the process in between, user and system.
"""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import Any

from peers import PRELOAD, AsapNode, CppPeer, ledger_in, program

REPEATS = 3
TICK_S = 1 / os.sysconf("SC_CLK_TCK")


def cpu_s(process: subprocess.Popen[str]) -> float:
    """Return the processor time that a process has used, s."""
    words = Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(words[11]) + int(words[12])) * TICK_S


def between(middle: Any, topic: str, events: int, messages: int, period_us: int) -> dict[str, Any]:
    """Return what arrives behind `middle`, and its processor time per event."""
    with middle, CppPeer("sink", topic, events * messages) as sink:
        with CppPeer("source", events, messages, period_us) as source:
            before_s = cpu_s(middle.process)
            took_s = source.result()["seconds"]
            used_s = cpu_s(middle.process) - before_s
        arrived = sink.result()
        if isinstance(middle, AsapNode):
            arrived["ledger"] = ledger_in(middle.interrupt()[1])
    return {
        **arrived,
        "Mev/s": round(events * messages / took_s * 1e-6, 2),
        "cpu_ns": round(used_s * 1e9 / (events * messages), 1),
    }


def main() -> None:
    """Print the figures."""
    with CppPeer("codec", 1_000, 5_000) as codec:
        print("decode and encode alone, messages of 1,000 events:", codec.result())
    for _ in range(REPEATS):
        relay = between(CppPeer("relay"), "relay/events", 1_000, 10_000, 1_000)
        node = between(AsapNode(latency_ms=10), "asap/events", 1_000, 10_000, 1_000)
        print("1 Mev/s  relay:", relay)
        print("1 Mev/s  asap: ", node)
    for role in ("relay", "asap") * REPEATS:
        with CppPeer("process", role, 1_000, 10_000, 1_000) as process:
            print(f"1 Mev/s in one process, {role}:", process.result())
    for period_us in (1_000,) * REPEATS + (0,):
        node = AsapNode(latency_ms=100)
        print("20,000 events/message:", between(node, "asap/events", 20_000, 5_000, period_us))


if __name__ == "__main__":
    assert PRELOAD["LD_PRELOAD"], program("asap_ros", "peer")
    main()
