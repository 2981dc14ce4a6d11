"""HDF5 through the package ``h5py`` (extra ``hdf5``), MATLAB 7.3 files among it.

Streams are found by what is in the file: groups of columns, arrays of records, matrices. DSEC
(``events/{t,x,y,p}``, ``t_offset``), Metavision (``CD/events``), MVSEC (``davis/left/events``),
M3ED (``prophesee/left/{t,x,y,p}``) and others that are built alike need no rules of their own. The
reader never follows links that lead elsewhere: soft ones, external ones, storage in other files.
h5py reads the columns in steps of whole chunks.
"""

from __future__ import annotations

import importlib
import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from asap.events.columns import FIELD_NAMES
from asap.events.values import MAX, Events, shifted
from asap.io.columns import (
    as_rows,
    by_order,
    file_columns,
    first_us,
    names_by_role,
    pieces_of,
    row_before,
)
from asap.io.errors import (
    CorruptFile,
    MissingLibrary,
    UnsupportedFormat,
    cut_file,
    foreign,
    library,
    refuse_bomb,
)
from asap.io.reader import CHUNK, Losses, Options, choose_stream, new_room, size_of

h5py = library("h5py", "HDF5", "hdf5")

_FEW = 16  # values, where a size is stated
_STEP = 4 * CHUNK  # events that are read at once: calls of h5py are dear
_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_MAX_OBJECTS = 10_000
_MAX_BYTES = 1024  # one record has at most so many
_ECF = 0x8ECF


class Hdf5Reader:
    """One stream of events of an HDF5 file; several of them are a question."""

    format = "hdf5"

    def __init__(self, path: Path, options: Options) -> None:
        self._path = path
        with self._open() as file:
            with foreign(path):
                layouts = _find_layouts(path, file, options)
            self.streams = tuple(layouts)
            words = [f"{name} ({layout.rows} events)" for name, layout in layouts.items()]
            layout = layouts[choose_stream(path, options.stream, self.streams, words)]
            self._layout = layout
            with foreign(path):
                datasets = {role: file[name] for role, name in layout.datasets.items()}
                for dataset in datasets.values():
                    _usable(path, dataset)
                # Narrow times cannot leave 64 bits by it, and no column has to be made wider.
                t = datasets["t"].dtype if "t" in datasets else None
                narrow = t is not None and t.itemsize <= 4 and t.kind in "iu"
                is_us = options.time_unit in (None, "us") and abs(layout.t_offset) < 1 << 62
                self._adds_later = narrow and is_us
                self.width, self.height = _sensor_of(file, next(iter(datasets.values())))
                unit = options.time_unit or ("us" if "ms_to_idx" in file else None)  # DSEC
            self.expected = layout.rows
            self._order = options.order
            if layout.is_matrix:
                with foreign(path):
                    rows = self._sources(file)["matrix"].rows(0, 0)
                by_order(path, layout.name, rows, options.order)
            elif options.order is not None:
                file_columns(path, dict.fromkeys(layout.datasets, np.empty(0)), options.order)
        self._options = Options(None, unit)

    def chunks(self, losses: Losses, from_us: int | None = None) -> Iterator[Events]:
        """Read steps of some chunks up to the first damaged chunk, hand on in pieces."""
        with self._open() as file:
            with foreign(self._path):
                sources = self._sources(file)
            longest = max(source.rows_per_chunk for source in sources.values())
            step, most = (max(events // longest, 1) * longest for events in (CHUNK, _STEP))
            start = 0
            if from_us is not None:
                counted = replace(losses, room=new_room)  # of which nothing is taken

                def time_of(number: int) -> int | None:
                    rows = {role: source.row(number * step) for role, source in sources.items()}
                    return first_us(next(self._pieces(rows, counted, 1)))

                start = row_before(time_of, -(-self._layout.rows // step), from_us) * step
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
                start, step = stop, min(2 * step, most)

    def _pieces(
        self, rows: dict[str, npt.NDArray[Any]], losses: Losses, first: int
    ) -> Iterator[Events]:
        source: Any = rows.get("records", rows)
        if self._layout.is_matrix:
            source = by_order(self._path, self._layout.name, rows["matrix"], self._order)
        elif self._layout.t_offset and not self._adds_later:
            offset = np.asarray(self._layout.t_offset)
            source = rows | {"t": shifted(rows["t"], offset)}
        for events in pieces_of(source, self._options, losses, first):
            if self._layout.t_offset and self._adds_later:
                events["t"] += self._layout.t_offset
            yield events

    def _sources(self, file: Any) -> dict[str, _Source]:
        layout = self._layout
        return {
            role: _Source(self._path, role, file[name], layout)
            for role, name in layout.datasets.items()
        }

    @contextmanager
    def _open(self) -> Iterator[Any]:
        try:
            file = h5py.File(self._path, "r", rdcc_nbytes=0)  # a step takes whole chunks, once
        except OSError as error:
            if error.errno:  # the file system's, not the format's
                raise
            raise _why_not(self._path, error) from error
        with file:
            yield file


class _Source:
    """One dataset of a stream by rows."""

    def __init__(self, path: Path, role: str, dataset: Any, layout: _Layout) -> None:
        self.rows_per_chunk: int = max(dataset.chunks) if dataset.chunks else 1
        self._path, self._dataset, self._transposed = path, dataset, layout.transposed
        self._has_time = role not in ("x", "y", "p")
        self._shape = dataset.shape
        self._is_column = len(self._shape) > 1 and not layout.is_matrix  # as in MATLAB 7.3

    def row(self, number: int) -> npt.NDArray[Any]:
        """One event, for its time alone: 0 where none is."""
        if self._has_time:
            return self.rows(number, number + 1)
        return np.zeros(1, self._dataset.dtype)

    def rows(self, start: int, stop: int) -> npt.NDArray[Any]:
        """Events from `start` to `stop`."""
        try:
            return self._values(start, stop)
        except (OSError, RuntimeError, ValueError) as error:
            fault = f"{self._dataset.name}: {error}"
            raise CorruptFile(self._path, self._place_of(start), fault) from error

    def _values(self, start: int, stop: int) -> npt.NDArray[Any]:
        values: npt.NDArray[Any]
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


# ---- where the events are ------------------------------------------------------------------------


@dataclass(frozen=True)
class _Layout:
    """One stream of events: `datasets` are its columns by role, or one dataset under ``""``."""

    name: str
    datasets: Mapping[str, str]
    rows: int
    t_offset: int = 0
    transposed: bool = False  # a matrix whose columns are the events

    @property
    def is_matrix(self) -> bool:
        """Whether the columns have no names."""
        return "matrix" in self.datasets


def _find_layouts(path: Path, file: Any, options: Options) -> dict[str, _Layout]:
    """Every stream of events in the file, by its path in it.

    A matrix whose name says nothing counts where the user names it, or there is nothing else.
    """
    found: dict[str, _Layout] = {}
    others: dict[str, _Layout] = {}
    links: list[str] = []
    for group, name, datasets in _groups(path, file, links):
        layout = _columns(path, name, group, datasets)
        if layout is not None:
            found[layout.name] = layout
            continue
        for key, dataset in datasets.items():
            layout = _records_or_matrix(f"{name}/{key}".lstrip("/"), dataset, options.order)
            if layout is None:
                continue
            says_so = not layout.is_matrix or "event" in layout.name.lower()
            (found if says_so else others)[layout.name] = layout
    if not found or options.stream is not None:
        found |= others
    if not found:
        led = f"; links that lead elsewhere are not followed: {', '.join(links)}" if links else ""
        raise UnsupportedFormat(
            f"{path}: no events among {', '.join(_listing(file)) or 'no datasets'}: needed "
            f"are datasets t, x, y, p in one group, records with such fields, or a matrix "
            f"of {len(options.order or 'txyp')} columns, as order names them{led}"
        )
    return found


def _usable(path: Path, dataset: Any) -> None:
    """Refuse what lies in other files, what needs a missing filter and what cannot be so large."""
    filters = dataset.id.get_create_plist()
    is_virtual = filters.get_layout() == h5py.h5d.VIRTUAL
    if filters.get_external_count() or (
        is_virtual and any(part.file_name != "." for part in dataset.virtual_sources())
    ):
        raise UnsupportedFormat(
            f"{path}: {dataset.name} lies in another file, which is never followed"
        )
    if dataset.dtype.hasobject or dataset.dtype.itemsize > _MAX_BYTES:
        raise UnsupportedFormat(f"{path}: {dataset.name} holds {dataset.dtype}, no events")
    stored = dataset.id.get_storage_size()
    if dataset.size > 1 and not stored and not is_virtual:
        raise CorruptFile(path, 0, f"{dataset.name}: {dataset.size} values promised, none stored")
    chunk = math.prod(dataset.chunks or ()) * dataset.dtype.itemsize
    promised = int(dataset.size) * dataset.dtype.itemsize
    refuse_bomb(path, 0, dataset.name, max(promised, chunk), min(stored, path.stat().st_size))
    for i in range(filters.get_nfilters()):
        code, _, _, name = filters.get_filter(i)
        if not h5py.h5z.filter_avail(code):
            _find_filter(path, dataset.name, code, name.decode("ascii", "replace"))


def _sensor_of(file: Any, dataset: Any) -> tuple[int | None, int | None]:
    """Width and height, where attributes or datasets beside the events state them."""
    for place in (dataset, dataset.parent, file):
        size = size_of(place.attrs, place.attrs.get)
        if size == (None, None) and place is not dataset:
            size = size_of(place, partial(_small, place))
        if size != (None, None):
            return size
    return None, None


def _small(group: Any, key: str) -> Any:
    """Return the few values of a dataset; None if there is none."""
    if not _is_dataset(group, key) or group[key].size > _FEW or group[key].external:
        return None
    return group[key][()]


def _groups(path: Path, file: Any, links: list[str]) -> Iterator[tuple[Any, str, dict[str, Any]]]:
    """Every group with its datasets once, however the links run in circles."""
    seen: set[Any] = set()
    waiting = [(file["/"], "")]
    objects = 0
    while waiting:
        group, name = waiting.pop()
        address = h5py.h5o.get_info(group.id).addr
        if address in seen:
            continue
        seen.add(address)
        datasets: dict[str, Any] = {}
        for key in sorted(group, reverse=True):
            objects += 1
            if objects > _MAX_OBJECTS:
                raise UnsupportedFormat(f"{path}: more than {_MAX_OBJECTS} objects")
            inner = f"{name}/{key}".lstrip("/")
            if not isinstance(group.get(key, getlink=True), h5py.HardLink):
                links.append(inner)
            elif isinstance(item := group[key], h5py.Group):
                waiting.append((item, inner))
            elif isinstance(item, h5py.Dataset):
                datasets[key] = item
        yield group, name, datasets


def _is_dataset(group: Any, key: str) -> bool:
    hard = isinstance(group.get(key, getlink=True), h5py.HardLink)
    return hard and group.get(key, getclass=True) is h5py.Dataset


def _columns(path: Path, name: str, group: Any, datasets: Mapping[str, Any]) -> _Layout | None:
    if (names := names_by_role(datasets)) is None:
        return None
    columns = {role: datasets[key] for role, key in names.items()}
    shapes = {role: column.shape for role, column in columns.items()}
    if any(sum(side != 1 for side in shape) > 1 or not shape for shape in shapes.values()):
        return None
    lengths = {role: int(column.size) for role, column in columns.items()}
    if len(set(lengths.values())) > 1:
        raise CorruptFile(path, 0, f"{name or '/'}: columns of different lengths: {lengths}")
    paths = {role: column.name for role, column in columns.items()}
    return _Layout(name or "/", paths, lengths["t"], _offset(path, group))


def _records_or_matrix(name: str, dataset: Any, order: str | None) -> _Layout | None:
    fields = dataset.dtype.names
    if fields is not None:
        lower = {field.lower() for field in fields}
        is_events = all(lower & set(names) for names in FIELD_NAMES.values())
        if not is_events or len(dataset.shape) != 1:
            return None
        return _Layout(name, {"records": dataset.name}, dataset.shape[0])
    rows = as_rows(dataset.shape, order) or as_rows(dataset.shape)
    if rows is None or dataset.dtype.kind not in "biuf":
        return None
    return _Layout(name, {"matrix": dataset.name}, rows[0], transposed=rows[1])


def _offset(path: Path, group: Any) -> int:
    """DSEC: times count from t_offset, a dataset or an attribute of the group or its parent."""
    for place in (group, group.parent):
        link = place.get("t_offset", getlink=True)
        if link is not None and not isinstance(link, h5py.HardLink):
            raise UnsupportedFormat(f"{path}: t_offset is a link, which is never followed")
        if link is not None:
            _usable(path, place["t_offset"])
        elif "t_offset" not in place.attrs:
            continue
        stated = _small(place, "t_offset") if link else place.attrs["t_offset"]
        offset = np.asarray(stated).reshape(-1)
        if offset.size == 1 and offset.dtype.kind in "iuf":
            us = offset[0].item()
            if abs(us) <= MAX and us == int(us):
                return int(us)
        raise CorruptFile(path, 0, f"{place.name}: t_offset: one number of us is needed")
    return 0


def _find_filter(path: Path, dataset: str, code: int, name: str) -> None:
    """Let the package hdf5plugin register its filters; say which one is missing then."""
    with suppress(ImportError):
        importlib.import_module("hdf5plugin")
    if h5py.h5z.filter_avail(code):
        return
    remedy = "pip install hdf5plugin, or set HDF5_PLUGIN_PATH to the folder of its plug-in"
    if code == _ECF:
        name = "Metavision's ECF, 0x8ECF"
        remedy = (
            "no Python package has it: set HDF5_PLUGIN_PATH to the folder of the plug-in hdf5_ecf, "
            "or convert the file with metavision_file_to_dat"
        )
    raise MissingLibrary(
        f"{path}: {dataset} is compressed with filter {code} ({name or 'no name'}): {remedy}"
    )


def _listing(file: Any) -> list[str]:
    names: list[str] = []

    def note(name: str, item: Any) -> bool | None:
        if isinstance(item, h5py.Dataset):
            names.append(f"{name} {item.shape}")
        return True if len(names) == 10 else None

    file.visititems(note)
    return names
