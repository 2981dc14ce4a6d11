"""Small ROS bags, written by the writers of ``rosbags``, and the events of packets as bytes."""

from __future__ import annotations

import shutil
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from asap.events import Events

DEFINITIONS = {
    "event_camera_msgs/msg/EventPacket": (
        "std_msgs/Header header\nuint32 height\nuint32 width\nuint64 seq\nuint64 time_base\n"
        "string encoding\nbool is_bigendian\nuint8[] events\n"
    ),
    "dvs_msgs/msg/Event": "uint16 x\nuint16 y\nbuiltin_interfaces/Time ts\nbool polarity\n",
    "dvs_msgs/msg/EventArray": (
        "std_msgs/Header header\nuint32 height\nuint32 width\ndvs_msgs/Event[] events\n"
    ),
}
DEFINITIONS["event_array_msgs/msg/EventArray"] = DEFINITIONS["event_camera_msgs/msg/EventPacket"]
SUFFIXES = {"rosbag1": "bag", "rosbag2": "db3", "mcap": "mcap"}
COMPRESSIONS = {"rosbag1": ("bz2", "lz4"), "rosbag2": (), "mcap": ("zstd",)}
WIDTH, HEIGHT = 346, 260


class Types:
    """The messages of events in one of the two ROS, as `rosbags` writes them."""

    def __init__(self, format: str) -> None:
        typesys = pytest.importorskip("rosbags.typesys")
        self.format = format
        self.is_ros1 = format == "rosbag1"
        store = typesys.Stores.ROS1_NOETIC if self.is_ros1 else typesys.Stores.ROS2_HUMBLE
        self.store = typesys.get_typestore(store)
        for name, text in DEFINITIONS.items():
            self.store.register(typesys.get_types_from_msg(text, name))

    def header(self, frame: str = "camera") -> Any:
        types = self.store.types
        stamp = types["builtin_interfaces/msg/Time"](sec=1, nanosec=2)
        sequence = {"seq": 7} if self.is_ros1 else {}
        return types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame, **sequence)

    def packet(
        self,
        payload: bytes,
        encoding: str,
        *,
        time_base: int = 0,
        frame: str = "camera",
        name: str = "event_camera_msgs/msg/EventPacket",
        is_bigendian: bool = False,
    ) -> tuple[str, bytes]:
        """Name of the type, and the bytes of a message."""
        message = self.store.types[name](
            header=self.header(frame), height=HEIGHT, width=WIDTH, seq=5, time_base=time_base,
            encoding=encoding, is_bigendian=is_bigendian, events=np.frombuffer(payload, np.uint8),
        )  # fmt: skip
        return name, self.raw(message, name)

    def array(self, events: Events, *, frame: str = "camera") -> tuple[str, bytes]:
        """The same of an array of dvs_msgs."""
        time = self.store.types["builtin_interfaces/msg/Time"]
        event = self.store.types["dvs_msgs/msg/Event"]
        rows = [
            event(x=x, y=y, polarity=p > 0, ts=time(sec=t // 10**6, nanosec=t % 10**6 * 1000 + 999))
            for x, y, p, t in events.tolist()
        ]
        name = "dvs_msgs/msg/EventArray"
        message = self.store.types[name](
            header=self.header(frame), height=HEIGHT, width=WIDTH, events=rows
        )
        return name, self.raw(message, name)

    def other(self) -> tuple[str, bytes]:
        """A message without events."""
        return "std_msgs/msg/Header", self.raw(self.header(), "std_msgs/msg/Header")

    def raw(self, message: Any, name: str) -> bytes:
        serialize = self.store.serialize_ros1 if self.is_ros1 else self.store.serialize_cdr
        return bytes(serialize(message, name))


Messages = Iterable[tuple[str, tuple[str, bytes]]]  # topic, and type and bytes


def write_bag(path: Path, types: Types, messages: Messages, *, compression: str = "") -> Path:
    """A bag as one file of the format that `types` has."""
    if types.is_ros1:
        rosbag1 = pytest.importorskip("rosbags.rosbag1")
        path.unlink(missing_ok=True)
        writer = rosbag1.Writer(path)
        if compression:
            writer.set_compression(rosbag1.Writer.CompressionFormat[compression.upper()])
        _write(writer, types, messages)
    else:
        folder = path.parent / "folder of a bag"
        write_folder(folder, types, messages, SUFFIXES[types.format], compression=compression)
        next(folder.glob(f"*.{SUFFIXES[types.format]}")).replace(path)
        shutil.rmtree(folder)
    return path


def write_folder(
    folder: Path,
    types: Types,
    messages: Messages,
    storage: str,
    *,
    compression: str = "",
    mode: str = "storage",
) -> None:
    """A bag of ROS 2 as a folder with its metadata."""
    rosbag2 = pytest.importorskip("rosbags.rosbag2")
    plugin = rosbag2.StoragePlugin.MCAP if storage == "mcap" else rosbag2.StoragePlugin.SQLITE3
    writer = rosbag2.Writer(folder, version=9, storage_plugin=plugin)
    if compression:
        way = rosbag2.CompressionMode[mode.upper()]
        writer.set_compression(way, rosbag2.CompressionFormat[compression.upper()])
    _write(writer, types, messages)


def _write(writer: Any, types: Types, messages: Messages) -> None:
    with writer:
        connections: dict[str, Any] = {}
        for number, (topic, (name, raw)) in enumerate(messages):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, name, typestore=types.store)
            writer.write(connections[topic], 1_000_000_000 + number, raw)


# ---- events as the bytes of a packet ------------------------------------------------------------


def mono(events: Events, base_us: int) -> bytes:
    ns = (events["t"] - base_us).astype("<u8") * 1000
    x, y, p = (events[name].astype("<u8") for name in "xyp")
    return (ns | x << 32 | y << 48 | p << 63).astype("<u8").tobytes()


def libcaer(events: Events, base_us: int) -> bytes:
    words = np.empty((len(events), 2), "<u4")
    x, y, p = (events[name].astype("<u4") for name in "xyp")
    words[:, 0] = 1 | p << 1 | y << 2 | x << 17
    words[:, 1] = events["t"] - base_us
    return words.tobytes()


def _words(events: Events, base_us: int, first_type: int, last_type: int) -> np.ndarray:
    """TIME_HIGH, TIME_LOW and the two addresses of each event, the types of which differ."""
    t = events["t"] - base_us
    words = np.empty((len(events), 4), "<u2")
    words[:, 0] = t >> 12 & 0xFFF
    words[:, 1] = t & 0xFFF
    words[:, 2], words[:, 3] = first_type << 12, last_type << 12 | events["p"] << 11
    return words


def libcaer_cmp(events: Events, base_us: int) -> bytes:
    words = _words(events, base_us, 2, 3)
    words[:, 1] |= 1 << 12
    words[:, 2] |= events["x"]
    words[:, 3] |= events["y"]
    return words.tobytes()


def evt3(events: Events, base_us: int = 0) -> bytes:
    words = _words(events, base_us, 0, 2)
    words[:, 0] |= 8 << 12
    words[:, 1] |= 6 << 12
    words[:, 2] |= events["y"]
    words[:, 3] |= events["x"]
    return words.tobytes()


ENCODERS = {"mono": mono, "libcaer": libcaer, "libcaer_cmp": libcaer_cmp, "evt3": evt3}
