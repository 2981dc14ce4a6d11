"""Which format a file has: by its first bytes, then by its name."""

from __future__ import annotations

import errno
import os
import re
from collections.abc import Collection
from pathlib import Path

from asap import _core
from asap._checks import choice, regular_file
from asap.io.errors import CorruptFile, UnsupportedFormat

SERVED = ", ".join(
    (
        *("npy", "npz", "text (t x y p)", "csv", "aedat4", "hdf5", "matlab", "ROS bags"),
        *_core.RECORDING_FORMATS,
    )
)

_HEAD = 4096
_SERVED_BYTES = (
    (b"\x93NUMPY", "npy"),
    (b"PK\x03\x04", "npz"),
    (b"PK\x05\x06", "npz"),
    (b"#!AER-DAT4.0", "aedat4"),
    (b"\x89HDF\r\n\x1a\n", "hdf5"),
    (b"MATLAB 7.3", "hdf5"),
    (b"MATLAB 5.0", "matlab"),
    (b"#ROSBAG", "rosbag1"),
    (b"SQLite format 3\x00", "rosbag2"),
    (b"\x89MCAP", "mcap"),
)
_SERVED_SUFFIXES = (
    *(".npy", ".npz", ".aedat4", ".h5", ".hdf5", ".mat", ".raw", ".es"),
    *(".bag", ".db3", ".mcap"),
)
_REFUSED_BYTES = (
    (b"\x1f\x8b\x08", "packed by gzip; unpack it first"),
    (b"BZh", "packed by bzip2; unpack it first"),
    (b"\xfd7zXZ\x00", "packed by xz; unpack it first"),
    (b"\x28\xb5\x2f\xfd", "packed by zstd; unpack it first"),
    (b"\xff\xfe", "text in UTF-16; save it in UTF-8"),
    (b"\xfe\xff", "text in UTF-16; save it in UTF-8"),
    (b"#!AER-DAT", f"AEDAT 1.0 or 3.0 is not read yet; what is: {SERVED}"),
)
_PAGE = "a web page, saved in the place of the recording; download the file itself"
_REFUSED_TEXT = (  # in small letters
    (
        b"version https://git-lfs",
        "a pointer of Git LFS; 'git lfs pull' fetches the file",
    ),
    (b"<!doctype html", _PAGE),
    (b"<html", _PAGE),
)
_SUFFIXES_OF_40_BITS = (".bin", ".bs2")
_AEDAT = ".aedat"
_TEXT_SUFFIXES = (".csv", ".txt", ".dat")
METADATA = "metadata.yaml"  # of a ROS 2 bag
_NUMBERS = re.compile(r"\d+")
_BINARY_SUFFIXES = (*_SERVED_SUFFIXES, _AEDAT, *_SUFFIXES_OF_40_BITS)
_PROPHESEE_HEADER = (b"% evt ", b"% format EVT", b"% Data file containing", b"% camera_integrator")


def sniff(path: Path) -> str:
    """Return the name of the format: a key of the readers.

    Raises
    ------
    UnsupportedFormat
        No reader serves it.
    CorruptFile
        It is empty, or not what its name promises.
    OSError
        It cannot be opened, or is a pipe, a socket, a device or a folder that is no bag.
    """
    if path.is_dir():
        return _of_folder(path)
    head = first_bytes(path)
    if (name := stated(head)) is not None:
        return name
    words = _that_begins(head, _REFUSED_BYTES) or _that_begins(_plain(head), _REFUSED_TEXT)
    if words is not None:
        raise UnsupportedFormat(f"{path}: {words}")
    if path.suffix.lower() == ".dat" and _is_header(head):
        raise CorruptFile(path, len(head), "the file ends inside its header")
    if any(mark in head for mark in _PROPHESEE_HEADER):
        raise _unsupported(path, "this Prophesee encoding")
    if not any(head):
        raise CorruptFile(path, 0, f"its first {len(head)} bytes are all zero: nothing was copied")
    suffix = path.suffix.lower()
    is_text = _is_text(head)
    if suffix in _BINARY_SUFFIXES:
        if any(mark.startswith(head) for mark, _ in _SERVED_BYTES):
            raise CorruptFile(path, len(head), "the file ends inside its signature")
        if is_text and not head.startswith(b"%"):
            fault = f"text, not the events of a {suffix} file; file_format='text' reads it"
            raise CorruptFile(path, 0, fault)
    if suffix in _SERVED_SUFFIXES:
        raise CorruptFile(path, 0, f"not the beginning of a {suffix} file{_remedy(suffix, head)}")
    if suffix == _AEDAT:
        words = "without '#!AER-DAT' at its beginning this is AEDAT 1.0 or none, which"
        raise _unsupported(path, words)
    if suffix in _SUFFIXES_OF_40_BITS:  # nothing in such bytes says it
        return "atis40"
    if not is_text:
        if suffix == ".dat":
            raise CorruptFile(path, 0, "not the beginning of a .dat file")
        words = f"a file that begins with the bytes {head[:8].hex(' ')}"
        raise _unsupported(path, words, _as_40_bits(path))
    return "text"


def format_of(path: Path, file_format: str | None, known: Collection[str]) -> str:
    """Return the format that the user names, which must be `known`; else what `sniff` finds."""
    if file_format is None:
        return sniff(path)
    choice("file_format", file_format, known)
    found = None if path.is_dir() else stated(first_bytes(path))  # a bag may be a folder
    if found not in (None, file_format):
        raise CorruptFile(path, 0, f"this is {found}, not {file_format}; leave file_format out")
    return file_format


def stated(head: bytes) -> str | None:
    """Return the format whose mark a file begins with, None if it begins with none."""
    return _that_begins(head, _SERVED_BYTES) or _core.recording_format(head) or None


def first_bytes(path: Path) -> bytes:
    """Return the beginning of a file; refuse an empty one, and what is no file."""
    regular_file(path)
    with path.open("rb") as file:
        head = file.read(_HEAD)
    if not head:
        raise CorruptFile(path, 0, "the file is empty")
    return head


def _that_begins(head: bytes, marks: tuple[tuple[bytes, str], ...]) -> str | None:
    return next((name for mark, name in marks if head.startswith(mark)), None)


def _plain(head: bytes) -> bytes:
    return head.removeprefix(b"\xef\xbb\xbf").lstrip().lower()


def _of_folder(path: Path) -> str:
    if (path / METADATA).exists():
        return "rosbag2"
    if parts := parts_of(path):
        return sniff(parts[0])
    fault = "Is a directory, and not of numbered parts of one recording; give a file in it"
    raise IsADirectoryError(errno.EISDIR, fault, str(path))


def parts_of(folder: Path, *, like: Path | None = None) -> list[Path]:
    """List the parts of one recording, by number; only those like a file, if one is given.

    None where the folder holds recordings of several names, which are no parts of one.
    """
    suffixes = (*_BINARY_SUFFIXES, *_TEXT_SUFFIXES) if like is None else (like.suffix.lower(),)
    names = [name for name in os.listdir(folder) if name.lower().endswith(suffixes)]
    if like is not None:
        names = [name for name in names if _NUMBERS.sub("#", name) == _NUMBERS.sub("#", like.name)]
    if len({_NUMBERS.sub("#", name) for name in names}) != 1:
        return []
    names.sort(key=lambda name: [int(number) for number in _NUMBERS.findall(name)])
    return [folder / name for name in names]


def _remedy(suffix: str, head: bytes) -> str:
    if suffix != ".raw":
        return ""
    lack = "its header has no line '% evt' or '% format'"
    if not head.startswith(b"% "):
        lack = "it has no header"
    return f": {lack}; name the encoding, such as file_format='evt3' (or evt2, evt21)"


def _unsupported(path: Path, name: str, remedy: str = "") -> UnsupportedFormat:
    return UnsupportedFormat(f"{path}: {name} is not read yet; what is: {SERVED}{remedy}")


def _as_40_bits(path: Path) -> str:
    """Return how to read 40-bit events under another suffix, if there are whole ones."""
    whole = path.stat().st_size % 5 == 0
    return "; if these are 40-bit events, give file_format='atis40'" if whole else ""


def _is_header(head: bytes) -> bool:
    """Whether these bytes are the whole file, and no line of it is more than a comment."""
    return len(head) < _HEAD and all(line.startswith(b"%") for line in head.splitlines())


def _is_text(head: bytes) -> bool:
    strange = sum(byte < 32 and byte not in b"\t\n\r\f" for byte in head)
    return b"\x00" not in head and strange * 100 <= len(head)
