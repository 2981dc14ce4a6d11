"""What stands around the node in the tests: master, its process, a driver, a consumer, messages."""

from __future__ import annotations

import json
import os
import re
import signal
import socket
import struct
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import genpy
import numpy as np
import rosgraph
import rospy
from std_msgs.msg import String

DATA = Path(os.environ.get("ASAP_TEST_DATA", "none"))
RECORD = np.dtype([("x", "<u2"), ("y", "<u2"), ("s", "<u4"), ("ns", "<u4"), ("p", "u1")])
WORDS = 10_000  # messages that wait in rospy


class Master:
    """A roscore on loopback; it may die and come back."""

    def __init__(self) -> None:
        with socket.socket() as probe:
            probe.bind(("localhost", 0))
            self.port = probe.getsockname()[1]
        os.environ["ROS_MASTER_URI"] = f"http://localhost:{self.port}"
        os.environ["ROS_HOSTNAME"] = "localhost"
        os.environ["ROS_HOME"] = tempfile.mkdtemp(prefix="asap_ros_")
        self.process: subprocess.Popen | None = None

    def start(self) -> None:
        self.process = subprocess.Popen(
            ["roscore", "-p", str(self.port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        wait(lambda: rosgraph.is_master_online(), "a master")
        wait(lambda: "/rosout" in node_names(), "all of roscore")

    def kill(self) -> None:
        assert self.process is not None
        self.process.send_signal(signal.SIGINT)
        self.process.wait()
        assert not rosgraph.is_master_online()


def node_names() -> set[str]:
    """Return the nodes that the master knows."""
    state = rosgraph.Master("/test").getSystemState()
    return {name for kind in state for _, names in kind for name in names}


def wait(condition: Callable[[], Any], what: str, seconds: float = 60.0) -> Any:
    """Return what the condition gives once it is met."""
    end = time.monotonic() + seconds
    while not (met := condition()):
        assert time.monotonic() < end, f"not within {seconds} s: {what}"
        time.sleep(0.01)
    return met


def raw_type(name: str, md5: str) -> type:
    """Return a type of rospy whose messages are any bytes."""

    class Raw(genpy.Message):
        _type, _md5sum, _full_text, _has_header = name, md5, "", False
        __slots__ = _slot_types = ("data",)

        def __init__(self, data: bytes = b"") -> None:
            self.data = data

        def serialize(self, buffer: Any) -> None:
            buffer.write(self.data)

        def deserialize(self, data: bytes) -> Raw:
            self.data = data
            return self

    return Raw


# The sums are those of the published packages: a subscriber compares them.
Array = raw_type("dvs_msgs/EventArray", "5e8beee5a6c107e504c2e78903c224b8")
Packet = raw_type("event_camera_msgs/EventPacket", "8a6101b351a64529ac77bd8b71074e52")


def header(seq: int, frame_id: bytes = b"camera", stamp_s: int = 1_700_000_000) -> bytes:
    return struct.pack("<IIII", seq, stamp_s, 5, len(frame_id)) + frame_id


def seq_of(message: bytes) -> int:
    return struct.unpack_from("<I", message)[0]


def stamp_of(message: bytes) -> float:
    """Return the stamp of a message in s."""
    _, s, ns = struct.unpack_from("<III", message)
    return s + ns * 1e-9


def array(
    t_us: Any,
    x: Any = 1,
    y: Any = 1,
    *,
    seq: int = 0,
    width: int = 640,
    height: int = 480,
    stamp_s: int = 1_700_000_000,
) -> bytes:
    """Return ON events as an EventArray."""
    t_us = np.asarray(t_us, np.int64)
    records = np.zeros(len(t_us), RECORD)
    records["x"], records["y"], records["p"] = x, y, 1
    records["s"], records["ns"] = t_us // 1_000_000, t_us % 1_000_000 * 1000
    head = header(seq, stamp_s=stamp_s) + struct.pack("<III", height, width, len(t_us))
    return head + records.tobytes()


def packet(payload: bytes, *, encoding: bytes = b"mono", seq: int = 0, big: bool = False) -> bytes:
    """Return an EventPacket of a sensor of 640 x 480 px."""
    return (
        header(seq)
        + struct.pack("<IIQQI", 480, 640, seq, 0, len(encoding))
        + encoding
        + struct.pack("<?I", big, len(payload))
        + payload
    )


def events_in(message: bytes) -> np.ndarray:
    """Return the records of an EventArray."""
    (frame,) = struct.unpack_from("<I", message, 12)
    (count,) = struct.unpack_from("<I", message, 24 + frame)
    return np.frombuffer(message, RECORD, count, 28 + frame)


def messages_of(bag: Path) -> list[tuple[float, bytes]]:
    """Return the times in s and the messages of a bag with one topic, as they are stored."""
    import rosbag

    with rosbag.Bag(str(bag)) as opened:
        stored = opened.read_messages(raw=True)
        return [(time.to_sec(), raw[1]) for _, raw, time in stored]


class AsapNode:
    """The executable, with parameters, until the end of the `with` block."""

    def __init__(self, **parameters: Any) -> None:
        if rosgraph.is_master_online():
            if rospy.has_param("/asap"):
                rospy.delete_param("/asap")
            for name, value in parameters.items():
                rospy.set_param(f"/asap/{name}", value)
        self.process = subprocess.Popen(
            ["rosrun", "asap_ros", "asap_node"],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )

    def __enter__(self) -> AsapNode:
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
        start = time.monotonic()
        self.process.send_signal(signal.SIGINT)
        code, said = self.end()
        print(f"SIGINT to exit: {(time.monotonic() - start) * 1e3:.0f} ms")
        return code, said


def ledger_in(said: str) -> dict[str, int]:
    """Return the ledger that the node has logged last."""
    line = re.findall(r"run ended: (received .*)", said)[-1]
    assert "does not add up" not in line
    return {name: int(count) for name, count in re.findall(r"([a-z]+) (\d+)", line)}


class Peer:
    """Driver and consumer."""

    def __init__(self, *, driver: type = Array, consumer: type | None = Array) -> None:
        self.stats: list[dict[str, Any]] = []
        self.packages: list[bytes] = []
        self.on_package: Callable[[bytes], None] = lambda message: None
        self.driver = rospy.Publisher("/events", driver, queue_size=WORDS)
        self._ends = [rospy.Subscriber("/asap/stats", String, self._note)]
        if consumer is not None:
            self._ends.append(rospy.Subscriber("/asap/events", consumer, self._take))

    def close(self) -> None:
        for end in (self.driver, *self._ends):
            end.unregister()

    def _take(self, message: Any) -> None:
        self.packages.append(message.data)
        self.on_package(message.data)

    def _note(self, stats: String) -> None:
        self.stats.append(json.loads(stats.data))

    @property
    def events(self) -> np.ndarray:
        """The events of the arrays that have come."""
        return np.concatenate([np.zeros(0, RECORD), *map(events_in, list(self.packages))])

    def wait_for_node(self) -> None:
        wait(lambda: self.driver.get_num_connections() > 0, "the node subscribes")
        for end in self._ends:
            wait(lambda end=end: end.get_num_connections() > 0, "the node publishes")
        self.next_stats()

    def send(self, message: bytes) -> None:
        self.driver.publish(type_of(self.driver)(message))

    def play(self, messages: list[tuple[float, bytes]]) -> None:
        """Publish stored messages in their own pace."""
        start = time.monotonic()
        for stamp, message in messages:
            time.sleep(max(0.0, start + stamp - messages[0][0] - time.monotonic()))
            self.send(message)

    def next_stats(self) -> dict[str, Any]:
        """Return a report that was made from now on."""
        seen = len(self.stats) + 1
        wait(lambda: len(self.stats) > seen, "two reports")
        return self.stats[-1]

    def settled(self) -> dict[str, Any]:
        """Return the report once nothing waits any more."""
        wait(lambda: self.next_stats()["ledger"]["pending"] == 0, "nothing pending")
        return self.stats[-1]


def type_of(publisher: rospy.Publisher) -> type:
    return publisher.data_class


def peers() -> Iterator[Callable[..., Peer]]:
    """A maker of peers that end with the test."""
    made: list[Peer] = []

    def make(**options: Any) -> Peer:
        made.append(Peer(**options))
        return made[-1]

    yield make
    for peer in made:
        peer.close()
