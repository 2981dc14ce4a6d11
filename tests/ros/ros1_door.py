"""The door to ROS 1: a master, the node, driver, consumer and operator over TCPROS on loopback."""

from __future__ import annotations

import os
import signal
import socket
import struct
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from typing import Any

import genpy
import numpy as np
import rosgraph
import rospy
from asap_ros.msg import ProcessingTime
from asap_ros.srv import Feedback
from diagnostic_msgs.msg import DiagnosticArray
from door import DATA, Ends, Program, status_of, wait
from door import Packet as Taken
from std_msgs.msg import String

# Events and sensor of the bag, as every reader of bags finds them.
BAGS = {"room_person_evt3.bag": (343_474, 640, 480)}
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


def seq_of(message: bytes) -> int:
    return struct.unpack_from("<I", message)[0]


def array(
    t_us: Any,
    x: Any = 1,
    y: Any = 1,
    *,
    seq: int = 0,
    width: int = 640,
    height: int = 480,
) -> bytes:
    """Return ON events as an EventArray."""
    t_us = np.asarray(t_us, np.int64)
    records = np.zeros(len(t_us), RECORD)
    records["x"], records["y"], records["p"] = x, y, 1
    records["s"], records["ns"] = t_us // 1_000_000, t_us % 1_000_000 * 1000
    header = struct.pack("<IIII", seq, 1_700_000_000, 5, 6) + b"camera"
    return header + struct.pack("<III", height, width, len(t_us)) + records.tobytes()


def packet(
    payload: bytes,
    *,
    encoding: str = "mono",
    width: int = 640,
    height: int = 480,
    seq: int = 0,
    time_base: int = 0,
    is_bigendian: bool = False,
    stamp_ns: int = 1_700_000_000_000_000_005,
) -> bytes:
    """Return an EventPacket."""
    return (
        struct.pack("<IIII", seq, *divmod(stamp_ns, 10**9), 6)
        + b"camera"
        + struct.pack("<IIQQI", height, width, seq, time_base, len(encoding))
        + encoding.encode()
        + struct.pack("<?I", is_bigendian, len(payload))
        + payload
    )


def taken(message: bytes) -> Taken:
    """Read an EventPacket."""
    _, s, ns, frame = struct.unpack_from("<IIII", message)
    height, width, seq, time_base, name = struct.unpack_from("<IIQQI", message, 16 + frame)
    encoding = message[44 + frame : 44 + frame + name].decode()
    stamp_ns, events = s * 10**9 + ns, message[49 + frame + name :]
    return Taken(seq, stamp_ns, width, height, encoding, time_base, events)


def events_in(message: bytes) -> np.ndarray:
    """Return the records of an EventArray."""
    (frame,) = struct.unpack_from("<I", message, 12)
    (count,) = struct.unpack_from("<I", message, 24 + frame)
    return np.frombuffer(message, RECORD, count, 28 + frame)


def messages_of(bag: str) -> list[tuple[int, bytes]]:
    """Return the times in ns and the messages of a bag with one topic, as they are stored."""
    import rosbag

    with rosbag.Bag(str(DATA / "ros" / bag)) as opened:
        stored = opened.read_messages(raw=True)
        return [(time.to_nsec(), raw[1]) for _, raw, time in stored]


class AsapNode(Program):
    """The executable, with parameters, until the end of the `with` block."""

    def __init__(self, *, use_sim_time: bool = False, **parameters: Any) -> None:
        if parameters or rosgraph.is_master_online():  # an error, not a node without them
            rospy.set_param("/use_sim_time", use_sim_time)
            if rospy.has_param("/asap"):
                rospy.delete_param("/asap")
            for name, value in parameters.items():
                rospy.set_param(f"/asap/{name}", value)
        super().__init__(["rosrun", "asap_ros", "asap_node"])


class Peer(Ends):
    """Driver, consumer and operator."""

    def __init__(
        self, *, driver: type = Packet, consume: bool = True, consumer: type = Packet
    ) -> None:
        super().__init__()
        self.raw: list[bytes] = []  # packages, as they came
        self.on_raw: Callable[[bytes], None] = lambda message: None
        self.driver = rospy.Publisher("/events", driver, queue_size=WORDS)
        self._ends: list[Any] = [rospy.Subscriber("/asap/stats", String, self.note)]
        self._ends.append(rospy.Subscriber("/diagnostics", DiagnosticArray, self._read))
        if consume:
            self._ends.append(rospy.Subscriber("/asap/events", consumer, self._take))
        self._feedback = rospy.ServiceProxy("/asap/feedback", Feedback, persistent=True)

    def close(self) -> None:
        self._feedback.close()
        for end in (self.driver, *self._ends):
            end.unregister()

    def _read(self, array: DiagnosticArray) -> None:
        self.said.append(status_of(array))

    def _take(self, message: Any) -> None:
        self.raw.append(message.data)
        self.on_raw(message.data)
        if isinstance(message, Packet):
            self.take(taken(message.data))

    @property
    def array_events(self) -> np.ndarray:
        """The events of the arrays that have come."""
        return np.concatenate([np.zeros(0, RECORD), *map(events_in, list(self.raw))])

    def answer(self) -> None:
        """Be one that gives feedback on the topic; the node knows it."""
        self._times = rospy.Publisher("/asap/processing_time", ProcessingTime, queue_size=10)
        self._ends.append(self._times)

    def wait_for_node(self) -> None:
        for end in (self.driver, *self._ends):
            wait(lambda end=end: end.get_num_connections() > 0, f"the node at {end.name}")
        self.next_stats()

    def send(self, payload: bytes, **fields: Any) -> int:
        """Publish a packet; return its stamp, ns."""
        stamp_ns = time.time_ns()
        self.send_raw(packet(payload, seq=self.seq, stamp_ns=stamp_ns, **fields))
        self.seq += 1
        return stamp_ns

    def send_raw(self, message: bytes) -> None:
        self.driver.publish(self.driver.data_class(message))

    def finish(self, seq: int, seconds: float) -> None:
        """Give feedback on the topic."""
        self._times.publish(ProcessingTime(seq=seq, time=seconds))

    def call(self, seq: int, seconds: float) -> bool:
        """Give feedback by the service."""
        rospy.wait_for_service("/asap/feedback", 30.0)
        return self._feedback(seq=seq, time=seconds).success

    def calls(self, count: int) -> list[bool]:
        """Call the service without a package in flight, many times."""
        return [self.call(0, 1e-3) for _ in range(count)]


def peers() -> Iterator[Callable[..., Peer]]:
    """A maker of peers that end with the test."""
    made: list[Peer] = []

    def make(**options: Any) -> Peer:
        made.append(Peer(**options))
        return made[-1]

    yield make
    for peer in made:
        peer.close()


def master() -> Iterator[Master]:
    """A master, and this process as a node."""
    made = Master()
    made.start()
    rospy.init_node("test", disable_signals=True)
    yield made
    made.kill()
