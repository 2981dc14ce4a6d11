"""A run as a file: written by `Run.save` and read back by `load_run`.

A ``.npz`` holds every column of `run.packages` as an array of its own, and the summary and the
latencies as texts of JSON; a ``.json`` is the summary alone. Nothing is unpickled; what the numbers
say is the user's own. Texts are only ever shown, and escaped.
"""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from asap import _checks, _core
from asap.io.errors import CorruptFile, foreign
from asap.io.writers import replacing
from asap.results.cost import Cost
from asap.results.result import SCHEMA_VERSION, Named
from asap.results.run import Ledger, Run, check_run, with_first


def check_name(path: Path) -> None:
    """Refuse a path that `Run.save` does not write to."""
    remedy = "give a name that ends in .npz (log and summary) or .json (the summary alone)"
    _checks.ending("path", path, (".npz", ".json"), remedy)


def write(run: Run, path: Path) -> None:
    """Write summary, latencies and log of a run."""
    check_run(run)
    latencies = [run.latency.state(), run.lateness.state() if run.lateness else None]
    columns: dict[str, Any] = {name: run.packages[name] for name in run.packages.dtype.names or ()}
    texts = {"summary": run.summary(), "latencies": latencies}
    told: dict[str, Any] = {
        name: np.array(json.dumps(value, allow_nan=False)) for name, value in texts.items()
    }
    with replacing(path) as opened:
        np.savez_compressed(opened, **columns, **told)


def load_run(path: str | os.PathLike[str]) -> Run:
    """Read a run that `Run.save` wrote, or the summary that ``asap run --json`` printed.

    From a ``.npz`` come log and summary; from a ``.json`` the summary alone: `packages` is empty,
    `without_log` is True, and `latency` knows the quantiles 0.5, 0.99 and 1. Scheme and algorithm
    come back as names and parameters. Nothing is unpickled.

    Parameters
    ----------
    path : path
        A ``.npz`` or ``.json`` file.

    Returns
    -------
    Run

    Raises
    ------
    ValueError
        The file holds no run, or one of another version.
    OSError
        The file cannot be read, or is a pipe, a socket or a device.

    Examples
    --------
    >>> scene = asap.synthetic.FlightOverChairs(duration_s=0.1)
    >>> run = asap.simulate(scene, cost=asap.LinearCost(100, 300), latency_ms=10)
    >>> asap.load_run(run.save("run.npz")).in_time
    1.0
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
            f"{file}: not a run that asap has saved ({' '.join(fault.split())}); "
            "make one with run.save(path) or asap run --save PATH"
        ) from error


def _from_archive(path: Path) -> Run:
    with foreign(path), path.open("rb") as opened:
        with np.load(opened, allow_pickle=False) as archive:
            found = dict(archive)
        latency, lateness = _parsed(str(found.pop("latencies")))
        summary = _parsed(str(found.pop("summary")))
    return Run(
        packages=_packages(found, summary["packages"]["count"]),
        latency=_histogram(latency),
        lateness=_histogram(lateness) if lateness else None,
        **_facts(summary),
    )


def _from_json(path: Path) -> Run:
    document = _parsed(path.read_bytes())
    facts = _facts(document)
    log = {name: document[name] for name in _LOG}
    log["estimated_cost"] = _cost(document["estimated_cost"])
    in_time = document["in_time"] or 0.0  # None: no event was received
    counts = facts["ledger"].delivered, round(in_time * facts["ledger"].received)
    both_us = (document[name] for name in ("latency_us", "pacing_us"))
    latency, lateness = (us and _SummedUp(*counts, **us) for us in both_us)
    run = Run(
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


def _packages(columns: dict[str, NDArray[Any]], count: int) -> NDArray[np.void]:
    packages = np.empty(count, _core.PACKAGE_DTYPE)
    names = packages.dtype.names or ()
    for name in (*names, "first") if "first" in columns else names:
        column, kind = columns[name], packages.dtype[name] if name in names else np.dtype("<i8")
        if column.shape != (count,) or column.dtype != kind:
            raise ValueError(f"{name} = {column.dtype}{column.shape}: not {count} of {kind}")
        if name in names:
            packages[name] = column
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


def _parsed(text: str | bytes) -> Any:
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
