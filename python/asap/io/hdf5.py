"""HDF5 through the package ``h5py`` (extra ``hdf5``), MATLAB 7.3 files among it.

Columns that lie in the file uncompressed and in one piece are mapped; all others are read by h5py
in steps of whole chunks.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from asap import stamps
from asap.events import Events
from asap.io.columns import events_of, file_columns
from asap.io.errors import CorruptFile, UnsupportedFormat, library
from asap.io.hdf5_layout import find_layouts, sensor_of, usable
from asap.io.mapped import mapped
from asap.io.matrices import columns_of_matrix, order_of
from asap.io.reader import CHUNK, Losses, Options, choose_stream

__all__ = ["Hdf5Reader"]

_STEP = 4 * CHUNK  # events that are read at once: calls of h5py are dear
_CACHE = 1 << 24  # bytes of unpacked chunks per dataset
_SIGNATURE = b"\x89HDF\r\n\x1a\n"


class Hdf5Reader:
    """One stream of events of an HDF5 file; several of them are a question."""

    format = "hdf5"

    def __init__(self, path: Path, options: Options) -> None:
        self._path = path
        with self._open() as file:
            layouts = find_layouts(path, file)
            self.streams = tuple(layouts)
            words = [f"{name} ({layout.rows} events)" for name, layout in layouts.items()]
            layout = layouts[choose_stream(path, options.stream, self.streams, words)]
            self._layout = layout
            for name in layout.datasets.values():
                usable(path, file[name])
            self.width, self.height = sensor_of(file, layout)
            self.expected = layout.rows
            self._order = options.order
            if layout.is_matrix:
                rows = self._rows(file, 0, min(layout.rows, CHUNK))["matrix"]
                self._order = order_of(path, layout.name, rows, options.order)
            elif options.order is not None:
                file_columns(path, dict.fromkeys(layout.datasets, np.empty(0)), options.order)
        self._options = Options(None, options.time_unit)

    def chunks(self, losses: Losses) -> Iterator[Events]:
        """Read in steps of some chunks of the file, hand on in pieces."""
        with self._open() as file:
            datasets = [file[name] for name in self._layout.datasets.values()]
            longest = max(_rows_per_chunk(dataset) for dataset in datasets)
            step = max(_STEP // longest, 1) * longest
            for start in range(0, self._layout.rows, step):
                stop = min(start + step, self._layout.rows)
                try:
                    yield from self._pieces(self._rows(file, start, stop), losses, start)
                except CorruptFile as broken:
                    yield from self._before_the_fault(file, start, stop, longest, losses, broken)
                    return

    def _before_the_fault(
        self, file: Any, start: int, stop: int, step: int, losses: Losses, broken: CorruptFile
    ) -> Iterator[Events]:
        """Yield what is good of a step that cannot be read as a whole."""
        for first in range(start, stop, step):
            try:
                rows = self._rows(file, first, min(first + step, stop))
            except CorruptFile as error:
                losses.truncated(error.offset, f"{error.fault}; {first} events are before it")
                return
            yield from self._pieces(rows, losses, first)
        losses.truncated(broken.offset, broken.fault)

    def _pieces(
        self, rows: dict[str, npt.NDArray[Any]], losses: Losses, first: int
    ) -> Iterator[Events]:
        source: Any = rows
        if self._layout.is_matrix:
            source = columns_of_matrix(rows["matrix"], self._order or "txyp")
        elif "records" in rows:
            source = rows["records"]
        elif self._layout.t_offset:
            offset = np.asarray(self._layout.t_offset)
            source = rows | {"t": stamps.shifted(rows["t"], offset)}
        count = len(next(iter(rows.values())))
        for start in range(0, count, CHUNK):
            part = slice(start, start + CHUNK)
            piece = (
                source[part]
                if isinstance(source, np.ndarray)
                else {role: column[part] for role, column in source.items()}
            )
            yield events_of(piece, self._options, losses, first + start)

    def _rows(self, file: Any, start: int, stop: int) -> dict[str, npt.NDArray[Any]]:
        """Events from `start` to `stop` of every dataset."""
        rows = {}
        for role, name in self._layout.datasets.items():
            dataset = file[name]
            try:
                rows[role] = self._values(file, dataset, start, stop)
            except (OSError, RuntimeError, ValueError) as error:
                offset = _place_in_file(dataset, start)
                raise CorruptFile(self._path, offset, f"{name}: {error}") from error
        return rows

    def _values(self, file: Any, dataset: Any, start: int, stop: int) -> npt.NDArray[Any]:
        if self._layout.transposed:
            return np.asarray(dataset[:, start:stop]).T
        offset = dataset.id.get_offset() if dataset.chunks is None else None
        plain = len(dataset.shape) == 1 or self._layout.is_matrix
        if plain and offset is not None and not file.userblock_size and stop > start:
            row = int(dataset.dtype.itemsize * np.prod(dataset.shape[1:], dtype=int))
            if offset + stop * row > self._path.stat().st_size:
                raise ValueError("the file ends before")
            shape = (stop - start, *dataset.shape[1:])
            return mapped(self._path, dataset.dtype, offset + start * row, shape)
        if len(dataset.shape) > 1 and not self._layout.is_matrix:  # a column of MATLAB 7.3
            at = [slice(start, stop) if side != 1 else slice(0, 1) for side in dataset.shape]
            return np.asarray(dataset[tuple(at)]).reshape(-1)
        return np.asarray(dataset[start:stop])

    @contextmanager
    def _open(self) -> Iterator[Any]:
        h5py = library("h5py", "HDF5", "hdf5")
        try:
            file = h5py.File(self._path, "r", rdcc_nbytes=_CACHE, rdcc_w0=1.0)
        except OSError as error:
            if error.errno:  # the file system's, not the format's
                raise
            raise CorruptFile(self._path, *_why_not(self._path, error)) from error
        with file:
            try:
                yield file
            except (UnsupportedFormat, CorruptFile):
                raise
            except (KeyError, OSError) as error:
                raise CorruptFile(self._path, 0, f"HDF5: {error}") from error


def _rows_per_chunk(dataset: Any) -> int:
    return max(dataset.chunks) if dataset.chunks else 1


def _place_in_file(dataset: Any, row: int) -> int:
    """Where the values from `row` on are stored; 0 if the file does not say."""
    try:
        if dataset.chunks is None:
            return int(dataset.id.get_offset() or 0)
        at = tuple(row if side == max(dataset.shape) else 0 for side in dataset.shape)
        return int(dataset.id.get_chunk_info_by_coord(at).byte_offset or 0)
    except (OSError, RuntimeError, ValueError):
        return 0


def _why_not(path: Path, error: OSError) -> tuple[int, str]:
    """Where the file ends, if it ends before its header says."""
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(64)
    if head.startswith(_SIGNATURE) and len(head) == 64:
        end_at = {0: 40, 1: 44, 2: 28, 3: 28}.get(head[8], -1)
        end = int.from_bytes(head[end_at : end_at + 8], "little") if end_at > 0 else 0
        if end > size:
            return size, f"the file ends, {end} bytes are promised"
    return 0, f"HDF5: {error}"
