"""What stands around the node in the tests; `ros1_door` and `ros2_door` add how it speaks."""

from __future__ import annotations

import importlib
import json
import os
import re
import signal
import subprocess
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

DATA = Path(os.environ.get("ASAP_TEST_DATA", "none"))


def this_door() -> ModuleType:
    """Return the module that speaks to the middleware of this environment."""
    return importlib.import_module(f"ros{os.environ['ROS_VERSION']}_door")


def wait(condition: Callable[[], Any], what: str, seconds: float = 60.0) -> Any:
    """Return what the condition gives once it is met."""
    end = time.monotonic() + seconds
    while not (met := condition()):
        assert time.monotonic() < end, f"not within {seconds} s: {what}"
        time.sleep(0.01)
    return met


def mono(t_us: Any, x: Any = 1, y: Any = 1) -> bytes:
    """Return ON events as the bytes of a packet; times count from its time_base."""
    words = np.asarray(t_us, np.uint64) * np.uint64(1000)
    words = words | (np.asarray(x, np.uint64) << np.uint64(32))
    words = words | (np.asarray(y, np.uint64) << np.uint64(48)) | np.uint64(1 << 63)
    return words.astype("<u8").tobytes()


def ledger_in(said: str) -> dict[str, int]:
    """Return the ledger that the node has logged last."""
    line = re.findall(r"run ended: (received .*)", said)[-1]
    assert "does not add up" not in line
    return {name: int(count) for name, count in re.findall(r"([a-z]+) (\d+)", line)}


class Packet(NamedTuple):
    """A package as the consumer has it."""

    seq: int
    stamp_ns: int
    width: int
    height: int
    encoding: str
    time_base: int
    events: bytes


class Status(NamedTuple):
    """What the node says of itself: 0 is ok, 1 a warning, 2 an error."""

    level: int
    message: str
    name: str
    hardware_id: str
    values: dict[str, str]


def status_of(message: Any) -> Status:
    """Return the first status of a DiagnosticArray."""
    first = message.status[0]
    level = first.level[0] if isinstance(first.level, bytes) else first.level
    values = {entry.key: entry.value for entry in first.values}
    return Status(level, first.message, first.name, first.hardware_id, values)


class Program:
    """A node's process, until the end of the `with` block."""

    def __init__(self, command: Sequence[str], env: dict[str, str] | None = None) -> None:
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(
            command, env=env, stdout=pipe, stderr=subprocess.STDOUT, text=True
        )

    def __enter__(self) -> Any:
        return self

    def __exit__(self, *error: object) -> None:
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate()

    def end(self) -> tuple[int, str]:
        """Wait for the end; return exit code and what the node said."""
        said, _ = self.process.communicate(timeout=60)
        return self.process.returncode, said

    def interrupt(self) -> tuple[int, str]:
        """Send SIGINT, wait for the end."""
        start = time.monotonic()
        self.process.send_signal(signal.SIGINT)
        code, said = self.end()
        print(f"SIGINT to exit: {(time.monotonic() - start) * 1e3:.0f} ms")
        return code, said


class Ends:
    """Driver, consumer and operator; a door adds how they speak."""

    def __init__(self) -> None:
        self.seq = 0
        self.packets: list[Packet] = []
        self.on_packet: Callable[[Packet], None] = lambda packet: None
        self.stats: list[dict[str, Any]] = []
        self.said: list[Status] = []
        self._seen = 0

    def take(self, packet: Packet) -> None:
        self.packets.append(packet)
        self.on_packet(packet)

    def note(self, stats: Any) -> None:
        self.stats.append(json.loads(stats.data))

    @property
    def events(self) -> np.ndarray:
        """The words of the mono packets that have come."""
        return np.frombuffer(b"".join(packet.events for packet in list(self.packets)), "<u8")

    def play(self, messages: list[tuple[int, bytes]]) -> None:
        """Publish stored messages in their own pace."""
        start = time.monotonic()
        for stamp_ns, message in messages:
            due = start + (stamp_ns - messages[0][0]) * 1e-9
            time.sleep(max(0.0, due - time.monotonic()))
            self.send_raw(message)

    def next_stats(self) -> dict[str, Any]:
        """Return a report that was made from now on."""
        seen = len(self.stats) + 1
        wait(lambda: len(self.stats) > seen, "two reports")
        return self.stats[-1]

    def settled(self) -> dict[str, Any]:
        """Return the report once nothing waits any more."""
        wait(lambda: self.next_stats()["ledger"]["pending"] == 0, "nothing pending")
        return self.stats[-1]

    def diagnosed(self, level: int, message: str) -> Status:
        """Return the next status of the node with this level and these words."""

        def found() -> Status | None:
            while self._seen < len(self.said):
                status = self.said[self._seen]
                self._seen += 1
                if status.level == level and message in status.message:
                    return status
            return None

        return wait(found, f"{level}: {message}; last: {self.said[-1:]}")
