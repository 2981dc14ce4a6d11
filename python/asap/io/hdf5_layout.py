"""Where an HDF5 file keeps its events: groups of columns, arrays of records, matrices.

Found by what is in the file, so that DSEC (``events/{t,x,y,p}``, ``t_offset``), Metavision
(``CD/events``), MVSEC (``davis/left/events``), M3ED (``prophesee/left/{t,x,y,p}``) and others that
are built alike need no rules of their own. Links that lead elsewhere are never followed: neither
soft nor external ones, nor storage in other files.
"""

from __future__ import annotations

import importlib
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from asap._stamps import MAX
from asap.events import FIELD_NAMES
from asap.io.columns import as_rows
from asap.io.errors import (
    CorruptFile,
    MissingLibrary,
    UnsupportedFormat,
    library,
    refuse_bomb,
)
from asap.io.reader import sensor_size

_MOST_OBJECTS = 10_000
_MOST_BYTES = 1024  # of one record
_ECF = 0x8ECF


@dataclass(frozen=True)
class Layout:
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


def find_layouts(path: Path, file: Any) -> dict[str, Layout]:
    """Every stream of events in the file, by its path in it."""
    h5py = library("h5py", "HDF5", "hdf5")
    found: dict[str, Layout] = {}
    links: list[str] = []
    for group, name in _groups(h5py, path, file, links):
        datasets = {key: group[key] for key in group if _is_dataset(h5py, group, key)}
        layout = _columns(path, name, group, datasets)
        if layout is not None:
            found[layout.name] = layout
            continue
        for key, dataset in datasets.items():
            layout = _records_or_matrix(f"{name}/{key}".lstrip("/"), dataset)
            if layout is not None:
                found[layout.name] = layout
    if not found:
        led = f"; links that lead elsewhere are not followed: {', '.join(links)}" if links else ""
        raise UnsupportedFormat(
            f"{path}: no events among {', '.join(_listing(h5py, file)) or 'no datasets'}: needed "
            f"are datasets t, x, y, p in one group, records with such fields, or (N, 4){led}"
        )
    return found


def usable(path: Path, dataset: Any) -> None:
    """Refuse what lies in other files, what needs a missing filter and what cannot be so large."""
    h5py = library("h5py", "HDF5", "hdf5")
    if dataset.external or (
        dataset.is_virtual and any(part.file_name != "." for part in dataset.virtual_sources())
    ):
        raise UnsupportedFormat(
            f"{path}: {dataset.name} lies in another file, which is never followed"
        )
    if dataset.dtype.hasobject or dataset.dtype.itemsize > _MOST_BYTES:
        raise UnsupportedFormat(f"{path}: {dataset.name} holds {dataset.dtype}, no events")
    stored = dataset.id.get_storage_size()
    if dataset.size > 1 and not stored and not dataset.is_virtual:
        raise CorruptFile(path, 0, f"{dataset.name}: {dataset.size} values promised, none stored")
    chunk = math.prod(dataset.chunks or ()) * dataset.dtype.itemsize
    promised = int(dataset.size) * dataset.dtype.itemsize
    refuse_bomb(path, 0, dataset.name, max(promised, chunk), min(stored, path.stat().st_size))
    filters = dataset.id.get_create_plist()
    for i in range(filters.get_nfilters()):
        code, _, _, name = filters.get_filter(i)
        if not h5py.h5z.filter_avail(code):
            _find_filter(h5py, path, dataset.name, code, name.decode("ascii", "replace"))


def sensor_of(file: Any, layout: Layout) -> tuple[int | None, int | None]:
    """Width and height, where attributes state them: ``geometry`` (Metavision) or both by name."""
    dataset = file[next(iter(layout.datasets.values()))]
    for place in (dataset, dataset.parent, file):
        attributes = place.attrs
        if "geometry" in attributes:
            text = attributes["geometry"]
            text = text.decode("ascii", "replace") if isinstance(text, bytes) else str(text)
            size = re.fullmatch(r"\s*(\d{1,5})x(\d{1,5})\s*", text)
            if size:
                return sensor_size(size[1], size[2])
        if "width" in attributes and "height" in attributes:
            sides = [np.asarray(attributes[side]) for side in ("width", "height")]
            if all(side.size == 1 and side.dtype.kind in "iu" for side in sides):
                return sensor_size(sides[0].item(), sides[1].item())
    return None, None


def _groups(h5py: Any, path: Path, file: Any, links: list[str]) -> Iterator[tuple[Any, str]]:
    """Every group once, however the links run in circles."""
    seen: set[Any] = set()
    waiting = [(file["/"], "")]
    objects = 0
    while waiting:
        group, name = waiting.pop()
        address = h5py.h5o.get_info(group.id).addr
        if address in seen:
            continue
        seen.add(address)
        yield group, name
        for key in sorted(group, reverse=True):
            objects += 1
            if objects > _MOST_OBJECTS:
                raise UnsupportedFormat(f"{path}: more than {_MOST_OBJECTS} objects")
            inner = f"{name}/{key}".lstrip("/")
            if not isinstance(group.get(key, getlink=True), h5py.HardLink):
                links.append(inner)
            elif group.get(key, getclass=True) is h5py.Group:
                waiting.append((group[key], inner))


def _is_dataset(h5py: Any, group: Any, key: str) -> bool:
    hard = isinstance(group.get(key, getlink=True), h5py.HardLink)
    return hard and group.get(key, getclass=True) is h5py.Dataset


def _columns(path: Path, name: str, group: Any, datasets: Mapping[str, Any]) -> Layout | None:
    columns: dict[str, Any] = {}
    for role, names in FIELD_NAMES.items():
        candidates = [key for key in datasets if key.lower() in names]
        if len(candidates) != 1:
            return None
        columns[role] = datasets[candidates[0]]
    shapes = {role: column.shape for role, column in columns.items()}
    if any(sum(side != 1 for side in shape) > 1 or not shape for shape in shapes.values()):
        return None
    lengths = {role: int(column.size) for role, column in columns.items()}
    if len(set(lengths.values())) > 1:
        raise CorruptFile(path, 0, f"{name or '/'}: columns of different lengths: {lengths}")
    paths = {role: column.name for role, column in columns.items()}
    return Layout(name or "/", paths, lengths["t"], _offset(path, group))


def _records_or_matrix(name: str, dataset: Any) -> Layout | None:
    fields = dataset.dtype.names
    if fields is not None:
        lower = {field.lower() for field in fields}
        is_events = all(lower & set(names) for names in FIELD_NAMES.values())
        if not is_events or len(dataset.shape) != 1:
            return None
        return Layout(name, {"records": dataset.name}, dataset.shape[0])
    rows = as_rows(dataset.shape)
    if rows is None or "event" not in name.lower() or dataset.dtype.kind not in "biuf":
        return None
    return Layout(name, {"matrix": dataset.name}, rows[0], transposed=rows[1])


def _offset(path: Path, group: Any) -> int:
    """DSEC: times count from t_offset, which stands beside the group."""
    h5py = library("h5py", "HDF5", "hdf5")
    for place in (group, group.parent):
        link = place.get("t_offset", getlink=True)
        if link is not None:
            if not isinstance(link, h5py.HardLink):
                raise UnsupportedFormat(f"{path}: t_offset is a link, which is never followed")
            usable(path, place["t_offset"])
            offset = place["t_offset"]
            if offset.size != 1 or offset.dtype.kind not in "iu" or abs(int(offset[()])) > MAX:
                raise CorruptFile(path, 0, f"{offset.name}: one number of us is needed")
            return int(np.asarray(offset[()]).item())
    return 0


def _find_filter(h5py: Any, path: Path, dataset: str, code: int, name: str) -> None:
    if code == _ECF:
        raise MissingLibrary(
            f"{path}: {dataset} is compressed with Metavision's ECF filter (0x8ECF), which no "
            "Python package has: set HDF5_PLUGIN_PATH to the folder of the plug-in hdf5_ecf, "
            "or convert the file with metavision_file_to_dat"
        )
    try:
        importlib.import_module("hdf5plugin")  # registers its filters
    except ImportError as error:
        raise MissingLibrary(
            f"{path}: {dataset} is compressed with filter {code} ({name or 'no name'}); "
            "the package hdf5plugin has many: pip install hdf5plugin"
        ) from error
    if not h5py.h5z.filter_avail(code):
        raise MissingLibrary(
            f"{path}: {dataset} is compressed with filter {code} ({name or 'no name'}), which "
            "hdf5plugin lacks too: set HDF5_PLUGIN_PATH to the folder of its plug-in"
        )


def _listing(h5py: Any, file: Any) -> list[str]:
    names: list[str] = []

    def note(name: str, item: Any) -> bool | None:
        if isinstance(item, h5py.Dataset):
            names.append(f"{name} {item.shape}")
        return True if len(names) == 10 else None

    file.visititems(note)
    return names
