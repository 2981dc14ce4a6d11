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
_SLACK_US = 100_000  # a box may be labelled so long before the first or after the last event
_CAMERAS = {"still": True, "moving": True}
_BACKGROUNDS = {"labelled": True, "unlabelled": False, "not labelled": False, "not": False}


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
        top corner, px), ``ignore.csv`` (x0, x1, y0, y1, from_us, to_us) and ``sensor.json`` (width,
        height, camera, background). Other columns are not read.

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
    boxes = _table(path, BOX_DTYPE)
    on_clock = (first_us - _SLACK_US <= boxes["t_us"]) & (boxes["t_us"] <= last_us + _SLACK_US)
    clock = f"give the clock of events.npz, {first_us} to {last_us} us"
    _require_all(on_clock, path, "t_us", boxes, clock)
    for name, size, side in (("x", "w", width), ("y", "h", height)):
        _require_all(boxes[size] > 0, path, size, boxes, "give more than 0 px")
        on_it = (boxes[name] < side) & (boxes[name] + boxes[size] > 0)
        off = f"the box lies off the sensor of {width} x {height} px; correct or remove it"
        _require_all(on_it, path, name, boxes, off)
    _, first = np.unique(boxes[["t_us", "id"]], return_index=True)
    once = np.isin(np.arange(boxes.size), first)
    _require_all(once, path, "id", boxes, "give one box per time")
    if not boxes.size:
        raise ValueError(f"{path}: no row; give at least one box")
    return np.sort(boxes, order=("t_us", "id"))


def _zones(path: Path) -> NDArray[np.void]:
    zones = _table(path, ZONE_DTYPE)
    for begin, end in (("x0", "x1"), ("y0", "y1"), ("from_us", "to_us")):
        _require_all(zones[begin] < zones[end], path, end, zones, f"give more than {begin}")
    return zones


def _table(path: Path, dtype: np.dtype[np.void]) -> NDArray[np.void]:
    """Read the columns of that names; refuse what is no finite number."""
    with path.open(newline="", encoding="utf-8-sig", errors="replace") as file:
        lines = csv.DictReader(file, skipinitialspace=True)
        rows = list(lines)
    names = dtype.names or ()
    if missing := set(names) - set(lines.fieldnames or ()):
        raise ValueError(f"{path}: no column {', '.join(sorted(missing))}; give {', '.join(names)}")
    table = np.zeros(len(rows), dtype)
    for name in names:
        kind = int if dtype[name].kind == "i" else float
        for number, row in enumerate(rows):
            try:
                table[name][number] = kind(row[name])
                good = math.isfinite(table[name][number])
            except (ValueError, TypeError, OverflowError):
                good = False
            wanted = "give a whole number" if kind is int else "give a finite number, in px"
            _require(good, path, number + 2, name, row[name], wanted)
    return table


def _require_all(
    good: NDArray[np.bool_], path: Path, field: str, rows: NDArray[np.void], remedy: str
) -> None:
    for number in np.flatnonzero(~good):
        _require(False, path, int(number) + 2, field, rows[field][number].item(), remedy)


def _require(good: bool, path: Path, row: int | None, field: str, value: Any, remedy: str) -> None:
    if not good:
        where = f"{path}: " if row is None else f"{path}: row {row}: "
        raise ValueError(where + _checks.named(field, value, remedy))
