"""Small files of every format that the core decodes, written plainly: a second opinion."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

import event_files
import raw_files
from asap.events import Events

SIDE = 128  # px, of the sensor in every header
DAVIS = "# AEChip: eu.seebetter.ini.chips.davis.DAVIS128\r\n"
DVS128 = "# AEChip: ch.unizh.ini.jaer.chip.retina.DVS128\r\n"
ONE_CAMERA = "#Format: RAW\r\n#Source 0: DVS128\r\n"

Column = npt.NDArray[np.int64]


def columns(events: Events) -> tuple[Column, ...]:
    """t, x, y and p."""
    return tuple(events[name].astype(np.int64) for name in "txyp")


def low_bytes(words: Column, count: int) -> npt.NDArray[np.uint8]:
    """The lower bytes of each word, the lowest first."""
    return words.astype("<i8").view(np.uint8).reshape(-1, 8)[:, :count]


def after_long_steps(longs: Column, records: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Each record after its number of bytes 0xff."""
    size = records.shape[1]
    ends = np.cumsum(longs + size)
    content = np.full(ends[-1] if len(ends) else 0, 0xFF, np.uint8)
    for at in range(size):
        content[ends - size + at] = records[:, at]
    return content


def es2(events: Events) -> bytes:
    """Event Stream 2.0, whose row 0 is the bottom one."""
    t, x, y, p = columns(events)
    longs, step = np.divmod(np.diff(t, prepend=0), 127)
    records = low_bytes(step << 1 | p | x << 8 | (SIDE - 1 - y) << 24, 5)
    size = np.array([SIDE, SIDE], "<u2").tobytes()
    return b"Event Stream\x02\x00\x00\x01" + size + after_long_steps(longs, records).tobytes()


def es1(events: Events) -> bytes:
    """Event Stream 1.0, which tells no size; the steps are whole numbers of 15 x 15 us first."""
    t, x, y, p = columns(events)
    longs, rest = np.divmod(np.diff(t, prepend=0), 15 * 15)
    middle, step = np.divmod(rest, 15)
    words = step | x << 4 | (SIDE - 1 - y) << 14 | p << 23
    records = low_bytes(middle << 4 | 15 | words << 8, 4)
    return b"Event Stream\x01\x00\x00" + after_long_steps(longs, records).tobytes()


def atis40(events: Events) -> bytes:
    """40-bit events; times below 2^23 us."""
    t, x, y, p = columns(events)
    return low_bytes(x << 32 | y << 24 | p << 23 | t, 5)[:, ::-1].tobytes()


def davis(x: Column, y: Column, p: Column) -> Column:
    """Addresses of a DAVIS."""
    return (SIDE - 1 - y) << 22 | (SIDE - 1 - x) << 12 | p << 11


def dvs128(x: Column, y: Column, p: Column) -> Column:
    """Addresses of a DVS128."""
    return (SIDE - 1 - y) << 8 | (SIDE - 1 - x) << 1 | (1 - p)


def aedat2(events: Events, lines: str = DAVIS, address: Callable[..., Column] = davis) -> bytes:
    """AEDAT 2.0."""
    t, *place = columns(events)
    records = np.stack([address(*place), t], axis=1).astype(">u4")
    head = f"#!AER-DAT2.0\r\n# This is a raw AE data file\r\n{lines}"
    return head.encode() + records.tobytes()


def packet(kind: int, records: bytes, *, source: int = 0) -> bytes:
    """A packet of AEDAT 3.1; its records have 8 bytes."""
    count = len(records) // 8
    return (
        np.array([kind, source], "<i2").tobytes()
        + np.array([8, 4, 0, count, count, count], "<i4").tobytes()
        + records
    )


def aedat3(
    events: Events, lines: str = ONE_CAMERA, per_packet: int = 4096, source: int = 0
) -> bytes:
    """AEDAT 3.1."""
    t, x, y, p = columns(events)
    records = low_bytes(1 | p << 1 | y << 2 | x << 17 | t << 32, 8)
    packets = [
        packet(1, records[at : at + per_packet].tobytes(), source=source)
        for at in range(0, len(events), per_packet)
    ]
    return f"#!AER-DAT3.1\r\n{lines}#!END-HEADER\r\n".encode() + b"".join(packets)


class Format(NamedTuple):
    """How a test writes a file of a sensor of SIDE x SIDE, and what asap says of it."""

    write: Callable[[Path, Events], object]
    name: str
    suffix: str
    side: int | None = SIDE  # px, where the file states it
    height: int | None = None  # px, where the user has to state it


def _of(content: Callable[[Events], bytes], *facts: object) -> Format:
    return Format(lambda path, events: path.write_bytes(content(events)), *facts)  # type: ignore[arg-type]


RECORDS = {
    "es": _of(es2, "es", ".es"),
    "es1": _of(es1, "es", ".es", None, SIDE),
    "atis40": _of(atis40, "atis40", ".bin", None),
    "aedat2": _of(aedat2, "aedat2", ".aedat"),
    "dvs128": _of(lambda events: aedat2(events, DVS128, dvs128), "aedat2", ".aedat"),
    "aedat3": _of(aedat3, "aedat3", ".aedat"),
}
# At least one of each of _core.RECORDING_FORMATS.
FORMATS = RECORDS | {
    kind: Format(
        partial(write, width=SIDE, height=SIDE),
        kind.removesuffix("_legacy"),
        ".dat" if kind == "dat" else ".raw",
    )
    for kind, write in raw_files.WRITERS.items()
}
PLAIN = {kind: Format(write, kind, f".{kind}") for kind, write in event_files.WRITERS.items()}
