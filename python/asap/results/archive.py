"""The archive of a run: its summary, latencies and log as one ``.npz``.

Every column of `run.packages` is an array of its own, as NumPy reads it. A column that follows from
the others to the last bit is left out.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from asap import _checks, _core
from asap.io.numpy_files import Archive
from asap.io.writers import write_archive

SUMMARY, LATENCIES = "summary.json", "latencies.json"

_FIRST = "first"  # with keep_mask=True alone
_RANDOM = ("event_rate.npy",)  # to pack it takes a third of the time and saves a fifth of it

Columns = Mapping[str, NDArray[Any]]


def _span(rows: Columns) -> NDArray[Any]:
    return np.asarray(rows["t_last"] - rows["t_first"])


def _ns(column: NDArray[Any]) -> NDArray[Any]:
    return np.asarray(np.rint(column * 1e3))


# As C++'s RunLog has them, at speed 1 and without a filter in front.
_FORMULAS: dict[str, Callable[[Columns], NDArray[Any]]] = {
    "index": lambda rows: np.arange(rows["size"].size),
    "gamma": lambda rows: rows["size"] / rows["offered"],
    "rate": lambda rows: rows["size"] * 1e6 / np.maximum(_span(rows), 1),
    "margin_us": lambda rows: (_ns(rows["processing_us"]) - _span(rows) * 1e3) * 1e-3,
    "latency_max_us": lambda rows: (
        (_ns(rows["start_us"]) + _ns(rows["processing_us"]) - rows["t_first"] * 1e3) * 1e-3
    ),
}


def check_name(path: Path) -> None:
    """Refuse a path that `Run.save` does not write to."""
    remedy = "give a name that ends in .npz (log and summary) or .json (the summary alone)"
    _checks.ending("path", path, (".npz", ".json"), remedy)


def write(
    path: Path, summary: dict[str, Any], latencies: list[Any], packages: NDArray[np.void]
) -> None:
    """Write summary, latencies and log of a run."""
    members: dict[str, Any] = {
        SUMMARY: json.dumps(summary, allow_nan=False).encode(),
        LATENCIES: json.dumps(latencies, allow_nan=False).encode(),
    }
    names = packages.dtype.names or ()
    rows = {name: np.ascontiguousarray(packages[name]) for name in names}
    for name, column in rows.items():
        if name not in _FORMULAS or (_follows(name, rows).view("i8") != column.view("i8")).any():
            members[f"{name}.npy"] = column
    write_archive(path, members, stored=_RANDOM)


def columns(archive: Archive, count: int) -> dict[str, NDArray[Any]]:
    """Return every column of so many packages, those that were left out too."""
    dtype = _core.PACKAGE_DTYPE
    kinds = {name: dtype[name] for name in dtype.names or ()} | {_FIRST: np.dtype("<i8")}
    rows = {
        name: archive.column(f"{name}.npy", kind, count)
        for name, kind in kinds.items()
        if f"{name}.npy" in archive or name not in {*_FORMULAS, _FIRST}
    }
    return rows | {name: _follows(name, rows) for name in _FORMULAS if name not in rows}


def _follows(name: str, rows: Columns) -> NDArray[Any]:
    with np.errstate(all="ignore"):  # the reader checks the numbers of a damaged file
        return _FORMULAS[name](rows)
