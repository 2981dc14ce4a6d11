"""Messages of events on the ROS 1 wire and in CDR (ROS 2): where the bytes of the events are.

CDR aligns each field to its size, counted from the end of the four bytes that come first.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

PACKETS = ("event_camera_msgs/EventPacket", "event_array_msgs/EventArray")
ARRAYS = ("dvs_msgs/EventArray", "prophesee_event_msgs/EventArray")

_FRAME_AT = 12  # the name of the frame, after four bytes, s and ns
_CDR_LITTLE = b"\x00\x01"


class BadMessage(Exception):
    """A message that holds no events; says why."""


@dataclass(frozen=True)
class Message:
    """Sensor and events of one message."""

    width: int
    height: int
    payload: memoryview  # of the events, as much as is there
    promised: int  # bytes of the events
    encoding: str = ""  # of a packet
    time_base: int = 0  # ns

    def check_whole(self) -> None:
        """Raise `BadMessage` if events are missing at its end."""
        if len(self.payload) < self.promised:
            raise BadMessage(f"{len(self.payload)} of {self.promised} bytes of events are there")


def read_packet(raw: bytes, cdr: bool) -> Message:
    """Read an ``EventPacket``: events in an encoding of their own."""
    try:
        at = _after_frame(raw, cdr)
        height, width = struct.unpack_from("<II", raw, at)
        at = _aligned(at + 8, 8, cdr)
        _, time_base, length = struct.unpack_from("<QQI", raw, at)
        encoding = raw[at + 20 : at + 20 + length].rstrip(b"\0").decode()
        at += 20 + length
        is_bigendian = raw[at]
        at = _aligned(at + 1, 4, cdr)
        (promised,) = struct.unpack_from("<I", raw, at)
    except (struct.error, IndexError, UnicodeDecodeError) as error:
        raise BadMessage("its header is cut or damaged") from error
    if is_bigendian:
        raise BadMessage("its events are big-endian")
    at += 4
    payload = memoryview(raw)[at : at + promised]
    return Message(width, height, payload, promised, encoding, time_base)


def read_array(raw: bytes, cdr: bool) -> Message:
    """Read an ``EventArray`` of dvs_msgs: events field by field."""
    try:
        at = _after_frame(raw, cdr)
        height, width, events = struct.unpack_from("<III", raw, at)
    except struct.error as error:
        raise BadMessage("its header is cut or damaged") from error
    at += 12
    promised = max(16 * events - 3, 0) if cdr else 13 * events  # only the first one has no padding
    return Message(width, height, memoryview(raw)[at : at + promised], promised)


def _after_frame(raw: bytes, cdr: bool) -> int:
    """Where the fields after the header begin."""
    if cdr and raw[:2] != _CDR_LITTLE:
        raise BadMessage(f"it is not in little-endian CDR but in 0x{raw[:2].hex()}")
    (length,) = struct.unpack_from("<I", raw, _FRAME_AT)
    return _aligned(_FRAME_AT + 4 + length, 4, cdr)


def _aligned(at: int, size: int, cdr: bool) -> int:
    return at + (4 - at) % size if cdr else at
