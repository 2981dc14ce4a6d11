"""Small Prophesee files of given events, written plainly: a second opinion on our decoders."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from asap.events import Events

Words = npt.NDArray[np.unsignedinteger]

RAW_HEADER = "% date 2026-01-01 00:00:00\n% evt {old}\n% format {new};height={h};width={w}\n% end\n"
DAT_HEADER = "% Data file containing CD events.\n% Version {version}\n% Height {h}\n% Width {w}\n"


def columns(events: Events, dtype: str) -> tuple[Words, ...]:
    """t, x, y and p, of one type."""
    return tuple(events[name].astype(dtype) for name in "txyp")


def with_time_high(words: Words, high: Words, mark: Words) -> Words:
    """A word of `mark` before each event whose upper bits of time differ from the last ones."""
    at = np.flatnonzero(np.diff(high.astype(np.int64), prepend=-1))
    return np.insert(words, at, mark[at])


def evt2_words(events: Events) -> Words:
    t, x, y, p = columns(events, "<u8")
    high = t >> 6 & 0xFFFFFFF
    words = p << 28 | (t & 63) << 22 | x << 11 | y
    return with_time_high(words, high, 8 << 28 | high).astype("<u4")


def evt21_words(events: Events) -> Words:
    """An event per word, at any bit of the mask."""
    t, x, y, p = columns(events, "<u8")
    high = t >> 6 & 0xFFFFFFF
    words = p << 60 | (t & 63) << 54 | (x & ~np.uint64(31)) << 43 | y << 32 | 1 << (x & 31)
    return with_time_high(words, high, 8 << 60 | high << 32)


def swapped_halves(words: Words) -> Words:
    return words << np.uint64(32) | words >> np.uint64(32)


def evt3_words(events: Events) -> Words:
    """TIME_HIGH, TIME_LOW and ADDR_Y where they change, then ADDR_X."""
    t, x, y, p = columns(events, "<u4")
    state = np.stack([8 << 12 | t >> 12 & 0xFFF, 6 << 12 | t & 0xFFF, y], axis=1)
    changed = np.diff(state.astype(np.int64), axis=0, prepend=-1) != 0
    changed[:, 1] |= changed[:, 0]
    words = np.column_stack([state, 2 << 12 | p << 11 | x])
    return words[np.column_stack([changed, np.full(len(t), True)])].astype("<u2")


def dat_words(events: Events) -> Words:
    t, x, y, p = columns(events, "<u4")
    return np.column_stack([t, p << 28 | y << 14 | x])


def dat1_words(events: Events) -> Words:
    t, x, y, p = columns(events, "<u4")
    return np.column_stack([t, p << 17 | y << 9 | x])


def raw_file(path: Path, old: str, new: str, words: Words, width: int, height: int) -> Path:
    header = RAW_HEADER.format(old=old, new=new, w=width, h=height)
    path.write_bytes(header.encode() + words.tobytes())
    return path


def write_evt2(path: Path, events: Events, width: int = 346, height: int = 260) -> Path:
    return raw_file(path, "2.0", "EVT2", evt2_words(events), width, height)


def write_evt21(path: Path, events: Events, width: int = 346, height: int = 260) -> Path:
    words = evt21_words(events)
    return raw_file(path, "2.1", "EVT21;endianness=little", words, width, height)


def write_evt21_legacy(path: Path, events: Events, width: int = 346, height: int = 260) -> Path:
    return raw_file(path, "2.1", "EVT21", swapped_halves(evt21_words(events)), width, height)


def write_evt3(path: Path, events: Events, width: int = 346, height: int = 260) -> Path:
    return raw_file(path, "3.0", "EVT3", evt3_words(events), width, height)


def write_dat(
    path: Path, events: Events, width: int = 346, height: int = 260, *, kind: int = 12
) -> Path:
    header = DAT_HEADER.format(version=2, w=width, h=height).encode() + bytes([kind, 8])
    path.write_bytes(header + dat_words(events).tobytes())
    return path


WRITERS = {
    "evt2": write_evt2,
    "evt21": write_evt21,
    "evt21_legacy": write_evt21_legacy,
    "evt3": write_evt3,
    "dat": write_dat,
}
