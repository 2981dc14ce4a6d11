"""The door to ROS 2: its node, driver, consumer and operator over DDS on loopback."""

from __future__ import annotations

import json
import os
import socket
import sqlite3
import subprocess
import threading
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import rclpy
from asap_ros.msg import ProcessingTime
from asap_ros.srv import Feedback
from diagnostic_msgs.msg import DiagnosticArray
from door import DATA, Ends, Packet, Program, status_of, wait
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
QOS = QoSProfile(depth=10_000, reliability=ReliabilityPolicy.RELIABLE)
# As metavision_driver and libcaer_driver publish: neither is heard by a reliable subscriber.
DRIVERS_QOS = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
PRELOAD = {**os.environ, "LD_PRELOAD": os.environ.get("ROS2_PRELOAD", "")}

# Events and sensors of the bags, as every reader of bags finds them.
BAGS = {
    "room_person_evt3.db3": (343_474, 640, 480),
    "noise_hd_evt3.db3": (82_469, 1280, 720),
    "mono_100.db3": (100, 640, 480),
}


def program(package: str, name: str) -> str:
    """Return the path of a package's executable."""
    paths = [prefix / "lib" / package / name for prefix in PREFIXES]
    return str(next(path for path in paths if path.exists()))


class CppPeer(Program):
    """A role of peers/peer.cpp, until the end of the `with` block."""

    def __init__(self, *words: Any, remap: str = "") -> None:
        command = [program("asap_ros", "peer"), *map(str, words)]
        command += ["--ros-args", "-r", remap] if remap else []
        self.process = subprocess.Popen(command, env=PRELOAD, stdout=subprocess.PIPE, text=True)

    def result(self, seconds: float = 120.0) -> Any:
        """Wait for its end; return what it has to say."""
        said, _ = self.process.communicate(timeout=seconds)
        assert self.process.returncode == 0
        return json.loads(said)


def messages_of(bag: str) -> list[tuple[int, bytes]]:
    """Return the times in ns and the messages of a bag with one topic, as they are stored."""
    with sqlite3.connect(f"file:{DATA / 'ros' / bag}?immutable=1", uri=True) as database:
        return database.execute("select timestamp, data from messages order by id").fetchall()


class AsapNode(Program):
    """The executable, with parameters or words of a command, until the end of the `with` block."""

    def __init__(self, *, remap: str = "", words: Sequence[str] = (), **parameters: Any) -> None:
        command = [program("asap_ros", "asap_node"), *(words or ["--ros-args"])]
        for name, value in parameters.items():
            command += ["-p", f"{name}:={json.dumps(value)}"]
        command += ["-r", remap] if remap else []
        super().__init__(command, PRELOAD)


class Peer(Ends, Node):
    """Driver, consumer and operator; its callbacks run on a thread of its own."""

    def __init__(
        self, *, consume: bool = True, name: str = "peer", qos: QoSProfile = DRIVERS_QOS
    ) -> None:
        Node.__init__(self, name)
        Ends.__init__(self)
        self.driver = self.create_publisher(EventPacket, "events", qos)
        if consume:
            self.create_subscription(EventPacket, "asap/events", self._take, QOS)
        self.create_subscription(String, "asap/stats", self.note, 10)
        self.create_subscription(
            DiagnosticArray, "/diagnostics", lambda array: self.said.append(status_of(array)), 10
        )
        self.parameters = self.create_client(
            SetParametersAtomically, "asap/set_parameters_atomically"
        )
        self._feedback = self.create_client(Feedback, "asap/feedback", qos_profile=QOS)
        self._times: Any = None
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
        stamp_ns = packet.header.stamp.sec * 10**9 + packet.header.stamp.nanosec
        sensor = packet.width, packet.height
        rest = packet.encoding, packet.time_base, bytes(packet.events)
        self.take(Packet(packet.seq, stamp_ns, *sensor, *rest))

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

    def send_raw(self, message: bytes) -> None:
        self.driver.publish(message)

    def answer(self) -> None:
        """Be one that gives feedback on the topic; the node knows it."""
        self._times = self.create_publisher(ProcessingTime, "asap/processing_time", 10)

    def wait_for_node(self, *, consumers: bool = True) -> None:
        wait(lambda: self.driver.get_subscription_count() > 0, "the node subscribes")
        wait(lambda: self.count_publishers("asap/stats") > 0, "the node reports")
        if consumers:
            wait(lambda: self.count_publishers("asap/events") > 0, "the node publishes")
        if self._times:
            wait(lambda: self._times.get_subscription_count() > 0, "the node listens")
        self.next_stats()

    def finish(self, seq: int, seconds: float) -> None:
        """Give feedback on the topic."""
        self._times.publish(ProcessingTime(seq=seq, time=seconds))

    def call(self, seq: int, seconds: float) -> bool:
        """Give feedback by the service."""
        return self.ask(self._feedback, Feedback.Request(seq=seq, time=seconds)).success

    def calls(self, count: int) -> list[bool]:
        """Call the service without a package in flight, many times at once."""
        assert self._feedback.wait_for_service(30.0)
        answers: list[bool] = []
        for i in range(count):
            future = self._feedback.call_async(Feedback.Request(time=1e-3))
            future.add_done_callback(lambda future: answers.append(future.result().success))
            wait(lambda i=i: i - len(answers) <= 100, "answers")
        wait(lambda: len(answers) == count, "all answers")
        return answers

    def ask(self, client: Any, request: Any) -> Any:
        assert client.wait_for_service(30.0)
        future = client.call_async(request)
        wait(future.done, "an answer")
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


def master() -> Iterator[None]:
    """Nothing: ROS 2 has none."""
    yield
