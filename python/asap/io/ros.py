"""ROS bags: ROS 1 ``.bag``, ROS 2 ``.db3``, ``.mcap`` and folders, through ``rosbags``.

The library hands out raw messages; the fields before the events are read here and the events
decoded by the native core, never one by one. One decoder serves a topic from its first message to
its last, because EVT3 words run on across messages. No definition of a message is needed.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from asap import _core
from asap.events import EVENT_DTYPE, Events
from asap.io.bags import open_bag
from asap.io.errors import CorruptFile, UnsupportedFormat
from asap.io.reader import CHUNK, Losses, Options, choose_stream
from asap.io.ros_messages import ARRAYS, PACKETS, BadMessage, Message, read_array, read_packet

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
            if isinstance(raw, CorruptFile):
                losses.bad(raw)
                bad_messages += 1
                continue
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

    def _messages(self, losses: Losses) -> Iterator[bytes | CorruptFile]:
        try:
            yield from self._bag.messages(self._topic)
        except CorruptFile as error:
            losses.truncated(error.offset, error.fault)

    def _first_message(self) -> Message | None:
        with suppress(CorruptFile):  # it is told when all are read
            for raw in self._bag.messages(self._topic):
                with suppress(BadMessage):
                    if not isinstance(raw, CorruptFile):
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
