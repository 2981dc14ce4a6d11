"""Recordings with hand-made boxes as scenes: a folder of four files, checked row by row."""

from __future__ import annotations

import csv
import errno
import json
import math
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from asap import _checks
from asap.events import Events
from asap.io import load

BOX_DTYPE = np.dtype(
    [("t_us", "<i8"), ("id", "<i8"), *((name, "<f8") for name in ("x", "y", "w", "h"))]
)
ZONE_DTYPE = np.dtype(
    [*((name, "<f8") for name in ("x0", "x1", "y0", "y1")), ("from_us", "<i8"), ("to_us", "<i8")]
)

_FILES = ("events.npz", "truth.csv", "ignore.csv", "sensor.json")
_TRUTH = ("t_us", "id", "x", "y", "w", "h")
_NOT_READ = ("name", "cx", "cy")
_ZONES = ("x0", "x1", "y0", "y1", "from_us", "to_us")
_SLACK_US = 100_000  # a box may be labelled so long before the first or after the last event
_CAMERAS = {"still": True, "moving": True}
_BACKGROUNDS = {"labelled": True, "unlabelled": False, "not labelled": False, "not": False}

Row = tuple[int, dict[str, str]]  # its number in the file, the heading being row 1, and its cells


@dataclass(frozen=True, eq=False)
class LabelledScene:
    """A recording whose objects have boxes. Made by `labelled`; `score` judges by the boxes.

    Iterating yields the events once, whole: a source for `asap.run` and `asap.simulate`.

    Attributes
    ----------
    name : str
        Of the folder.
    width, height : int
        Of the sensor, px.
    camera : {"still", "moving"}
    background_labelled : bool
        Whether everything that moves has a box. Where not, precision is not judged.
    events : ndarray, shape (n,), EVENT_DTYPE
    boxes : ndarray, shape (rows,), BOX_DTYPE
        In time order: stamp, object, left and top edge, width, height; us and px.
    ignore : ndarray, shape (zones,), ZONE_DTYPE
        Where and when clusters without an object do not count.
    """

    name: str
    width: int
    height: int
    camera: str
    background_labelled: bool
    events: Events
    boxes: NDArray[np.void]
    ignore: NDArray[np.void]

    def __iter__(self) -> Iterator[Events]:
        yield self.events

    def __repr__(self) -> str:
        objects = np.unique(self.boxes["id"]).size
        return (
            f"<LabelledScene: {self.name}, {self.width} x {self.height} px, {self.events.size} "
            f"events, {objects} objects in {self.boxes.size} boxes>"
        )


def labelled(folder: str | os.PathLike[str]) -> LabelledScene:
    """Read a recording with boxes.

    Parameters
    ----------
    folder : path
        With ``events.npz`` (t [us], x, y, p), ``truth.csv`` (t_us, id, x, y, w, h; x, y the left
        top corner, px; name, cx and cy are allowed and not read), ``ignore.csv`` (x0, x1, y0, y1,
        from_us, to_us) and ``sensor.json`` (width, height, camera, background).

    Returns
    -------
    LabelledScene

    Raises
    ------
    FileNotFoundError
        A file is missing.
    ValueError
        A file holds something else: the message names file, row (the heading is row 1), field,
        value and remedy.
    """
    path = _checks.folder_or_file("folder", folder)
    for name in _FILES:
        if not (path / name).is_file():
            wanted = f"no such file; a labelled folder has {', '.join(_FILES)}"
            raise FileNotFoundError(errno.ENOENT, wanted, str(path / name))
    width, height, camera, background_labelled = _sensor(path / "sensor.json")
    events = _events(path / "events.npz", width, height)
    return LabelledScene(
        name=path.resolve().name,
        width=width,
        height=height,
        camera=camera,
        background_labelled=background_labelled,
        events=events,
        boxes=_boxes(path / "truth.csv", events, width, height),
        ignore=_zones(path / "ignore.csv"),
    )


def _events(path: Path, width: int, height: int) -> Events:
    try:
        events = load(path, width=width, height=height, on_bad="raise", time_unit="us")
    except ValueError as error:
        raise ValueError(error if str(path) in str(error) else f"{path}: {error}") from error
    if not events.size:
        raise ValueError(f"{path}: no event; give the recording of truth.csv")
    return events


def _sensor(path: Path) -> tuple[int, int, str, bool]:
    try:
        stated = json.loads(path.read_bytes())
    except ValueError as error:
        raise ValueError(f"{path}: {error}; give a JSON object") from error
    if not isinstance(stated, dict):
        raise ValueError(f"{path}: give a JSON object with width, height, camera, background")
    for field in ("width", "height"):
        side = stated.get(field)
        good = isinstance(side, int) and not isinstance(side, bool) and 1 <= side <= 65536
        _require(good, path, None, field, side, f"give the sensor's {field}, 1 to 65536 px")
    for field, known in (("camera", _CAMERAS), ("background", _BACKGROUNDS)):
        value = stated.get(field)
        good = isinstance(value, str) and value in known
        _require(good, path, None, field, value, f"give one of {', '.join(known)}")
    return stated["width"], stated["height"], stated["camera"], _BACKGROUNDS[stated["background"]]


def _boxes(path: Path, events: Events, width: int, height: int) -> NDArray[np.void]:
    first_us, last_us = int(events["t"][0]), int(events["t"][-1])
    clock = f"give the clock of events.npz, {first_us} to {last_us} us"
    found = []
    seen: set[tuple[int, int]] = set()
    for number, cells in _rows(path, _TRUTH, _NOT_READ):
        t_us, label = (_whole(path, number, name, cells[name]) for name in ("t_us", "id"))
        good = first_us - _SLACK_US <= t_us <= last_us + _SLACK_US
        _require(good, path, number, "t_us", t_us, clock)
        _require((t_us, label) not in seen, path, number, "id", label, "give one box per time")
        seen.add((t_us, label))
        x, y, w, h = (_real(path, number, name, cells[name]) for name in ("x", "y", "w", "h"))
        for name, side in (("w", w), ("h", h)):
            _require(side > 0, path, number, name, side, "give more than 0 px")
        for name, begin, size, side in (("x", x, w, width), ("y", y, h, height)):
            on_it = begin < side and begin + size > 0
            off = f"the box lies off the sensor of {width} x {height} px; correct or remove it"
            _require(on_it, path, number, name, begin, off)
        found.append((t_us, label, x, y, w, h))
    if not found:
        raise ValueError(f"{path}: row 2: there is none; give at least one box")
    return np.sort(np.array(found, BOX_DTYPE), order=("t_us", "id"))


def _zones(path: Path) -> NDArray[np.void]:
    found = []
    for number, cells in _rows(path, _ZONES, ()):
        edges = [_real(path, number, name, cells[name]) for name in _ZONES[:4]]
        times = [_whole(path, number, name, cells[name]) for name in _ZONES[4:]]
        _require_order(path, number, "x1", edges[0], edges[1])
        _require_order(path, number, "y1", edges[2], edges[3])
        _require_order(path, number, "to_us", times[0], times[1])
        found.append((*edges, *times))
    return np.array(found, ZONE_DTYPE)


def _require_order(path: Path, row: int, field: str, begin: float, end: float) -> None:
    _require(begin < end, path, row, field, end, f"give more than {begin}")


def _rows(path: Path, needed: tuple[str, ...], also: tuple[str, ...]) -> Iterator[Row]:
    """Yield the rows below the heading; refuse a heading or a row of other columns."""
    with path.open(newline="", encoding="utf-8-sig", errors="replace") as file:
        lines = csv.reader(file)
        heading = [name.strip() for name in next(lines, [])]
        known = set(heading) <= {*needed, *also} and len(set(heading)) == len(heading)
        remedy = f"give {', '.join(needed)}" + (f" and, at will, {', '.join(also)}" if also else "")
        good = known and set(needed) <= set(heading)
        _require(good, path, 1, "columns", ",".join(heading), remedy)
        for cells in lines:
            if not cells:
                continue
            fits = len(cells) == len(heading)
            remedy = f"give {len(heading)} values, as in the heading"
            _require(fits, path, lines.line_num, "values", ",".join(cells), remedy)
            yield lines.line_num, dict(zip(heading, cells, strict=True))


def _whole(path: Path, row: int, field: str, text: str) -> int:
    try:
        value = int(text)
    except ValueError:
        value = 1 << 63
    _require(-(1 << 63) <= value < 1 << 63, path, row, field, text, "give a whole number")
    return value


def _real(path: Path, row: int, field: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    _require(math.isfinite(value), path, row, field, text, "give a finite number, in px")
    return value


def _require(good: bool, path: Path, row: int | None, field: str, value: Any, remedy: str) -> None:
    if not good:
        where = f"{path}: " if row is None else f"{path}: row {row}: "
        raise ValueError(where + _checks.named(field, value, remedy))
