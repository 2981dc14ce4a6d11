"""AEDAT4 files: what the flatbuffers of the format hold, written by hand.

The layout is that of iniVation's FileSourceFormat: a version line, the header (``IOHE``), then
packets of a stream number, a length and a buffer (``EVTS``: 16 bytes per event).
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import pytest

from asap.events import Events

Stream = tuple[int, int]  # width, height
_EVENT = np.dtype([("t", "<i8"), ("x", "<i2"), ("y", "<i2"), ("on", "?"), ("pad", "V3")])


def write_aedat4(
    path: Path,
    packets: Iterable[tuple[int, Events]],
    streams: Sequence[Stream] = ((346, 260),),
    compression: int = 0,
) -> None:
    """Write packets, each of the events of one stream; compressed by lz4 (1, 2) or zstd (3, 4)."""
    with path.open("wb") as file:
        file.write(b"#!AER-DAT4.0\r\n" + _header(streams, compression))
        for stream, events in packets:
            content = _COMPRESS[compression](packet(events))
            file.write(struct.pack("<ii", stream, len(content)) + content)


def _header(streams: Sequence[Stream], compression: int) -> bytes:
    nodes = "".join(
        f'<node name="{i}"><attr key="typeIdentifier" type="string">EVTS</attr><node name="info">'
        f'<attr key="sizeX" type="int">{width}</attr><attr key="sizeY" type="int">{height}</attr>'
        "</node></node>"
        for i, (width, height) in enumerate(streams)
    )
    text = f'<dv version="2.0"><node name="outInfo">{nodes}</node></dv>'.encode()
    # Root and name; sizes and places of the fields, the second is absent; the table; the text.
    head = struct.pack("<I4s5H2x", 20, b"IOHE", 10, 12, 4, 0, 8)
    return _prefixed(head + struct.pack("<iiII", 12, compression, 4, len(text)) + text + b"\0")


def packet(events: Events) -> bytes:
    """Return the buffer of these events, not compressed."""
    rows = np.zeros(len(events), _EVENT)
    for name, role in (("t", "t"), ("x", "x"), ("y", "y"), ("on", "p")):
        rows[name] = events[role]
    head = struct.pack("<I4s3H2x", 16, b"EVTS", 6, 8, 4)  # as above, with one field
    return _prefixed(head + struct.pack("<iII", 8, 4, len(rows)) + rows.tobytes())


def _lz4(content: bytes) -> bytes:
    packed: bytes = pytest.importorskip("lz4.frame").compress(content)
    return packed


def _zstd(content: bytes) -> bytes:
    packed: bytes = pytest.importorskip("zstandard").compress(content)
    return packed


_COMPRESS = {0: bytes, 1: _lz4, 2: _lz4, 3: _zstd, 4: _zstd}


def _prefixed(buffer: bytes) -> bytes:
    return struct.pack("<I", len(buffer)) + buffer
