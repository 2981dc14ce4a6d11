"""A run as a file: written by `Run.save` and read back.

A ``.npz`` holds the summary, the latencies and every column of `run.packages` as an array of its
own; a ``.json`` is the summary alone. Nothing is unpickled, sizes are checked before memory is
taken; what the numbers say is the user's own. Texts are only ever shown, and escaped.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from asap import _checks, _core
from asap.io.errors import CorruptFile
from asap.io.numpy_files import Archive
from asap.io.writers import write_archive
from asap.results.cost import Cost
from asap.results.data import SCHEMA_VERSION, Ledger, Named, Run, check_run, with_first

_SUMMARY, _LATENCIES = "summary.json", "latencies.json"
_LONGEST_SUMMARY = 1 << 24  # bytes

AnyRun = TypeVar("AnyRun", bound=Run)


def check_name(path: Path) -> None:
    """Refuse a path that `Run.save` does not write to."""
    remedy = "give a name that ends in .npz (log and summary) or .json (the summary alone)"
    _checks.ending("path", path, (".npz", ".json"), remedy)


def write(run: Run, path: Path) -> None:
    """Write summary, latencies and log of a run."""
    check_run(run)
    latencies = [run.latency.state(), run.lateness.state() if run.lateness else None]
    members: dict[str, Any] = {
        _SUMMARY: json.dumps(run.summary(), allow_nan=False).encode(),
        _LATENCIES: json.dumps(latencies, allow_nan=False).encode(),
    }
    for name in run.packages.dtype.names or ():
        members[f"{name}.npy"] = np.ascontiguousarray(run.packages[name])
    write_archive(path, members)


def read(path: Path, make: Callable[..., AnyRun]) -> AnyRun:
    """Read either form, and `make` a run of what it holds."""
    try:
        _checks.regular_file(path)
        with path.open("rb") as opened:
            is_archive = opened.read(2) == b"PK"
        return (_from_archive if is_archive else _from_json)(path, make)
    except (KeyError, TypeError, ValueError, OverflowError, RecursionError) as error:
        fault = error.fault if isinstance(error, CorruptFile) else str(error)
        raise ValueError(
            f"{path}: not a run that asap has saved ({' '.join(fault.split())}); "
            "make one with run.save(path) or asap run --save PATH"
        ) from error


def _from_archive(path: Path, make: Callable[..., AnyRun]) -> AnyRun:
    archive = Archive(path)
    summary = _parsed(archive.read(_SUMMARY, _LONGEST_SUMMARY))
    count = summary["packages"]["count"]
    latency, lateness = _parsed(archive.read(_LATENCIES, _LONGEST_SUMMARY))
    return make(
        packages=_packages(archive, count),
        latency=_histogram(latency),
        lateness=_histogram(lateness) if lateness else None,
        **_facts(summary),
    )


def _from_json(path: Path, make: Callable[..., AnyRun]) -> AnyRun:
    if (size := path.stat().st_size) > _LONGEST_SUMMARY:
        raise ValueError(f"size = {size} bytes: a summary takes less than {_LONGEST_SUMMARY}")
    document = _parsed(path.read_bytes())
    facts = _facts(document)
    log = {name: document[name] for name in _LOG}
    log["estimated_cost"] = _cost(document["estimated_cost"])
    in_time = document["in_time"] or 0.0  # None: no event was received
    counts = facts["ledger"].delivered, round(in_time * facts["ledger"].received)
    both_us = (document[name] for name in ("latency_us", "pacing_us"))
    latency, lateness = (us and _SummedUp(*counts, **us) for us in both_us)
    run = make(
        packages=np.zeros(0, _core.PACKAGE_DTYPE),
        latency=cast("_core.LatencyHistogram", latency),
        lateness=cast("_core.LatencyHistogram | None", lateness),
        **facts,
    )
    if log["packages"]["count"]:
        vars(run)["summed_up"] = log
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


def _packages(archive: Archive, count: int) -> NDArray[np.void]:
    kinds = {name: _core.PACKAGE_DTYPE[name] for name in _core.PACKAGE_DTYPE.names or ()}
    if "first" in archive:  # with keep_mask=True
        kinds["first"] = np.dtype("<i8")
    columns = {name: archive.column(name, kind, count) for name, kind in kinds.items()}
    packages = np.empty(count, _core.PACKAGE_DTYPE)
    for name in packages.dtype.names or ():
        packages[name] = columns[name]
    packages.flags.writeable = False
    return packages if "first" not in columns else with_first(packages, columns["first"])


def _histogram(state: Any) -> _core.LatencyHistogram:
    *scalars, bins = state
    return _core.LatencyHistogram((*scalars, [(bin, count) for bin, count in bins]))


# ---- the summary --------------------------------------------------------------------------------

_FACTS = (
    *("rejected", "mode", "latency_bound_us", "source", "speed", "clock_resets", "gap_us"),
    *("execution", "seed", "held_s"),
)
_LOG = ("bound_needed_us", "packages", "gamma", "cpu")


def _parsed(text: bytes) -> Any:
    return json.loads(text, parse_constant=_no_number)


def _no_number(name: str) -> None:
    raise ValueError(f"{name} is no number")


def _facts(document: Any) -> dict[str, Any]:
    """Return what both forms say of a run, its log and its latencies aside."""
    if (version := document["schema_version"]) != SCHEMA_VERSION:
        writer = _checks.named("version", document.get("version"), "use the asap-events of then")
        raise ValueError(
            _checks.named("schema_version", version, f"this asap reads {SCHEMA_VERSION}; {writer}")
        )
    return {name: document[name] for name in _FACTS} | {
        "ledger": Ledger(**document["ledger"]),
        "scheme": _named(document["scheme"]),
        "algorithm": _named(document["algorithm"]),
        "learned": _cost(document["learned_cost"]),
    }


def _named(described: dict[str, Any]) -> Named:
    parameters = dict(described)
    return Named(parameters.pop("name"), parameters)


def _cost(found: dict[str, Any] | None) -> Cost | None:
    return Cost(**found) if found else None
