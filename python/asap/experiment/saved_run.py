"""Runs read back from a file of `Run.save`: another program may have changed it since.

Whatever is used later is checked here, once: numbers are finite and within reach, columns are
equally long, names are text. What a file can say beyond that is only ever shown, and escaped.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from asap import _checks, _core
from asap.io import CorruptFile
from asap.io.numpy_files import Archive
from asap.results import Ledger, Named, Run
from asap.results import archive as archives
from asap.results.cost import Cost
from asap.results.data import LEDGER_FIELDS, SCHEMA_VERSION, with_first

_MOST = 2**53  # events, us
_FARTHEST = 1e18  # of other numbers
_LEAST_GAMMA = 1e-15  # events are counted back from it
_DEEPEST = 16  # objects inside objects
_SIGNED = ("start_us", "t_first", "t_last", "margin_us")
_LONGEST_SUMMARY = 1 << 24  # bytes


def load_run(path: str | os.PathLike[str]) -> Run:
    """Read a run that `Run.save` wrote, or the summary that ``asap run --json`` printed.

    From a ``.npz`` come log and summary; from a ``.json`` the summary alone: `packages` is empty,
    `without_log` is True, and `latency` knows the quantiles 0.5, 0.99 and 1. Scheme and algorithm
    come back as names and parameters. Nothing is unpickled, and sizes are checked before memory is
    taken.

    Raises
    ------
    ValueError
        The file holds no run, or one of another version.
    OSError
        The file cannot be read, or is a pipe, a socket or a device.
    """
    file = _checks.folder_or_file("path", path)
    try:
        _checks.regular_file(file)
        with file.open("rb") as opened:
            is_archive = opened.read(2) == b"PK"
        return _from_archive(file) if is_archive else _from_json(file)
    except (KeyError, TypeError, ValueError, OverflowError, RecursionError) as error:
        fault = error.fault if isinstance(error, CorruptFile) else str(error)
        raise ValueError(
            f"{os.fspath(path)}: not a run that asap has saved ({' '.join(fault.split())}); "
            "make one with run.save(path) or asap run --save PATH"
        ) from error


def _from_archive(file: Path) -> Run:
    archive = Archive(file)
    summary = _parsed(archive.read(archives.SUMMARY, _LONGEST_SUMMARY))
    count = _count("count", _object("packages", summary["packages"])["count"])
    latencies = _parsed(archive.read(archives.LATENCIES, _LONGEST_SUMMARY))
    latency, lateness = latencies
    return Run(
        packages=_packages(archives.columns(archive, count)),
        latency=_histogram("latency_histogram", latency),
        lateness=_histogram("lateness_histogram", lateness) if lateness else None,
        **_facts(summary),
    )


def _from_json(file: Path) -> Run:
    if (size := file.stat().st_size) > _LONGEST_SUMMARY:
        raise ValueError(f"size = {size} bytes: a summary takes less than {_LONGEST_SUMMARY}")
    return _from_summary(_parsed(file.read_bytes()))


def _parsed(text: bytes) -> dict[str, Any]:
    document = json.loads(text, parse_constant=_no_number)
    if _depth(document) > _DEEPEST:
        raise ValueError("objects inside objects inside objects")
    return document  # type: ignore[no-any-return]


def _from_summary(document: Mapping[str, Any]) -> Run:
    facts = _facts(document)
    ledger: Ledger = facts["ledger"]
    in_time = _real("in_time", document["in_time"], most=1)
    counts = ledger.delivered, round(in_time * ledger.received)
    latency_us, pacing_us = (document[name] for name in ("latency_us", "pacing_us"))
    run = Run(
        packages=np.zeros(0, _core.PACKAGE_DTYPE),
        latency=_summed_up("latency_us", {"mean": 0, **_object("latency_us", latency_us)}, counts),
        lateness=_summed_up("pacing_us", {"mean": 0, **pacing_us}, counts) if pacing_us else None,
        **facts,
    )
    packages, gamma = (_object(name, document[name]) for name in ("packages", "gamma"))
    if _count("count", packages["count"]) == 0:
        return run
    run.__dict__["summed_up"] = {
        "bound_needed_us": _optional("bound_needed_us", document["bound_needed_us"], _real),
        "estimated_cost": _optional("estimated_cost", document.get("estimated_cost"), _cost),
        "packages": {
            name: check(name, packages[name])
            for name, check in (
                ("count", _count),
                ("per_s", _real),
                ("size_mean", _real),
                ("size_max", _count),
            )
        },
        "gamma": {name: _real(name, gamma[name], most=1) for name in ("mean", "min")},
        "cpu": _real("cpu", document["cpu"]),
    }
    return run


@dataclass(frozen=True)
class _SummedUp:
    """The latencies that a summary holds, us."""

    count: int
    within_bound: int
    mean: float
    p50: float
    p99: float
    max: float

    def quantile(self, q: float) -> float:
        """Return one of the three that are known."""
        known = {0.5: self.p50, 0.99: self.p99, 1.0: self.max}
        remedy = "a summary holds 0.5, 0.99 and 1; save the run with run.save('run.npz')"
        _checks.require(q in known, "q", q, remedy)
        return known[q]


def _summed_up(name: str, us: Mapping[str, Any], counts: tuple[int, int]) -> _core.LatencyHistogram:
    found = (_real(f"{name}.{key}", us[key]) for key in ("mean", "p50", "p99", "max"))
    return cast("_core.LatencyHistogram", _SummedUp(*counts, *found))


def _facts(document: Mapping[str, Any]) -> dict[str, Any]:
    """Check what every form says of a run, its log and its latencies aside."""
    version = _object("file", document)["schema_version"]
    if version != SCHEMA_VERSION:
        writer = _checks.named("version", document.get("version"), "use the asap-events of then")
        raise ValueError(
            _checks.named("schema_version", version, f"this asap reads {SCHEMA_VERSION}; {writer}")
        )
    source = _object("source", document["source"])
    return {
        "ledger": Ledger(**_counts("ledger", document["ledger"], LEDGER_FIELDS)),
        "rejected": _counts("rejected", document["rejected"]),
        "scheme": _named("scheme", document["scheme"], _parameter),
        "algorithm": _named("algorithm", document["algorithm"]),
        "mode": _text("mode", document["mode"]),
        "latency_bound_us": _real("latency_bound_us", document["latency_bound_us"], least=1e-3),
        "source": {
            "path": _optional("path", source["path"], _text),
            "format": _text("format", source["format"]),
            "width": _optional("width", source["width"], _count),
            "height": _optional("height", source["height"], _count),
            "events": _count("events", source["events"]),
            "duration_s": _real("duration_s", source["duration_s"]),
            **{
                name: _counts(name, source[name], ("marks", "packets"))
                for name in ("upstream_lost",)
                if name in source
            },
        },
        "speed": _real("speed", document["speed"], least=1e-6),
        "clock_resets": _count("clock_resets", document["clock_resets"]),
        "gap_us": _optional("gap_us", document.get("gap_us"), _count),
        "learned": _optional("learned_cost", document.get("learned_cost"), _cost),
        "opaque": document.get("opaque") is True,
    }


def _cost(name: str, value: Any) -> Cost:
    cost = _object(name, value)
    return Cost(
        _real(f"{name}.alpha_us", cost["alpha_us"]),
        _real(f"{name}.beta_ns", cost["beta_ns"]),
        _real(f"{name}.noise", cost.get("noise", 0.0)),
        _optional(f"{name}.one_size", cost.get("one_size"), _count),
    )


def _packages(rows: Mapping[str, Any]) -> NDArray[np.void]:
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
        if not (good := (column >= low) & (column <= high)).all():
            row = int(good.argmin())
            raise ValueError(
                f"rows: {name} holds a number out of reach: {name}[{row}] = {column[row]}"
            )
        packages[name] = column
    packages.flags.writeable = False
    return packages


def _histogram(name: str, state: Any) -> _core.LatencyHistogram:
    *scalars, bins = state
    bins = [(_count(name, bin), _count(name, count)) for bin, count in bins]
    total = sum(count for _, count in bins)
    bound, largest, within, low, high = (_whole(name, scalar) for scalar in scalars)
    if min(largest, within, low, high) < 0 or not within <= total <= _MOST:
        raise ValueError(f"{name}: counts that cannot be")
    return _core.LatencyHistogram((bound, largest, within, low, high, bins))


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
    if name == "prefer":  # a choice, by its name
        return _text(name, value)
    return value if value is None else _real(name, value, least=-_FARTHEST)


def _real(name: str, value: Any, *, least: float = 0.0, most: float = _FARTHEST) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise TypeError(_checks.named(name, value, "no number"))
    if not least <= value <= most:
        raise ValueError(_checks.named(name, value, f"out of reach, {least:g} to {most:g}"))
    return value


def _whole(name: str, value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise TypeError(_checks.named(name, value, "no whole number"))
    return value


def _count(name: str, value: Any) -> int:
    if not 0 <= _whole(name, value) <= _MOST:
        raise ValueError(_checks.named(name, value, f"out of reach, 0 to {_MOST}"))
    return int(value)


def _text(name: str, value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(_checks.named(name, value, "no text"))
    return value


def _optional(name: str, value: Any, check: Callable[[str, Any], Any]) -> Any:
    return None if value is None else check(name, value)


def _object(name: str, value: Any) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise TypeError(_checks.named(name, value, "no object"))
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
