"""NumPy files: ``.npy`` and ``.npz``, read in pieces.

Sizes in the headers are never trusted: they are compared with the bytes that are there before
anything is allocated. Nothing is unpickled.
"""

from __future__ import annotations

import math
import zipfile
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt
from numpy.lib import format as npy

from asap import _core
from asap.events.columns import ROLES
from asap.events.values import Events
from asap.io.columns import (
    as_rows,
    events_of,
    file_columns,
    first_us,
    pieces_of,
    row_before,
)
from asap.io.errors import CorruptFile, UnsupportedFormat, cut_file, foreign, refuse_bomb
from asap.io.reader import (
    CHUNK,
    SIZE,
    Losses,
    Options,
    choose_stream,
    new_room,
    size_of,
)

_PACKED_BY_NUMPY = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # the others unpack without a limit

_UNIT = "time_unit"
_FEW = 16  # values, where a size is stated
_WIDEST = 1 << 16  # bytes of a value


@dataclass(frozen=True)
class _Header:
    shape: tuple[int, ...]
    fortran: bool
    dtype: np.dtype[Any]
    end: int  # where the values begin

    @property
    def row_bytes(self) -> int:
        return self.dtype.itemsize * math.prod(self.shape[1:])

    def stand_in(self, rows: int | None = None) -> npt.NDArray[Any]:
        """Zeros of the array's type and shape that take no memory, or of so many `rows`."""
        shape = self.shape if rows is None else (rows, *self.shape[1:])
        return np.broadcast_to(np.zeros((), self.dtype), shape or (1,))

    def by_events(self, order: str | None) -> _Header:
        """Return the same bytes as rows of events, where their columns are the events."""
        rows = as_rows(self.shape, order)
        if self.dtype.names is not None or rows is None or not rows[1]:
            return self
        return replace(self, shape=self.shape[::-1], fortran=not self.fortran)

    @property
    def is_by_columns(self) -> bool:
        return self.fortran and len(self.shape) > 1


class NpyReader:
    """One structured array, or one of shape (N, len(order)); zero-copy where it is EVENT_DTYPE."""

    format = "npy"
    width: int | None = None
    height: int | None = None

    def __init__(self, path: Path, options: Options) -> None:
        self._path, self._options = path, options
        with foreign(path), path.open("rb") as file:
            self._header = header = _header(file).by_events(options.order)
        if not header.shape:
            raise CorruptFile(path, header.end, "the array is a single value, not events")
        self._promised = header.shape[0]
        self._zeros = 0 if header.is_by_columns else _core.data_end(path)
        end = self._zeros or path.stat().st_size
        present = max(end - header.end, 0) // max(header.row_bytes, 1)
        self.expected = min(self._promised, present)
        self._end = header.end + self.expected * header.row_bytes
        if self.expected < self._promised and (header.is_by_columns or self.expected == 0):
            raise CorruptFile(path, self._end, f"{self._promised} events promised, the file ends")
        with foreign(path, header.end):
            rows = header.stand_in(self.expected)
        file_columns(path, rows, options.order, first=1)

    def chunks(self, losses: Losses, from_us: int | None = None) -> Iterator[Events]:
        """Read window by window and convert piece by piece."""
        begin, header = 0, self._header
        if from_us is not None and not header.is_by_columns:
            counted = replace(losses, room=new_room)  # of which nothing is taken

            def time_of(row: int) -> int | None:
                rows = self._rows(row, row + 1)
                return first_us(events_of(rows, self._options, counted, row + 1))

            begin = row_before(time_of, self.expected, from_us) // CHUNK * CHUNK
        for first, stop in windows(begin, self.expected, header.row_bytes, CHUNK):
            yield from pieces_of(self._rows(first, stop), self._options, losses, first)
        if self._zeros:
            losses.zeros(max(self._zeros, header.end))
        elif self.expected < self._promised:
            losses.truncated(self._end, f"{self.expected} of {self._promised} events are there")

    def _rows(self, first: int, stop: int) -> npt.NDArray[Any]:
        header = self._header
        shape = (stop - first, *header.shape[1:])
        if 0 in shape or header.dtype.itemsize == 0:
            with foreign(self._path, header.end):
                return np.empty(shape, header.dtype)
        if not header.is_by_columns:
            return self._values(first * math.prod(shape[1:]), shape)
        columns = range(first, math.prod(header.shape), header.shape[0])
        return np.stack([self._values(at, shape[:1]) for at in columns], axis=1)

    def _values(self, first: int, shape: tuple[int, ...]) -> npt.NDArray[Any]:
        """Read, not map: a file that another program cuts would end the interpreter."""
        dtype, offset = self._header.dtype, self._header.end + first * self._header.dtype.itemsize
        values: npt.NDArray[Any] = np.fromfile(self._path, dtype, math.prod(shape), offset=offset)
        if values.size < math.prod(shape):
            fault = "the file became shorter while it was read"
            raise CorruptFile(self._path, self._path.stat().st_size, fault)
        return values.reshape(shape)


class NpzReader:
    """Columns ``t``, ``x``, ``y``, ``p`` (or their other names), or one array of events.

    The array is the only one in the file, the one called ``events``, or a stream. Two numbers
    ``width`` and ``height`` state the sensor, a text ``time_unit`` the unit of the times.
    """

    format = "npz"
    streams: tuple[str, ...] = ()

    def __init__(self, path: Path, options: Options) -> None:
        self._path, self._options = path, options
        _check_end(path)
        self._archive = Archive(path)
        with foreign(path):
            self.width, self.height = size_of(self._archive.arrays, self._stated)
            if options.time_unit is None and _UNIT in self._archive:
                self._options = replace(options, time_unit=str(self._stated(_UNIT)))
        self._headers = {
            key: self._archive.header(key).by_events(options.order) for key in self._choose()
        }
        lengths = {key: (*header.shape, 1)[0] for key, header in self._headers.items()}
        self.expected = max(lengths.values())
        if len(set(lengths.values())) > 1:
            raise ValueError(
                f"{path}: lengths = {lengths}: the columns of events must be equally long"
            )

    def chunks(self, losses: Losses, from_us: int | None = None) -> Iterator[Events]:
        """Read the arrays side by side and convert them piece by piece."""
        arrays = {key: header.stand_in() for key, header in self._headers.items()}
        whole = arrays if len(arrays) > 1 else arrays.popitem()[1]
        file_columns(self._path, whole, self._options.order, first=1)
        pieces = {key: self._pieces(key) for key in self._headers}
        for start in range(0, self.expected, CHUNK):
            columns = {key: next(piece) for key, piece in pieces.items()}
            source = columns if len(columns) > 1 else columns.popitem()[1]
            yield events_of(source, self._options, losses, start)

    def _pieces(self, key: str) -> Iterator[npt.NDArray[Any]]:
        """Rows of one array."""
        header = self._headers[key]
        if header.is_by_columns or header.row_bytes == 0 or len(header.shape) == 0:
            rows = self._archive.array(key)
            rows = rows if rows.shape == header.shape or not header.shape else rows.T
            for start in range(0, len(rows), CHUNK):
                yield rows[start : start + CHUNK]
            return
        with self._archive.opened(key) as member:
            member.read(header.end)
            for start in range(0, self.expected, CHUNK):
                count = min(CHUNK, self.expected - start)
                data = member.read(count * header.row_bytes)
                if start + count == self.expected:
                    member.read(1)  # the end, where the checksum is compared
                yield np.frombuffer(data, header.dtype).reshape(count, *header.shape[1:])

    def _choose(self) -> list[str]:
        names = self._archive.arrays
        if not names:
            raise UnsupportedFormat(f"{self._path}: a zip archive without arrays; unpack it first")
        columns = [key for key in names if key in ROLES]
        if len(columns) >= 3:
            return columns
        others = [key for key in names if key != _UNIT and not SIZE.fullmatch(key)]
        if "events" in others and self._options.stream is None:
            return ["events"]
        if len(others) == 1:
            return others
        if found := list(filter(self._may_be_events, others)):
            self.streams = tuple(found)
            return [choose_stream(self._path, self._options.stream, found)]
        raise UnsupportedFormat(
            f"{self._path}: no events among the arrays {', '.join(others) or '(none)'}: needed are "
            "columns t, x, y, p, or arrays of records or of four columns"
        )

    def _may_be_events(self, key: str) -> bool:
        with suppress(ValueError):  # of Python objects, for example
            header = self._archive.header(key)
            return header.dtype.names is not None or bool(
                header.dtype.kind in "biuf" and as_rows(header.shape, self._options.order)
            )
        return False

    def _stated(self, key: str) -> Any:
        if math.prod(self._archive.header(key).shape) > _FEW:
            return None
        value = self._archive.array(key)
        return value.item() if value.dtype.kind in "SU" and value.size == 1 else value


class Archive:
    """The members of an ``.npz``, arrays by their names, each checked before it is unpacked."""

    def __init__(self, path: Path) -> None:
        self._path = path
        with foreign(path), zipfile.ZipFile(path) as archive:
            infos = archive.infolist()
        refuse_bomb(path, 0, "it", sum(info.file_size for info in infos), path.stat().st_size)
        for info in infos:
            if info.compress_type not in _PACKED_BY_NUMPY:
                fault = f"{info.filename}: compression {info.compress_type} is none of NumPy's"
                raise CorruptFile(path, info.header_offset, fault)
        self._infos = {info.filename: info for info in infos}

    @property
    def arrays(self) -> list[str]:
        """Names of the arrays."""
        return [name.removesuffix(".npy") for name in self._infos if name.endswith(".npy")]

    def __contains__(self, key: str) -> bool:
        return f"{key}.npy" in self._infos

    def header(self, key: str) -> _Header:
        """Read the header of an array and compare its size with the bytes that are there."""
        info = self._info(f"{key}.npy")
        with self._open(info) as member:
            try:
                header = _header(member)
            except ValueError as error:
                raise ValueError(f"{info.filename}: {error}") from error
        promised = header.end + header.dtype.itemsize * math.prod(header.shape)
        if promised != info.file_size:
            fault = f"{key}: {promised} bytes promised, {info.file_size} are there"
            raise CorruptFile(self._path, info.header_offset, fault)
        return header

    def opened(self, key: str) -> AbstractContextManager[IO[bytes]]:
        """Open an array's member."""
        return self._open(self._info(f"{key}.npy"))

    def array(self, key: str) -> npt.NDArray[Any]:
        """Unpack an array; a single value becomes one of shape (1,)."""
        self.header(key)
        with self.opened(key) as member:
            array: npt.NDArray[Any] = npy.read_array(member, allow_pickle=False)
        return array if array.ndim else array.reshape(1)

    @contextmanager
    def _open(self, info: zipfile.ZipInfo) -> Iterator[IO[bytes]]:
        with (
            foreign(self._path, info.header_offset),
            zipfile.ZipFile(self._path) as archive,
            archive.open(info) as member,
        ):
            yield member

    def _info(self, name: str) -> zipfile.ZipInfo:
        if name not in self._infos:
            raise CorruptFile(self._path, 0, f"{name}: missing in the archive")
        return self._infos[name]


def _header(file: IO[bytes]) -> _Header:
    version = npy.read_magic(file)
    if version == (1, 0):
        shape, fortran, dtype = npy.read_array_header_1_0(file)
    elif version == (2, 0):
        shape, fortran, dtype = npy.read_array_header_2_0(file)
    else:
        raise ValueError(f"npy version {version[0]}.{version[1]} is not known")
    if dtype.hasobject:
        raise ValueError("the array holds Python objects, which are never unpickled")
    if dtype.itemsize > _WIDEST:  # NumPy takes the memory of one even for an array of none
        raise ValueError(f"its values have {dtype.itemsize} bytes each; an event has not so many")
    if any(length < 0 for length in shape):
        raise ValueError(f"shape {shape} is impossible")
    return _Header(shape, fortran, dtype, file.tell())


def _check_end(path: Path) -> None:
    """Refuse an archive that is cut: its directory, which is its end, is missing."""
    with path.open("rb") as file:
        if file.read(4) == b"PK\x03\x04" and not zipfile.is_zipfile(file):
            size = path.stat().st_size
            raise cut_file(path, size, "npz", "the directory of the archive, its end, is missing")


_WINDOW = 1 << 20  # bytes


def windows(begin: int, rows: int, row_bytes: int, chunk: int) -> Iterator[tuple[int, int]]:
    """Half-open ranges of rows from `begin`, multiples of `chunk`, of about a megabyte."""
    step = max(_WINDOW // max(row_bytes, 1) // chunk, 1) * chunk
    for start in range(begin, rows, step):
        yield start, min(start + step, rows)
