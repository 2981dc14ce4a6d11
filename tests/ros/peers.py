"""What stands around the node in the tests: its process, a driver, a consumer, packets as bytes."""

from __future__ import annotations

import json
import os
import re
import signal
import socket
import sqlite3
import subprocess
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from event_camera_msgs.msg import EventPacket
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import String


def own_domain() -> socket.socket:
    """Set the first domain that no other run has; it is ours as long as the socket is open.

    Two runs in one domain would hear each other's nodes, which have the same names.
    """
    claim = socket.socket(socket.AF_UNIX)
    for domain in range(1, 102):  # above, ports are those of outgoing connections
        try:
            claim.bind(f"\0asap_ros2_domain_{domain}")
        except OSError:
            continue
        os.environ["ROS_DOMAIN_ID"] = str(domain)
        return claim
    raise RuntimeError("all domains are taken")


DOMAIN = own_domain()
PREFIXES = [Path(prefix) for prefix in os.environ["AMENT_PREFIX_PATH"].split(":")]
DATA = Path(os.environ.get("ASAP_TEST_DATA", "none"))
QOS = QoSProfile(depth=10_000, reliability=ReliabilityPolicy.RELIABLE)
# As metavision_driver and libcaer_driver publish: neither is heard by a reliable subscriber.
DRIVERS_QOS = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
PRELOAD = {**os.environ, "LD_PRELOAD": os.environ.get("ROS2_PRELOAD", "")}


def program(package: str, name: str) -> str:
    """Return the path of a package's executable."""
    paths = [prefix / "lib" / package / name for prefix in PREFIXES]
    return str(next(path for path in paths if path.exists()))


class CppPeer:
    """A role of peers/peer.cpp, until the end of the `with` block."""

    def __init__(self, *words: Any, remap: str = "") -> None:
        command = [program("asap_ros", "peer"), *map(str, words)]
        command += ["--ros-args", "-r", remap] if remap else []
        self.process = subprocess.Popen(command, env=PRELOAD, stdout=subprocess.PIPE, text=True)

    def __enter__(self) -> CppPeer:
        return self

    def __exit__(self, *error: object) -> None:
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate()

    def result(self, seconds: float = 120.0) -> Any:
        """Wait for its end; return what it has to say."""
        said, _ = self.process.communicate(timeout=seconds)
        assert self.process.returncode == 0
        return json.loads(said)


def messages_of(bag: str) -> list[tuple[int, bytes]]:
    """Return the times in ns and the messages of a bag with one topic, as they are stored."""
    with sqlite3.connect(f"file:{DATA / 'ros' / bag}?immutable=1", uri=True) as database:
        return database.execute("select timestamp, data from messages order by id").fetchall()


def mono(t_us: np.ndarray, x: np.ndarray | int = 1, y: np.ndarray | int = 1) -> bytes:
    """Return ON events as the bytes of a packet; times count from its time_base."""
    words = np.asarray(t_us, np.uint64) * np.uint64(1000)
    words = words | (np.asarray(x, np.uint64) << np.uint64(32))
    words = words | (np.asarray(y, np.uint64) << np.uint64(48)) | np.uint64(1 << 63)
    return words.astype("<u8").tobytes()


class AsapNode:
    """The executable, with parameters or words of a command, until the end of the `with` block."""

    def __init__(self, *, remap: str = "", words: Sequence[str] = (), **parameters: Any) -> None:
        command = [program("asap_ros", "asap_node"), *(words or ["--ros-args"])]
        for name, value in parameters.items():
            command += ["-p", f"{name}:={json.dumps(value)}"]
        command += ["-r", remap] if remap else []
        self.process = subprocess.Popen(
            command, env=PRELOAD, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )

    def __enter__(self) -> AsapNode:
        return self

    def __exit__(self, *error: object) -> None:
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate()

    def interrupt(self) -> tuple[int, str, float]:
        """Send SIGINT; return exit code, what the node said and the time to the end in s."""
        start = time.monotonic()
        self.process.send_signal(signal.SIGINT)
        said, _ = self.process.communicate(timeout=60)
        return self.process.returncode, said, time.monotonic() - start


def ledger_in(said: str) -> dict[str, int]:
    """Return the ledger that the node has logged last."""
    line = re.findall(r"run ended: (received .*)", said)[-1]
    assert "does not add up" not in line
    return {name: int(count) for name, count in re.findall(r"([a-z]+) (\d+)", line)}


class Peer(Node):
    """Driver and consumer; its callbacks run on a thread of its own."""

    def __init__(
        self, *, consume: bool = True, name: str = "peer", qos: QoSProfile = DRIVERS_QOS
    ) -> None:
        super().__init__(name)
        self.seq = 0
        self.packets: list[EventPacket] = []
        self.on_packet: Callable[[EventPacket], None] = lambda packet: None
        self.stats: list[dict[str, Any]] = []
        self.driver = self.create_publisher(EventPacket, "events", qos)
        if consume:
            self.create_subscription(EventPacket, "asap/events", self._take, QOS)
        self.create_subscription(String, "asap/stats", self._note, 10)
        self.parameters = self.create_client(
            SetParametersAtomically, "asap/set_parameters_atomically"
        )
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self)
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._spin, daemon=True)
        self._thread.start()

    def close(self) -> None:
        if not self._thread.is_alive():
            return
        self._closed.set()
        self._thread.join()  # before the executor ends: it does not wait for the thread
        self._executor.shutdown()
        self.destroy_node()

    def _spin(self) -> None:
        while not self._closed.is_set():
            self._executor.spin_once(timeout_sec=0.1)

    def _take(self, packet: EventPacket) -> None:
        self.packets.append(packet)
        self.on_packet(packet)

    def _note(self, stats: String) -> None:
        self.stats.append(json.loads(stats.data))

    @property
    def events(self) -> np.ndarray:
        """The words of the mono packets that have come."""
        return np.frombuffer(b"".join(bytes(p.events) for p in list(self.packets)), "<u8")

    def send(
        self,
        payload: bytes,
        *,
        encoding: str = "mono",
        width: int = 640,
        height: int = 480,
        **fields: Any,
    ) -> int:
        """Publish a packet; return its stamp, ns."""
        packet = EventPacket(encoding=encoding, width=width, height=height, seq=self.seq, **fields)
        now = self.get_clock().now()
        packet.header.stamp = now.to_msg()
        packet.header.frame_id = "camera"
        packet.events.frombytes(payload)
        self.seq += 1
        self.driver.publish(packet)
        return now.nanoseconds

    def play(self, messages: list[tuple[int, bytes]]) -> None:
        """Publish stored messages in their own pace."""
        start = time.monotonic()
        for stamp, message in messages:
            time.sleep(max(0.0, start + (stamp - messages[0][0]) * 1e-9 - time.monotonic()))
            self.driver.publish(message)

    def wait(self, condition: Callable[[], Any], what: str, seconds: float = 60.0) -> Any:
        end = time.monotonic() + seconds
        while not (met := condition()):
            assert time.monotonic() < end, f"not within {seconds} s: {what}"
            time.sleep(0.01)
        return met

    def wait_for_node(self, *, consumers: bool = True) -> None:
        self.wait(lambda: self.driver.get_subscription_count() > 0, "the node subscribes")
        self.wait(lambda: self.count_publishers("asap/stats") > 0, "the node reports")
        if consumers:
            self.wait(lambda: self.count_publishers("asap/events") > 0, "the node publishes")
        self.next_stats()

    def next_stats(self) -> dict[str, Any]:
        """Return a report that was made from now on."""
        seen = len(self.stats) + 1
        self.wait(lambda: len(self.stats) > seen, "two reports")
        return self.stats[-1]

    def ask(self, client: Any, request: Any) -> Any:
        assert client.wait_for_service(30.0)
        future = client.call_async(request)
        self.wait(future.done, "an answer")
        return future.result()

    def set(self, **values: Any) -> Any:
        parameters = [Parameter(name, value=value) for name, value in values.items()]
        request = SetParametersAtomically.Request()
        request.parameters = [parameter.to_parameter_msg() for parameter in parameters]
        return self.ask(self.parameters, request).result


def peers() -> Iterator[Callable[..., Peer]]:
    """A maker of peers that end with the test."""
    made: list[Peer] = []

    def make(**options: Any) -> Peer:
        made.append(Peer(**options))
        return made[-1]

    rclpy.init()
    yield make
    for peer in made:
        peer.close()
    rclpy.shutdown()
