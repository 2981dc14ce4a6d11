"""A run as a file: written by `Run.save`, read back and checked.

A ``.npz`` holds the summary, the latencies and every column of `run.packages` as an array of its
own; a ``.json`` is the summary alone. Another program may have changed the file: whatever is used
later is checked here, once. What a file can say beyond that is only ever shown, and escaped.
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
from asap.results.data import (
    LEDGER_FIELDS,
    SCHEMA_VERSION,
    Ledger,
    Named,
    Run,
    check_run,
    with_first,
)

_SUMMARY, _LATENCIES = "summary.json", "latencies.json"
_LONGEST_SUMMARY = 1 << 24  # bytes
_DEEPEST = 16  # objects inside objects

_MOST = 2**53  # events, us
_FARTHEST = 1e18  # the largest other number
_LEAST_GAMMA = 1e-15  # events are counted back from it
_SIGNED = ("start_us", "t_first", "t_last", "margin_us")

AnyRun = TypeVar("AnyRun", bound=Run)
Check = Callable[[str, Any], Any]  # returns the value of that name, or raises


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
    count = _count("count", _object("packages", summary["packages"])["count"])
    latency, lateness = _parsed(archive.read(_LATENCIES, _LONGEST_SUMMARY))
    return make(
        packages=_packages(archive, count),
        latency=_histogram("latency_histogram", latency),
        lateness=_histogram("lateness_histogram", lateness) if lateness else None,
        **_facts(summary),
    )


def _from_json(path: Path, make: Callable[..., AnyRun]) -> AnyRun:
    if (size := path.stat().st_size) > _LONGEST_SUMMARY:
        raise ValueError(f"size = {size} bytes: a summary takes less than {_LONGEST_SUMMARY}")
    document = _parsed(path.read_bytes())
    facts, log = _facts(document), _LOG("", document)
    in_time = log.pop("in_time") or 0.0  # None: no event was received
    counts = facts["ledger"].delivered, round(in_time * facts["ledger"].received)
    latency, lateness = (us and _SummedUp(*counts, **us) for us in map(log.pop, _HISTOGRAMS))
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
    for name, column in columns.items():
        high = 1.0 if name == "gamma" else _MOST if column.dtype.kind == "i" else _FARTHEST
        low = -high if name in _SIGNED else _LEAST_GAMMA if name == "gamma" else 0
        if not (good := (column >= low) & (column <= high)).all():
            row = int(good.argmin())
            raise ValueError(
                f"rows: {name} holds a number out of reach: {name}[{row}] = {column[row]}"
            )
    packages = np.empty(count, _core.PACKAGE_DTYPE)
    for name in packages.dtype.names or ():
        packages[name] = columns[name]
    packages.flags.writeable = False
    return packages if "first" not in columns else with_first(packages, columns["first"])


def _histogram(name: str, state: Any) -> _core.LatencyHistogram:
    *scalars, bins = state
    bins = [(_count(name, bin), _count(name, count)) for bin, count in bins]
    total = sum(count for _, count in bins)
    bound, largest, within, low, high = (_whole(name, scalar) for scalar in scalars)
    if min(largest, within, low, high) < 0 or not within <= total <= _MOST:
        raise ValueError(f"{name}: counts that cannot be")
    return _core.LatencyHistogram((bound, largest, within, low, high, bins))


# ---- the summary --------------------------------------------------------------------------------


def _parsed(text: bytes) -> Any:
    document = json.loads(text, parse_constant=_no_number)
    if _depth(document) > _DEEPEST:
        raise ValueError("objects inside objects inside objects")
    return document


def _no_number(name: str) -> None:
    raise ValueError(f"{name} is no number")


def _depth(document: Any) -> int:
    """Count the levels of objects and lists, as far as there may be."""
    depth, level = 0, [[document]]
    while level and depth <= _DEEPEST:
        depth += 1
        inner = (item for items in level for item in items)
        level = [
            list(one.values()) if isinstance(one, dict) else one
            for one in inner
            if isinstance(one, (dict, list))
        ]
    return depth


def _facts(document: Any) -> dict[str, Any]:
    """Check what both forms say of a run, its log and its latencies aside."""
    version = _object("file", document)["schema_version"]
    if version != SCHEMA_VERSION:
        writer = _checks.named("version", document.get("version"), "use the asap-events of then")
        raise ValueError(
            _checks.named("schema_version", version, f"this asap reads {SCHEMA_VERSION}; {writer}")
        )
    facts: dict[str, Any] = _FACTS("", document)
    learned = facts.pop("learned_cost")
    return facts | {"ledger": Ledger(**facts["ledger"]), "learned": learned and Cost(**learned)}


def _of_kind(kind: type | tuple[type, ...], otherwise: str) -> Check:
    def check(name: str, value: Any) -> Any:
        if isinstance(value, bool) or not isinstance(value, kind):
            raise TypeError(_checks.named(name, value, otherwise))
        return value

    return check


_number = _of_kind((int, float), "no number")
_whole = _of_kind(int, "no whole number")
_text = _of_kind(str, "no text")
_object = _of_kind(dict, "no object")


def _real(name: str, value: Any, *, least: float = 0.0, most: float = _FARTHEST) -> float:
    if not least <= _number(name, value) <= most:
        raise ValueError(_checks.named(name, value, f"out of reach, {least:g} to {most:g}"))
    real: float = value
    return real


def _count(name: str, value: Any) -> int:
    if not 0 <= _whole(name, value) <= _MOST:
        raise ValueError(_checks.named(name, value, f"out of reach, 0 to {_MOST}"))
    return int(value)


def _seed(name: str, value: Any) -> int:
    if not 0 <= _whole(name, value) < 2**64:
        raise ValueError(_checks.named(name, value, "out of reach, 0 to 2**64 - 1"))
    return int(value)


def _counts(name: str, value: Any) -> dict[str, int]:
    return {key: _count(f"{name}.{key}", count) for key, count in _object(name, value).items()}


def _scheme(name: str, value: Any) -> Named:
    named = _algorithm(name, value)
    for key, parameter in named.parameters.items():
        if key == "prefer":  # a choice, by its name
            _text(f"{name}.{key}", parameter)
        elif parameter is not None:
            _real(f"{name}.{key}", parameter, least=-_FARTHEST)
    return named


def _algorithm(name: str, value: Any) -> Named:
    parameters = dict(_object(name, value))
    return Named(_text(f"{name}.name", parameters.pop("name")), parameters)


def _or_none(check: Check) -> Check:
    return lambda name, value: None if value is None else check(name, value)


def _fields(**checks: Check) -> Check:
    """Check an object field by field; what else it holds is left out."""

    def check(name: str, value: Any) -> dict[str, Any]:
        found = _object(name, value)
        return {key: one(f"{name}.{key}".lstrip("."), found[key]) for key, one in checks.items()}

    return check


def _source(name: str, value: Any) -> dict[str, Any]:
    source: dict[str, Any] = _SOURCE(name, value)
    if "upstream_lost" in value:  # a camera's
        source["upstream_lost"] = _LOST(f"{name}.upstream_lost", value["upstream_lost"])
    return source


def _share(name: str, value: Any) -> float:
    return _real(name, value, most=1)


_SOURCE = _fields(
    path=_or_none(_text),
    format=_text,
    width=_or_none(_count),
    height=_or_none(_count),
    events=_count,
    duration_s=_real,
)
_LOST = _fields(marks=_count, packets=_count)
_FACTS = _fields(
    ledger=_fields(**dict.fromkeys(LEDGER_FIELDS, _count)),
    rejected=_counts,
    scheme=_scheme,
    algorithm=_algorithm,
    mode=_text,
    latency_bound_us=lambda name, value: _real(name, value, least=1e-3),
    source=_source,
    speed=lambda name, value: _real(name, value, least=1e-6),
    clock_resets=_count,
    gap_us=_or_none(_count),
    learned_cost=_or_none(_fields(alpha_us=_real, beta_ns=_real)),
    execution=_text,
    seed=_seed,
)
_HISTOGRAMS = ("latency_us", "pacing_us")
_LATENCY = _fields(mean=_real, p50=_real, p99=_real, max=_real)
_COST = _fields(alpha_us=_real, beta_ns=_real, noise=_real, one_size=_or_none(_count))
_LOG = _fields(
    in_time=_or_none(_share),
    latency_us=_LATENCY,
    pacing_us=_or_none(_LATENCY),
    bound_needed_us=_or_none(_real),
    estimated_cost=_or_none(lambda name, value: Cost(**_COST(name, value))),
    packages=_fields(count=_count, per_s=_real, size_mean=_real, size_max=_count),
    gamma=_fields(mean=_share, min=_share),
    cpu=_real,
)
