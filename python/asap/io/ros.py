"""ROS bags: ROS 1 ``.bag``, ROS 2 ``.db3``, ``.mcap`` and folders, through ``rosbags``.

The library hands out raw messages; the fields before the events are read here and the events
decoded by the native core, never one by one. One decoder serves a topic from its first message to
its last, because EVT3 words run on across messages. No definition of a message is needed.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from asap import _core
from asap.events import EVENT_DTYPE, Events
from asap.io.bags import open_bag
from asap.io.errors import CorruptFile, UnsupportedFormat
from asap.io.reader import CHUNK, Losses, Options, choose_stream

_DECODERS = {
    "evt3": "Evt3Decoder",
    "libcaer": "LibcaerDecoder",
    "libcaer_cmp": "LibcaerCmpDecoder",
    "mono": "MonoDecoder",
}
_MOST_PX = 0xFFFF


class RosReader:
    """The events of one topic of a bag of `kind`: ``"rosbag1"``, ``"rosbag2"`` or ``"mcap"``."""

    def __init__(self, kind: str, path: Path, options: Options) -> None:
        options.refuse_stated(path, kind)
        self.format = kind
        self._path = path
        self._bag = open_bag(kind, path)
        self._cdr = kind != "rosbag1"
        self.streams = self._topics_of_events()
        types = self._bag.topics
        words = [f"{topic} ({types[topic]})" for topic in self.streams]
        self._topic = choose_stream(path, options.stream, self.streams, words)
        self._read = read_packet if types[self._topic] in PACKETS else read_array
        self._first = first = self._first_message()
        self.width = first.width if first and 0 < first.width <= _MOST_PX else None
        self.height = first.height if first and 0 < first.height <= _MOST_PX else None
        if first and self._read is read_packet and first.encoding not in _DECODERS:
            raise UnsupportedFormat(
                f"{path}: {self._topic} is encoded in {first.encoding!r}; what is read: "
                f"{', '.join(_DECODERS)}"
            )

    def chunks(self, losses: Losses) -> Iterator[Events]:
        """Decode message by message; an array goes out when it is full."""
        decoder = self._decoder()
        out, filled, bad_messages = np.empty(CHUNK, EVENT_DTYPE), 0, 0
        for number, raw in enumerate(self._messages(losses)):
            fault = "some of its records hold no event"
            try:
                message = self._read(raw, self._cdr)
                decoder.begin(message)
                while True:
                    filled += decoder.decode_into(out[filled:])
                    if decoder.is_done:
                        break
                    yield out[:filled]
                    out, filled = np.empty(CHUNK, EVENT_DTYPE), 0
                message.check_whole()
            except BadMessage as error:
                bad_messages, fault = bad_messages + 1, str(error)
            losses.bad_record = bad_messages + decoder.count(losses)
            if losses.bad_record and losses.on_bad == "raise":
                raise CorruptFile(self._path, 0, f"message {number} of {self._topic}: {fault}")
        losses.bad_record += decoder.is_inside_a_record
        yield out[:filled]

    def _topics_of_events(self) -> tuple[str, ...]:
        types = self._bag.topics
        topics = tuple(sorted(topic for topic in types if types[topic] in PACKETS + ARRAYS))
        if not topics:
            found = ", ".join(f"{topic} ({kind})" for topic, kind in sorted(types.items()))
            raise UnsupportedFormat(
                f"{self._path}: no topic holds events; topics: {found or 'none'}; types that are "
                f"read: {', '.join(PACKETS + ARRAYS)}"
            )
        return topics

    def _messages(self, losses: Losses) -> Iterator[bytes]:
        try:
            yield from self._bag.messages(self._topic)
        except CorruptFile as error:
            losses.truncated(error.offset, error.fault)

    def _first_message(self) -> Message | None:
        with suppress(CorruptFile):  # it is told when all are read
            for raw in self._bag.messages(self._topic):
                with suppress(BadMessage):
                    return self._read(raw, self._cdr)
        return None

    def _decoder(self) -> _PacketDecoder | _ArrayDecoder:
        if self._read is read_array:
            return _ArrayDecoder(self._cdr)
        return _PacketDecoder(self._first.encoding if self._first else "mono")  # decodes none


class _PacketDecoder:
    """Events of packets in one encoding."""

    def __init__(self, encoding: str) -> None:
        self._encoding = encoding
        self._decoder: Any = getattr(_core, _DECODERS[encoding])()
        self._rest = memoryview(b"")

    def begin(self, message: Message) -> None:
        """Go on with the events of another message."""
        if message.encoding != self._encoding:
            raise BadMessage(f"its encoding is {message.encoding!r}, not {self._encoding!r}")
        if self._encoding != "evt3":  # whose words state their own time, and run on
            self._decoder.begin(message.time_base)
        self._rest = message.payload

    def decode_into(self, out: Events) -> int:
        """Return how many events there was room for."""
        used, written = self._decoder.decode_into(self._rest, out)
        self._rest = self._rest[used:]
        return int(written)

    @property
    def is_done(self) -> bool:
        """No event of the message is left."""
        return not self._rest

    def count(self, losses: Losses) -> int:
        """Return how many records were none."""
        losses.take_triggers(self._decoder)
        return int(self._decoder.bad_records)

    @property
    def is_inside_a_record(self) -> bool:
        """The last message ends with a part of a record."""
        return bool(self._decoder.unfinished)


class _ArrayDecoder:
    """Events of arrays, field by field."""

    is_done = True
    is_inside_a_record = False

    def __init__(self, cdr: bool) -> None:
        self._cdr = cdr
        self._payload = memoryview(b"")
        self._events = 0  # that are decoded

    def begin(self, message: Message) -> None:
        self._payload, self._events, self.is_done = message.payload, 0, False

    def decode_into(self, out: Events) -> int:
        written = _core.decode_dvs_into(self._payload, cdr=self._cdr, first=self._events, out=out)
        self._events += written
        self.is_done = written < len(out)
        return written

    def count(self, losses: Losses) -> int:
        return 0


# ---- messages: where the bytes of the events are. CDR aligns each field to its size, counted from
# the end of the four bytes that come first.

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
