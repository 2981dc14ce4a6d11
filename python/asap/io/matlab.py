"""MATLAB 5 to 7 files through ``scipy`` (extra ``matlab``); version 7.3 is HDF5.

Understood are columns ``t x y p`` (under any of their names) as variables or as fields of one
structure, matrices (N, 4), and event buffers [width][height][slots] of times with their polarity.
Whole times are microseconds, also where MATLAB stores them as floats, its default type.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from asap._checks import named
from asap.events.values import Columns, Events
from asap.io.columns import as_rows, by_order, file_columns, names_by_role, pieces_of
from asap.io.errors import (
    CorruptFile,
    CutFile,
    UnsupportedFormat,
    cut_file,
    foreign,
    library,
    refuse_bomb,
)
from asap.io.reader import Losses, Options, choose_stream, size_of

scipy_io = library("scipy.io", "MATLAB", "matlab")

_FEW = 16  # values, where a size is stated
_HEADER = 128
_DEEPEST = 8  # structures in structures
_BYTES = {"double": 8, "single": 4, "int8": 1, "int16": 2, "int32": 4, "int64": 8}
_NUMERIC = (*_BYTES, *(f"u{name}" for name in _BYTES if name.startswith("int")), "logical")
_BUFFER = ("eventBuffer", "polarityBuffer")


class MatlabReader:
    """The variables of a file that are events; more than one stream of them is a question."""

    format = "matlab"

    def __init__(self, path: Path, options: Options) -> None:
        self._path, self._options = path, options
        cut = _cut_at(path)
        with _read(path, cut):
            variables = scipy_io.whosmat(str(path), appendmat=False)
        self._shapes = {name: (shape, kind) for name, shape, kind in variables}
        size = path.stat().st_size
        for name, (shape, kind) in self._shapes.items():
            width = _BYTES.get(kind.removeprefix("u"), 8)
            promised = width * math.prod(map(int, shape))
            refuse_bomb(path, 0, name, promised, size)
        self.width, self.height = size_of(self._shapes, self._few)
        self._found = self._find()
        self.streams = tuple(self._found)
        if not self._found:
            if cut is not None:
                raise _nothing_left(cut)
            listed = ", ".join(f"{name} {shape} {kind}" for name, shape, kind in variables)
            raise UnsupportedFormat(
                f"{path}: no events among {listed or 'no variables'}: needed are columns t, x, y, "
                "p, as variables or as fields of one structure, or a matrix (N, 4)"
            )
        self._stream = choose_stream(path, options.stream, self.streams)
        if self._stream == _BUFFER[0] and options.order is not None:
            words = f"{_BUFFER[0]} in {path} has no columns; leave order out"
            raise ValueError(named("order", options.order, words))
        self._cut = cut

    def chunks(self, losses: Losses, from_us: int | None = None) -> Iterator[Events]:
        """Load the variables of the stream and convert them piece by piece."""
        names = self._found[self._stream]
        with _read(self._path, self._cut):
            values = self._loaded(*names)
        missing = [name for name in names if name not in values]
        if missing:
            unread = CorruptFile(self._path, 0, f"{missing[0]} cannot be read")
            raise unread if self._cut is None else _nothing_left(self._cut)
        columns = self._columns({name: values[name] for name in names})
        unit = self._options.time_unit
        t = columns["t"]
        if unit is None and t.dtype.kind == "f" and bool((t == np.floor(t)).all()):
            unit = losses.guessed_unit = "us"
        yield from pieces_of(columns, Options(None, unit), losses)
        if self._cut is not None:
            losses.truncated(self._cut.offset, self._cut.fault)

    def _loaded(self, *names: str) -> Mapping[str, Any]:
        found: Mapping[str, Any] = scipy_io.loadmat(
            str(self._path), variable_names=names, appendmat=False
        )
        return found

    def _few(self, name: str) -> Any:
        """Return the value of a variable of few numbers, if there is one."""
        shape, kind = self._shapes[name]
        if kind not in (*_NUMERIC, "char") or math.prod(map(int, shape)) > _FEW:
            return None
        with _read(self._path, None):
            value = self._loaded(name)[name]
        return str(value.item()) if value.dtype.kind == "U" else value

    def _find(self) -> dict[str, tuple[str, ...]]:
        """Variables of each stream."""
        numeric = {name: shape for name, (shape, kind) in self._shapes.items() if kind in _NUMERIC}
        found: dict[str, tuple[str, ...]] = {}
        if columns := names_by_role(numeric):
            found["variables"] = tuple(columns.values())
        if set(_BUFFER) <= numeric.keys():
            found[_BUFFER[0]] = _BUFFER
        order, stream = self._options.order, self._options.stream
        matrices = [
            name for name, shape in numeric.items() if as_rows(shape, order) or as_rows(shape)
        ]
        named = [name for name in matrices if "event" in name.lower() or name == stream]
        for name in named or (matrices if not found else []):
            found[name] = (name,)
        for name, (shape, kind) in self._shapes.items():
            if kind == "struct" and shape == (1, 1):
                with _read(self._path, None):
                    value = self._loaded(name).get(name)
                for inner, _ in _structs(name, value):
                    found[inner] = (name,)
        return found

    def _columns(self, values: Mapping[str, Any]) -> Columns:
        if self._stream == _BUFFER[0]:
            return _of_buffer(self._path, *(values[name] for name in _BUFFER))
        if self._stream != "variables":
            (value,) = values.values()
            if value.dtype.names is None:
                return self._of_matrix(value)
            values = dict(_structs(next(iter(values)), value))[self._stream]
        names = names_by_role(values) or {}
        columns = {role: np.asarray(values[name]).reshape(-1) for role, name in names.items()}
        return file_columns(self._path, columns, self._options.order)

    def _of_matrix(self, matrix: npt.NDArray[Any]) -> Columns:
        count = as_rows(matrix.shape, self._options.order) or as_rows(matrix.shape)
        rows = matrix.T if count is not None and count[1] else matrix
        return by_order(self._path, self._stream, rows, self._options.order)


def _structs(name: str, value: Any, depth: int = 0) -> Iterator[tuple[str, dict[str, Any]]]:
    """Find structures with the fields of events in a variable, by their path in it."""
    fields = getattr(getattr(value, "dtype", None), "names", None)
    if fields is None or value.size != 1 or depth > _DEEPEST:
        return
    record = value.reshape(-1)[0]
    inside = {field: record[field] for field in fields}
    if names_by_role(fields):
        yield name, inside
    for field, part in inside.items():
        yield from _structs(f"{name}.{field}", part, depth + 1)


def _of_buffer(path: Path, times: npt.NDArray[Any], polarity: npt.NDArray[Any]) -> Columns:
    """Last events of each pixel [x][y][slot], a time of 0 for none: sorted by time, stably."""
    if times.ndim != 3 or times.shape != polarity.shape:
        raise CorruptFile(path, 0, f"eventBuffer {times.shape}, polarityBuffer {polarity.shape}")
    x, y, slot = np.nonzero(times)
    t = times[x, y, slot]
    by_time = np.argsort(t, kind="stable")
    p = polarity[x, y, slot]
    return {role: c[by_time] for role, c in (("t", t), ("x", x), ("y", y), ("p", p))}


def _cut_at(path: Path) -> CorruptFile | None:
    """Find the first variable that the file's end cuts."""
    size = path.stat().st_size
    with path.open("rb") as file:
        header = file.read(_HEADER)
        if len(header) < _HEADER:
            return CorruptFile(path, size, "the file ends inside its header")
        mark = "<" if header[126:128] == b"IM" else ">"
        at = _HEADER
        while at < size:
            file.seek(at)
            tag = file.read(8)
            length = struct.unpack(f"{mark}I", tag[4:])[0] if len(tag) == 8 else 0
            if len(tag) < 8 or at + 8 + length > size:
                there = size - at
                return CorruptFile(path, at, f"{length + 8} bytes promised, {there} are there")
            at += 8 + int(length)
    return None


@contextmanager
def _read(path: Path, cut: CorruptFile | None) -> Iterator[None]:
    """Turn what scipy raises for damaged files into `CorruptFile`, of where the file was cut."""
    try:
        with foreign(path):
            yield
    except CorruptFile as error:
        if cut is None:
            raise
        raise _nothing_left(cut) from error


def _nothing_left(cut: CorruptFile) -> CutFile:
    return cut_file(cut.path, cut.offset, "MATLAB", cut.fault)
