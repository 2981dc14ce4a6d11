"""Writers of files that hold events in packets, as a driver sends them: AEDAT 4 and MCAP.

The packets end where a period of the events' time ends. Sources: FileSourceFormat of dv-processing,
with packets in lz4 and without the table at the end, which is optional; mcap.dev/spec, without
chunks and index, with messages of event_camera_msgs whose events are one stream in EVT3.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator
from typing import IO

import numpy as np

from asap._checks import named
from asap.events import Events
from asap.io.aedat4 import EVENT, MAGIC, MOST_PIXELS
from asap.io.encoded import Encoded
from asap.io.errors import library

_AEDAT4_PERIOD_US = 10_000  # of the cameras of iniVation
_ROS_PERIOD_US = 1_000  # of the drivers for ROS


def _packets(chunks: Iterable[Events], period_us: int) -> Iterator[Events]:
    for chunk in chunks:
        yield from np.split(chunk, np.flatnonzero(np.diff(chunk["t"] // period_us)) + 1)


# ---- AEDAT 4 ------------------------------------------------------------------------------------

_LZ4 = 1
_OUT_INFO = """<dv version="2.0"><node name="outInfo" path="/mainloop/Recorder/outInfo/">\
<node name="0" path="/mainloop/Recorder/outInfo/0/">\
<attr key="compression" type="string">LZ4</attr>\
<attr key="originalModuleName" type="string">asap</attr>\
<attr key="originalOutputName" type="string">events</attr>\
<attr key="typeDescription" type="string">Array of events (polarity ON/OFF).</attr>\
<attr key="typeIdentifier" type="string">EVTS</attr>\
<node name="info" path="/mainloop/Recorder/outInfo/0/info/">\
<attr key="sizeX" type="int">{width}</attr><attr key="sizeY" type="int">{height}</attr>\
<attr key="source" type="string">asap</attr></node></node></node></dv>"""


def write_aedat4(file: IO[bytes], chunks: Iterable[Events], width: int, height: int) -> int:
    """Write one stream of events."""
    for name, side in (("width", width), ("height", height)):
        if not 0 < side <= MOST_PIXELS:
            remedy = f"AEDAT 4 states its sensor: give its size, 1 to {MOST_PIXELS} px"
            raise ValueError(named(name, side, remedy))
    lz4 = library("lz4.frame", "AEDAT4", "aedat4")
    text = _OUT_INFO.format(width=width, height=height).encode()
    # A flatbuffer: table's place and name; sizes and places of the fields; the table; the text.
    fields = struct.pack("<I4s5H2x", 20, b"IOHE", 10, 12, 4, 0, 8)
    header = fields + struct.pack("<iiII", 12, _LZ4, 4, len(text)) + text + b"\0"
    file.write(MAGIC + struct.pack("<I", len(header)) + header)
    count = 0
    for events in _packets(chunks, _AEDAT4_PERIOD_US):
        rows = np.zeros(len(events), EVENT)
        for role in "txy":
            rows[role] = events[role]
        rows["p"] = events["p"] > 0
        fields = struct.pack("<I4s3H2x", 16, b"EVTS", 6, 8, 4)
        size = len(fields) + 12 + rows.nbytes
        packet = struct.pack("<I", size) + fields + struct.pack("<iII", 8, 4, len(rows))
        content = lz4.compress(packet + rows.tobytes())
        file.write(struct.pack("<ii", 0, len(content)) + content)
        count += len(events)
    return count


# ---- MCAP ---------------------------------------------------------------------------------------

_MAGIC = b"\x89MCAP0\r\n"
_HEADER, _FOOTER, _SCHEMA, _CHANNEL, _MESSAGE, _DATA_END = 1, 2, 3, 4, 5, 15
_PACKET = "event_camera_msgs/msg/EventPacket"
_DEFINITION = f"""std_msgs/Header header
uint32 height
uint32 width
uint64 seq
uint64 time_base
string encoding
bool is_bigendian
uint8[] events
{"=" * 80}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{"=" * 80}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
_CDR = struct.Struct("<4siII4xIIQQI5s?2xI")  # up to the events; frame_id is empty


def write_mcap(file: IO[bytes], chunks: Iterable[Events], width: int, height: int) -> int:
    """Write one topic, ``/events``, of ``EventPacket``; a message is stamped by its last event."""
    number, schema = 0, 1
    encoded = Encoded("evt3", width, height)
    file.write(_MAGIC)
    _write_record(file, _HEADER, _text("ros2"), _text("asap"))
    names = _text(_PACKET), _text("ros2msg"), _text(_DEFINITION)
    _write_record(file, _SCHEMA, struct.pack("<H", schema), *names)
    names = _text("/events"), _text("cdr"), _text("")
    _write_record(file, _CHANNEL, struct.pack("<HH", number, schema), *names)
    count = 0
    for sequence, events in enumerate(_packets(chunks, _ROS_PERIOD_US)):
        words = b"".join(map(bytes, encoded.pieces(events)))
        first_s, first_us = divmod(int(events["t"][0]), 1_000_000)
        last_ns = int(events["t"][-1]) * 1000
        front = struct.pack("<HIQQ", number, sequence & 0xFFFFFFFF, last_ns, last_ns)
        packet = _CDR.pack(
            b"\0\1\0\0", first_s, first_us * 1000, 1, height, width, sequence, 0,
            len(b"evt3\0"), b"evt3\0", False, len(words),
        )  # fmt: skip
        _write_record(file, _MESSAGE, front, packet, words)
        count += len(events)
    _write_record(file, _DATA_END, bytes(4))
    _write_record(file, _FOOTER, bytes(20))
    file.write(_MAGIC)
    return count


def _write_record(file: IO[bytes], kind: int, *content: bytes) -> None:
    file.write(struct.pack("<BQ", kind, sum(map(len, content))))
    file.writelines(content)


def _text(text: str) -> bytes:
    return struct.pack("<I", len(text.encode())) + text.encode()
