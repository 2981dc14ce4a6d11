"""HDF5 through the package ``h5py`` (extra ``hdf5``), MATLAB 7.3 files among it.

Columns that lie in the file uncompressed and in one piece are mapped; all others are read by h5py
in steps of whole chunks.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from asap import _stamps
from asap.events import Events
from asap.io.columns import events_of, file_columns, order_of
from asap.io.errors import CorruptFile, cut_file, foreign, library
from asap.io.hdf5_layout import Layout, find_layouts, sensor_of, usable
from asap.io.numpy_files import mapped
from asap.io.reader import CHUNK, Losses, Options, choose_stream

_STEP = 4 * CHUNK  # events that are read at once: calls of h5py are dear
_SIGNATURE = b"\x89HDF\r\n\x1a\n"


class Hdf5Reader:
    """One stream of events of an HDF5 file; several of them are a question."""

    format = "hdf5"

    def __init__(self, path: Path, options: Options) -> None:
        self._path = path
        with self._open() as file:
            with foreign(path):
                layouts = find_layouts(path, file)
            self.streams = tuple(layouts)
            words = [f"{name} ({layout.rows} events)" for name, layout in layouts.items()]
            layout = layouts[choose_stream(path, options.stream, self.streams, words)]
            self._layout = layout
            with foreign(path):
                for name in layout.datasets.values():
                    usable(path, file[name])
                self.width, self.height = sensor_of(file, layout)
            self.expected = layout.rows
            self._order = options.order
            if layout.is_matrix:
                with foreign(path):
                    rows = self._sources(file)["matrix"].rows(0, min(layout.rows, CHUNK))
                self._order = order_of(path, layout.name, rows, options.order)
            elif options.order is not None:
                file_columns(path, dict.fromkeys(layout.datasets, np.empty(0)), options.order)
        self._options = Options(None, options.time_unit)

    def chunks(self, losses: Losses) -> Iterator[Events]:
        """Read steps of some chunks up to the first damaged chunk, hand on in pieces."""
        with self._open() as file:
            with foreign(self._path):
                sources = self._sources(file)
            longest = max(source.rows_per_chunk for source in sources.values())
            start, step = 0, max(_STEP // longest, 1) * longest
            while start < self._layout.rows:
                stop = min(start + step, self._layout.rows)
                try:
                    rows = {role: source.rows(start, stop) for role, source in sources.items()}
                except CorruptFile as error:
                    if step > longest > 1:
                        step = longest  # the chunks of this step before the damaged one are whole
                        continue
                    losses.truncated(error.offset, error.fault)
                    return
                yield from self._pieces(rows, losses, start)
                start = stop

    def _pieces(
        self, rows: dict[str, npt.NDArray[Any]], losses: Losses, first: int
    ) -> Iterator[Events]:
        source: Any = rows.get("records", rows)
        if self._layout.is_matrix:
            source = dict(zip(self._order or "txyp", rows["matrix"].T, strict=True))
        elif self._layout.t_offset:
            offset = np.asarray(self._layout.t_offset)
            source = rows | {"t": _stamps.shifted(rows["t"], offset)}
        count = len(next(iter(rows.values())))
        for start in range(0, count, CHUNK):
            part = slice(start, start + CHUNK)
            piece = (
                source[part]
                if isinstance(source, np.ndarray)
                else {role: column[part] for role, column in source.items()}
            )
            yield events_of(piece, self._options, losses, first + start)

    def _sources(self, file: Any) -> dict[str, _Source]:
        layout = self._layout
        return {
            role: _Source(self._path, file, file[name], layout)
            for role, name in layout.datasets.items()
        }

    @contextmanager
    def _open(self) -> Iterator[Any]:
        h5py = library("h5py", "HDF5", "hdf5")
        try:
            file = h5py.File(self._path, "r", rdcc_nbytes=0)  # a step takes whole chunks, once
        except OSError as error:
            if error.errno:  # the file system's, not the format's
                raise
            raise _why_not(self._path, error) from error
        with file:
            yield file


class _Source:
    """One dataset of a stream by rows: mapped where it lies uncompressed and in one piece."""

    def __init__(self, path: Path, file: Any, dataset: Any, layout: Layout) -> None:
        self.rows_per_chunk: int = max(dataset.chunks) if dataset.chunks else 1
        self._path, self._dataset, self._transposed = path, dataset, layout.transposed
        self._shape, self._dtype = dataset.shape, dataset.dtype
        self._is_column = len(self._shape) > 1 and not layout.is_matrix  # of MATLAB 7.3
        self._offset: int | None = None
        if dataset.chunks is None and not file.userblock_size and not self._is_column:
            self._offset = None if layout.transposed else dataset.id.get_offset()

    def rows(self, start: int, stop: int) -> npt.NDArray[Any]:
        """Events from `start` to `stop`."""
        try:
            return self._values(start, stop)
        except (OSError, RuntimeError, ValueError) as error:
            fault = f"{self._dataset.name}: {error}"
            raise CorruptFile(self._path, self._place_of(start), fault) from error

    def _values(self, start: int, stop: int) -> npt.NDArray[Any]:
        values: npt.NDArray[Any]
        if self._offset is not None and stop > start:
            row = self._dtype.itemsize * math.prod(self._shape[1:])
            shape = (stop - start, *self._shape[1:])
            return mapped(self._path, self._dtype, self._offset + start * row, shape)
        if self._transposed:
            values = self._dataset[:, start:stop].T
        elif self._is_column:
            at = [slice(start, stop) if side != 1 else slice(0, 1) for side in self._shape]
            values = self._dataset[tuple(at)].reshape(-1)
        else:
            values = self._dataset[start:stop]
        return values

    def _place_of(self, row: int) -> int:
        """Where the values from `row` on are stored; 0 if the file does not say."""
        try:
            if self._dataset.chunks is None:
                return int(self._dataset.id.get_offset() or 0)
            at = tuple(row if side == max(self._shape) else 0 for side in self._shape)
            return int(self._dataset.id.get_chunk_info_by_coord(at).byte_offset or 0)
        except (OSError, RuntimeError, ValueError):
            return 0


def _why_not(path: Path, error: OSError) -> CorruptFile:
    """Say where the file ends, if it ends before its header says."""
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(64)
    if head.startswith(_SIGNATURE):
        if len(head) < 64:
            return cut_file(path, size, "HDF5", "the file ends inside its header")
        end_at = {0: 40, 1: 44, 2: 28, 3: 28}.get(head[8], -1)
        end = int.from_bytes(head[end_at : end_at + 8], "little") if end_at > 0 else 0
        if end > size:
            return cut_file(path, size, "HDF5", f"the file ends, {end} bytes are promised")
    return CorruptFile(path, 0, f"HDF5: {error}")
