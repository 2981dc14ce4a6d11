"""Runs read back from the JSON file of `Run.save`: another program may have changed it since.

Whatever is used later is checked here, once: numbers are finite and within reach, columns are
equally long, names are text. What a file can say beyond that is only ever shown, and escaped.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from asap import _core, checks
from asap.experiment.cost import Cost
from asap.experiment.result import LEDGER_FIELDS, SCHEMA_VERSION, Ledger, Named, Run, with_first

__all__ = ["load_run"]

_MOST = 2**53  # events, us
_FARTHEST = 1e18  # of other numbers
_LEAST_GAMMA = 1e-15  # events are counted back from it
_DEEPEST = 16  # objects inside objects
_SIGNED = ("start_us", "t_first", "t_last", "margin_us")


def load_run(path: str | os.PathLike[str]) -> Run:
    """Read a run that `Run.save` wrote.

    Raises
    ------
    ValueError
        The file holds no run, or one of another schema.
    OSError
        The file cannot be read, or is a pipe, a socket or a device.
    """
    file = checks.folder_or_file("path", path)
    try:
        checks.regular_file(file)
        text = file.read_text(encoding="utf-8")
        document = json.loads(text, parse_constant=_no_number)
        if _depth(document) > _DEEPEST:
            raise ValueError("objects inside objects inside objects")
        return _from_document(document)
    except (KeyError, TypeError, ValueError, OverflowError, RecursionError) as error:
        raise ValueError(
            f"{os.fspath(path)}: not a run that asap has saved ({error}); "
            "make one with run.save(path) or asap run --save PATH"
        ) from error


def _from_document(document: Any) -> Run:
    if _object("file", document)["schema_version"] != SCHEMA_VERSION:
        raise ValueError(f"schema_version {document['schema_version']} is not {SCHEMA_VERSION}")
    source = _object("source", document["source"])
    lateness, learned = document["lateness_histogram"], document.get("learned_cost")
    return Run(
        packages=_packages(_object("rows", document["rows"])),
        ledger=Ledger(_counts("ledger", document["ledger"], LEDGER_FIELDS)),
        latency=_histogram("latency_histogram", document["latency_histogram"]),
        rejected=_counts("rejected", document["rejected"]),
        scheme=_named("scheme", document["scheme"], _parameter),
        algorithm=_named("algorithm", document["algorithm"]),
        mode=_text("mode", document["mode"]),
        latency_bound_us=_real("latency_bound_us", document["latency_bound_us"], least=1e-3),
        source={
            "path": _optional("path", source["path"], _text),
            "format": _text("format", source["format"]),
            "width": _optional("width", source["width"], _count),
            "height": _optional("height", source["height"], _count),
            "events": _count("events", source["events"]),
            "duration_s": _real("duration_s", source["duration_s"]),
        },
        speed=_real("speed", document["speed"], least=1e-6),
        clock_resets=_count("clock_resets", document["clock_resets"]),
        lateness=_histogram("lateness_histogram", lateness) if lateness else None,
        learned=Cost(*(_real(name, learned[name]) for name in ("alpha_us", "beta_ns")))
        if learned
        else None,
    )


def _packages(rows: dict[str, Any]) -> NDArray[np.void]:
    packages = np.zeros(len(rows["index"]), _core.PACKAGE_DTYPE)
    if "first" in rows:
        packages = with_first(packages, np.zeros(packages.size, np.int64)).copy()
    for name in packages.dtype.names or ():
        column = np.asarray(rows[name])
        is_whole = packages.dtype[name].kind == "i"
        if column.shape != packages.shape or not (
            column.size == 0 or column.dtype.kind in ("iu" if is_whole else "iuf")
        ):
            raise ValueError(f"rows: {name} does not hold {packages.size} numbers")
        high = _MOST if is_whole else 1.0 if name == "gamma" else _FARTHEST
        low = -high if name in _SIGNED else _LEAST_GAMMA if name == "gamma" else 0
        if not ((column >= low) & (column <= high)).all():
            raise ValueError(f"rows: {name} holds a number out of reach")
        packages[name] = column
    return packages


def _histogram(name: str, state: Any) -> _core.LatencyHistogram:
    *scalars, bins = state
    bins = [(_count(name, bin), _count(name, count)) for bin, count in bins]
    total = sum(count for _, count in bins)
    bound, largest, within, low, high = (_whole(name, scalar) for scalar in scalars)
    if min(largest, within, low, high) < 0 or not within <= total <= _MOST:
        raise ValueError(f"{name}: counts that cannot be")
    return _core.LatencyHistogram.restored((bound, largest, within, low, high, bins))


def _counts(name: str, value: Any, known: tuple[str, ...] | None = None) -> dict[str, int]:
    counts = _object(name, value)
    return {key: _count(f"{name}.{key}", counts[key]) for key in known or counts}


def _named(
    name: str, value: Any, check: Callable[[str, Any], Any] = lambda _name, value: value
) -> Named:
    parameters = dict(_object(name, value))
    own_name = _text(f"{name}.name", parameters.pop("name"))
    return Named(own_name, {key: check(key, inner) for key, inner in parameters.items()})


def _parameter(name: str, value: Any) -> Any:
    return value if value is None else _real(name, value, least=-_FARTHEST)


def _real(name: str, value: Any, *, least: float = 0.0) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise TypeError(f"{name} is no number")
    if not least <= value <= _FARTHEST:
        raise ValueError(f"{name} is out of reach")
    return value


def _whole(name: str, value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise TypeError(f"{name} is no whole number")
    return value


def _count(name: str, value: Any) -> int:
    if not 0 <= _whole(name, value) <= _MOST:
        raise ValueError(f"{name} is out of reach")
    return int(value)


def _text(name: str, value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{name} is no text")
    return value


def _optional(name: str, value: Any, check: Callable[[str, Any], Any]) -> Any:
    return None if value is None else check(name, value)


def _object(name: str, value: Any) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise TypeError(f"{name} is no object")
    return value


def _no_number(name: str) -> None:
    raise ValueError(f"{name} is no number")


def _depth(value: Any) -> int:
    depth, level = 0, [value]
    while level and depth <= _DEEPEST:
        depth += 1
        inner = [list(one.values()) if isinstance(one, dict) else one for one in level]
        level = [
            item
            for items in inner
            if isinstance(items, list)
            for item in items
            if isinstance(item, (dict, list))
        ]
    return depth
