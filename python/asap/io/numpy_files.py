"""NumPy files: ``.npy``, mapped and read in pieces, and ``.npz``, loaded as a whole.

Sizes in the headers are never trusted: they are compared with the bytes that are there before
anything is allocated. Nothing is unpickled.
"""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt
from numpy.lib import format as npy

from asap.events import FIELD_NAMES, Events
from asap.io.columns import events_of, file_columns
from asap.io.errors import CorruptFile, UnsupportedFormat, foreign
from asap.io.reader import CHUNK, Losses, Options

__all__ = ["NpyReader", "NpzReader"]

_MAX_RATIO = 1000  # decompressed to compressed, for archives beyond _HARMLESS bytes
_HARMLESS = 1 << 28


class NpyReader:
    """One structured array, or one of shape (N, len(order)); zero-copy where it is EVENT_DTYPE."""

    format = "npy"
    width: int | None = None
    height: int | None = None

    def __init__(self, path: Path, options: Options) -> None:
        self._path, self._options = path, options
        with foreign(path), path.open("rb") as file:
            shape, fortran, dtype = _header(file)
            self._offset = file.tell()
        if not shape:
            raise CorruptFile(path, self._offset, "the array is a single value, not events")
        self._dtype, self._promised, self._row = dtype, shape[0], shape[1:]
        self._fortran = fortran and len(shape) > 1
        row_bytes = dtype.itemsize * int(np.prod(self._row, dtype=object))
        present = (path.stat().st_size - self._offset) // max(row_bytes, 1)
        self._rows = min(self._promised, present)
        self._end = self._offset + self._rows * row_bytes
        if self._rows < self._promised and (self._fortran or self._rows == 0):
            raise CorruptFile(path, self._end, f"{self._promised} events promised, the file ends")
        file_columns(path, self._map(), options.order, first=1)

    def chunks(self, losses: Losses) -> Iterator[Events]:
        """Map the file and convert it piece by piece."""
        rows = self._map()
        for start in range(0, self._rows, CHUNK):
            yield events_of(rows[start : start + CHUNK], self._options, losses, start)
        if self._rows < self._promised:
            losses.truncated(self._end, f"{self._rows} of {self._promised} events are there")

    def _map(self) -> npt.NDArray[Any]:
        shape = (self._rows, *self._row)
        if 0 in shape:
            with foreign(self._path, self._offset):
                return np.empty(shape, self._dtype)
        order: Any = "F" if self._fortran else "C"
        mapped = np.memmap(self._path, self._dtype, "r", self._offset, shape, order)
        return mapped.view(np.ndarray)


class NpzReader:
    """Columns ``t``, ``x``, ``y``, ``p`` (or their other names), or one array of events.

    The array is the only one in the file, or the one called ``events``. Two numbers ``width`` and
    ``height`` state the sensor.
    """

    format = "npz"

    def __init__(self, path: Path, options: Options) -> None:
        self._path, self._options = path, options
        with foreign(path), zipfile.ZipFile(path) as archive:
            self._members = _members(path, archive)
            self.width = self._number(archive, "width")
            self.height = self._number(archive, "height")
        self._keys = self._choose()

    def chunks(self, losses: Losses) -> Iterator[Events]:
        """Load the arrays and convert them piece by piece."""
        with foreign(self._path), zipfile.ZipFile(self._path) as archive:
            arrays = {key: self._array(archive, key) for key in self._keys}
        if len(arrays) == 1:
            (events,) = arrays.values()
            file_columns(self._path, events, self._options.order, first=1)
            for start in range(0, len(events), CHUNK):
                yield events_of(events[start : start + CHUNK], self._options, losses, start)
            return
        columns = file_columns(self._path, arrays, self._options.order)
        for start in range(0, len(columns["t"]), CHUNK):
            piece = {role: column[start : start + CHUNK] for role, column in columns.items()}
            yield events_of(piece, self._options, losses, start)

    def _choose(self) -> list[str]:
        understood = {name for names in FIELD_NAMES.values() for name in names}
        columns = [key for key in self._members if key in understood]
        if len(columns) >= 3:
            return columns
        others = [key for key in self._members if key not in ("width", "height")]
        if "events" in others:
            return ["events"]
        if len(others) == 1:
            return others
        raise UnsupportedFormat(
            f"{self._path}: no events among the arrays {', '.join(others) or '(none)'}: needed are "
            "columns t, x, y, p, or one structured array, called events if it is not the only one"
        )

    def _array(self, archive: zipfile.ZipFile, key: str) -> npt.NDArray[Any]:
        info = self._members[key]
        with archive.open(info) as member:
            shape, _, dtype = _header(member)
            promised = member.tell() + dtype.itemsize * int(np.prod(shape, dtype=object))
        if promised != info.file_size:
            raise CorruptFile(
                self._path,
                info.header_offset,
                f"{key}: {promised} bytes promised, {info.file_size} are there",
            )
        with foreign(self._path, info.header_offset), archive.open(info) as member:
            array: npt.NDArray[Any] = npy.read_array(member, allow_pickle=False)
        return array if array.ndim else array.reshape(1)

    def _number(self, archive: zipfile.ZipFile, key: str) -> int | None:
        return int(self._array(archive, key).item()) if key in self._members else None


def _header(file: IO[bytes]) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    version = npy.read_magic(file)
    if version == (1, 0):
        shape, fortran, dtype = npy.read_array_header_1_0(file)
    elif version == (2, 0):
        shape, fortran, dtype = npy.read_array_header_2_0(file)
    else:
        raise ValueError(f"npy version {version[0]}.{version[1]} is not known")
    if dtype.hasobject:
        raise ValueError("the array holds Python objects, which are never unpickled")
    if any(length < 0 for length in shape):
        raise ValueError(f"shape {shape} is impossible")
    return shape, fortran, dtype


def _members(path: Path, archive: zipfile.ZipFile) -> dict[str, zipfile.ZipInfo]:
    infos = [info for info in archive.infolist() if info.filename.endswith(".npy")]
    size = sum(info.file_size for info in infos)
    if size > max(_HARMLESS, _MAX_RATIO * path.stat().st_size):
        raise CorruptFile(path, 0, f"decompresses to {size} bytes, more than {_MAX_RATIO} times")
    return {info.filename.removesuffix(".npy"): info for info in infos}
