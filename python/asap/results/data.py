"""What a run, a comparison and an inspection have found: data, and its summary as JSON.

Text, figures and pages are above, in modules of their own; `asap.results` puts them together.
"""

from __future__ import annotations

import importlib
import json
import math
import os
import pickle  # only to ask whether something can be pickled; nothing here reads one
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from asap import _checks, _core, _units
from asap.io.writers import replacing
from asap.results.cost import Cost, bound_needed_us, fit, keeps

SCHEMA_VERSION = 1


class Result:
    """A result: summed up and saved as one JSON object."""

    def summary(self) -> dict[str, Any]:
        """Return one JSON object."""
        raise NotImplementedError

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the summary as a JSON file and return its path."""
        file = _checks.new_file("path", path)
        _checks.ending("path", file, (".json",), "give a name that ends in .json")
        with replacing(file) as opened:
            opened.write(json.dumps(self.summary(), allow_nan=False).encode())
        return file


def can_be_pickled(value: Any) -> bool:
    """Return whether pickle takes it; an error of its own ``__reduce__`` is a no."""
    try:
        pickle.dumps(value)
    except Exception:
        return False
    return True


def without_nan(value: Any) -> Any:
    """Return figures as JSON holds them, in dicts and lists too: None for what is not finite."""
    if isinstance(value, dict):
        return {name: without_nan(one) for name, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [without_nan(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def flat(value: Any, name: str = "") -> dict[str, Any]:
    """Flatten dicts in dicts: their names are joined by dots."""
    if not isinstance(value, Mapping):
        return {name: value}
    found: dict[str, Any] = {}
    for key, inner in value.items():
        found |= flat(inner, f"{name}.{key}" if name else str(key))
    return found


def table(runs: Iterable[Any]) -> list[dict[str, Any]]:
    """Return a flat row for each run: what `summary` holds, as ``"latency_us.p99"``.

    ``pandas.DataFrame``, ``polars.DataFrame`` and ``csv.DictWriter`` take it.

    Parameters
    ----------
    runs : iterable of Run
        Of `run`, `simulate`, `map` or `load_run`; inspections too.
    """
    if isinstance(runs, (Result, Mapping)) or not isinstance(runs, Iterable):
        raise TypeError(_checks.named("runs", runs, "give a list of runs"))
    listed = list(runs)
    for run in listed:
        if not hasattr(run, "summary"):
            raise TypeError(_checks.named("runs", run, "give runs; leave out those that failed"))
    return [flat(run.summary()) for run in listed]


def _data_frame(columns: Mapping[str, Any] | list[dict[str, Any]]) -> Any:
    return importlib.import_module("pandas").DataFrame(columns)


# ---- a run --------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False, kw_only=True)
class Ledger(Mapping[str, int]):
    """Where every event went, in events; attributes and mapping keys.

    received = rejected + filtered + discarded (gamma) + stale + overflow + delivered + pending.
    """

    received: int = 0
    rejected: int = 0
    filtered: int = 0
    discarded: int = 0
    stale: int = 0
    overflow: int = 0
    delivered: int = 0
    pending: int = 0

    @classmethod
    def of(cls, native: _core.Ledger) -> Ledger:
        """Make it of the extension's."""
        return cls(**{name: getattr(native, name) for name in LEDGER_FIELDS})

    def __getitem__(self, name: str) -> int:
        if name not in LEDGER_FIELDS:
            raise KeyError(name)
        count: int = getattr(self, name)
        return count

    def __iter__(self) -> Iterator[str]:
        return iter(LEDGER_FIELDS)

    def __len__(self) -> int:
        return len(LEDGER_FIELDS)

    @property
    def balanced(self) -> bool:
        """Whether received equals the sum of the others."""
        return 2 * self.received == sum(self.values())


LEDGER_FIELDS = tuple(field.name for field in fields(Ledger))


@dataclass(frozen=True)
class Named:
    """A scheme or an algorithm as a saved run knows it: by name and parameters."""

    name: str
    parameters: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, thing: Any) -> Named:
        """Describe a live object."""
        # A user's own algorithm may have methods of these names, as a torch.nn.Module has.
        names = getattr(thing, "name", None), getattr(thing, "__name__", None), type(thing).__name__
        parameters = getattr(thing, "parameters", None)
        return cls(
            next(name for name in names if name and isinstance(name, str)),
            _plain(parameters) if isinstance(parameters, Mapping) else {},
        )

    def as_json(self) -> dict[str, Any]:
        """Flatten to one JSON object."""
        first = {"name": self.name}
        return first | self.parameters | first  # a parameter may be called so too


@dataclass(frozen=True, eq=False, repr=False)
class Run(Result):
    """What a run has left behind. It always pickles; an algorithm that cannot is replaced by None.

    Attributes
    ----------
    packages : ndarray
        One row per package: index, start_us, processing_us, t_first, t_last, offered, size, gamma,
        event_rate, rate, margin_us, latency_max_us, stale, overflow. With keep_mask=True also
        first: where the `offered` raw events behind the package begin in the source.
    ledger : Ledger
        Where every event went.
    latency : LatencyHistogram
        Latencies of delivered events, us: .mean .max .count .quantile(q).
    rejected : dict
        Rejected events by reason.
    scheme, algorithm
        The objects of the run, with their state; of a loaded run their names and parameters.
    mode : str
        "virtual" (simulate) or "real" (run).
    latency_bound_us : float
        The bound in force.
    source : dict
        What was read: path, format, width, height, events (all that were received, bad ones too)
        and duration_s, from the first good one to the last.
    gap_us : int or None
        Longest time between two delivered events in a row of which at least one between was lost
        (discarded, stale or overflow), us; the first and the last event received count as
        delivered. It is of the stamps divided by `speed`, not of processing times: 0 where no event
        was lost, however long the camera was silent. None in a run saved before there was one.
    clock_resets : int
        How often the sensor's clock jumped back by 1 s or more; time then continued 1 us later.
    lateness : LatencyHistogram or None
        In real time: how late the paced producer pushed, us, which is this machine's own jitter.
    slots : ndarray or None
        In virtual time: one row per 1 ms of stamps that holds an event: slot (ms), received,
        delivered (events), latency_max_us. Not saved.
    kept_mask : ndarray of bool, shape (events,), or None
        With keep_mask=True: of every event of the source, whether the algorithm got it;
        ``events[run.kept_mask]`` are the delivered ones, in order. Where the reader of a file has
        dropped some, the events are those that `load` gives. Of equal events the first counts as
        kept. Not saved.
    learned : Cost or None
        What the scheme had learned of the algorithm's cost by the end; None where it learns none.
    execution : str
        How the algorithm took its packages: "whole" or "anytime".
    seed : int
        Seed of the gamma filter.
    held_s : float or None
        In real time: how long the algorithm's thread was ready without a processor, s. None where
        the system does not tell.
    """

    packages: NDArray[np.void]
    ledger: Ledger
    latency: _core.LatencyHistogram
    rejected: dict[str, int]
    scheme: Any
    algorithm: Any
    mode: str
    latency_bound_us: float
    source: dict[str, Any]
    speed: float = 1.0
    clock_resets: int = 0
    gap_us: int | None = None
    lateness: _core.LatencyHistogram | None = None
    slots: NDArray[np.void] | None = None
    kept_mask: NDArray[np.bool_] | None = None
    learned: Cost | None = None
    execution: str = "anytime"
    seed: int = 0
    held_s: float | None = None

    def __post_init__(self) -> None:
        if self.learned is None and hasattr(self.scheme, "alpha_us"):
            # Now: the same scheme may learn something else in its next run.
            learned = Cost(float(self.scheme.alpha_us), float(self.scheme.beta_ns))
            object.__setattr__(self, "learned", learned)

    def __getstate__(self) -> dict[str, Any]:
        state = dict(vars(self))
        if not can_be_pickled(self.scheme):
            state["scheme"] = Named.of(self.scheme)
        if not can_be_pickled(self.algorithm):
            state |= {"algorithm": None, "left_behind": Named.of(self.algorithm)}
        return state

    @property
    def _left_behind(self) -> Named | None:
        """The algorithm of a run that was pickled without it."""
        found: Named | None = vars(self).get("left_behind")
        return found

    @property
    def without_log(self) -> bool:
        """Whether it was loaded from a summary, which has no packages."""
        return "summed_up" in vars(self)

    @property
    def kept(self) -> float:
        """Delivered / received; nan of nothing."""
        return _share(self.ledger.delivered, self.ledger.received)

    @property
    def in_time(self) -> float:
        """Delivered within the bound / received; nan of nothing."""
        return _share(self.latency.within_bound, self.ledger.received)

    @property
    def bound_kept(self) -> bool:
        """Whether no event was delivered later than 1.01 times the bound."""
        return keeps(self.latency.max, self.latency_bound_us)

    def to_pandas(self) -> Any:
        """Return `packages` as a ``pandas.DataFrame``, a row for each package."""
        check_run(self)
        return _data_frame({name: self.packages[name] for name in self.packages.dtype.names or ()})

    def summary(self) -> dict[str, Any]:
        """Sum the run up as one JSON object."""
        log = vars(self).get("summed_up") or self._sum_up_log()
        return {
            "schema_version": SCHEMA_VERSION,
            "mode": self.mode,
            "source": dict(self.source),
            "scheme": Named.of(self.scheme).as_json(),
            "algorithm": (self._left_behind or Named.of(self.algorithm)).as_json(),
            "latency_bound_us": self.latency_bound_us,
            "bound_kept": self.bound_kept,
            "bound_needed_us": log["bound_needed_us"],
            "learned_cost": self.learned
            and {name: getattr(self.learned, name) for name in ("alpha_us", "beta_ns")},
            "estimated_cost": log["estimated_cost"] and asdict(log["estimated_cost"]),
            "execution": self.execution,
            "seed": self.seed,
            "held_s": self.held_s,
            "speed": self.speed,
            "ledger": dict(self.ledger),
            "rejected": dict(self.rejected),
            "clock_resets": self.clock_resets,
            "kept": without_nan(self.kept),
            "in_time": without_nan(self.in_time),
            "latency_us": latency_us(self.latency),
            "gap_us": self.gap_us,
            **{name: log[name] for name in ("packages", "gamma", "cpu")},
            "pacing_us": None if self.lateness is None else latency_us(self.lateness),
            "version": _core.__version__,
        }

    def _sum_up_log(self) -> dict[str, Any]:
        """Return what of the summary comes from the packages."""
        packages = self.packages
        wall_s = self.source["duration_s"] / self.speed
        count = int(packages.size)
        thinned = _thinned(packages)
        cost = fit(self.packages, self.learned, self.execution)
        return {
            "bound_needed_us": bound_needed_us(cost, self.latency_bound_us, self.latency.max),
            "estimated_cost": cost,
            "packages": {
                "count": count,
                "per_s": count / wall_s if wall_s > 0 else 0.0,
                "size_mean": float(packages["size"].mean()) if count else 0.0,
                "size_max": int(packages["size"].max()) if count else 0,
            },
            "gamma": {
                "mean": int(packages["size"].sum()) / thinned if thinned else 1.0,
                "min": float(packages["gamma"].min()) if count else 1.0,
            },
            "cpu": _busy_share(packages, self.speed),
        }

    def __repr__(self) -> str:
        left = self._left_behind
        summed_up = vars(self).get("summed_up")
        count = summed_up["packages"]["count"] if summed_up else self.packages.size
        return (
            f"<Run: {self.mode} time, {Named.of(self.scheme).name}, {count} packages, "
            f"kept {self.kept:.4g}, in time {self.in_time:.4g}"
            + (f", pickled without its algorithm {left.name}" if left else "")
            + (", a summary without its packages>" if self.without_log else ">")
        )


def check_run(run: Any) -> None:
    """Refuse what is no run, and one that holds no packages since it was saved without."""
    if not hasattr(run, "packages"):
        raise TypeError(_checks.named("run", run, "give a run of asap.run or asap.simulate"))
    if getattr(run, "without_log", False):
        remedy = "a summary holds no packages; save the run with run.save('run.npz')"
        raise ValueError(_checks.named("run", run, remedy))


def latency_us(histogram: _core.LatencyHistogram) -> dict[str, float]:
    """Sum latencies up, us."""
    return {
        "mean": histogram.mean,
        "p50": histogram.quantile(0.5),
        "p99": histogram.quantile(0.99),
        "max": histogram.max,
    }


def with_first(packages: NDArray[np.void], first: NDArray[np.int64]) -> NDArray[np.void]:
    """Add the column `first` to the rows of the packages."""
    extended = np.empty(packages.shape, [*_core.PACKAGE_DTYPE.descr, ("first", "<i8")])
    for name in packages.dtype.names or ():
        extended[name] = packages[name]
    extended["first"] = first
    extended.flags.writeable = False
    return extended


def _plain(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Say them as JSON can: NumPy's numbers as Python's, NaN as None, the rest as text."""
    text = json.dumps(
        dict(parameters), default=lambda one: one.tolist() if hasattr(one, "tolist") else str(one)
    )
    plain: dict[str, Any] = json.loads(text, parse_constant=lambda _: None)
    return plain


def _share(part: int, whole: int) -> float:
    return part / whole if whole else math.nan


def _thinned(packages: NDArray[np.void]) -> int:
    """Events that came to the gamma filter: without those that a filter in front had dropped."""
    return int(np.rint(packages["size"] / packages["gamma"]).sum())


def _busy_share(packages: NDArray[np.void], speed: float) -> float:
    if packages.size == 0:
        return 0.0
    first, last = packages[0], packages[-1]
    elapsed_us = (last["start_us"] - first["start_us"]) / speed + last["processing_us"]
    return float(packages["processing_us"].sum() / elapsed_us) if elapsed_us > 0 else 0.0


# ---- a comparison -------------------------------------------------------------------------------


@dataclass(frozen=True)
class Row:
    """A scheme in numbers; latencies are of the delivered events.

    Attributes
    ----------
    label, scheme : str
        How the table calls it; the scheme's own name.
    score : float
        Events finished within the bound, as a share of those that the oracle could finish; nan
        where it could finish none, as the other shares where no event was received.
    kept, in_time : float
        Finished at all, and within the bound, as shares of the events received.
    p50_us, p99_us, max_us : float
        Latency, us.
    gap_us : int
        Longest time between two processed events of which at least one between was lost, us; see
        `Run.gap_us`.
    late : int
        Events finished after the bound, however little.
    overflow : float
        Lost because the buffer was full, as a share of the events received.
    packages_per_s : float
        Packages per second, until the last one is done.
    cpu : float
        Share of that time in which the algorithm was busy.
    """

    label: str
    scheme: str
    score: float
    kept: float
    in_time: float
    p50_us: float
    p99_us: float
    max_us: float
    gap_us: int
    overflow: float
    late: int
    packages_per_s: float
    cpu: float

    @classmethod
    def of(cls, label: str, run: Run, oracle: float) -> Row:
        """Sum up a run beside the oracle's number of events."""
        received, elapsed_s = run.ledger.received, _elapsed_s(run)
        return cls(
            label=label,
            scheme=Named.of(run.scheme).name,
            score=run.latency.within_bound / oracle if oracle > 0 else math.nan,
            kept=run.kept,
            in_time=run.in_time,
            p50_us=run.latency.quantile(0.5),
            p99_us=run.latency.quantile(0.99),
            max_us=run.latency.max,
            gap_us=run.gap_us or 0,
            overflow=_share(run.ledger.overflow, received),
            late=run.ledger.delivered - run.latency.within_bound,
            packages_per_s=run.packages.size / elapsed_s if elapsed_s > 0 else 0.0,
            cpu=float(run.packages["processing_us"].sum()) * 1e-6 / elapsed_s
            if elapsed_s > 0
            else 0.0,
        )


def _elapsed_s(run: Run) -> float:
    """Return the duration of the recording; longer where the last package ended after it."""
    if run.packages.size == 0:
        return float(run.source["duration_s"])
    first, last = run.packages[0], run.packages[-1]
    busy_us = last["start_us"] + last["processing_us"] - first["t_first"]
    return max(float(run.source["duration_s"]), float(busy_us) * 1e-6)


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Result, Mapping[str, Row]):
    """Every scheme on the same events, beside the oracle: a mapping of labels to rows.

    Attributes
    ----------
    rows : list of Row
        Best score first; of equal scores the lower p99 latency.
    oracle : float
        OB(L), a bound in fluid: no policy that does not know the random part of the cost finishes
        more events in time, whatever it discards and however well it knows the arrivals.
    runs : dict of str to Run
        By label, in the order of the rows.
    source : dict
        What was read: path, format, width, height, events, duration_s (after `speed`).
    name : str
        The recording or profile.
    cost : LinearCost
        The simulated algorithm.
    latency_ms : float
        The bound of all.
    execution : str
        How the algorithm, also the oracle's, took its packages: "whole" or "anytime".
    speed : float
        By which the stamps were compressed.
    seed : int
        Seed of the gamma filters.
    """

    rows: list[Row]
    oracle: float
    runs: Mapping[str, Run]
    source: dict[str, Any]
    name: str
    cost: _core.LinearCost
    latency_ms: float
    execution: str
    speed: float
    seed: int

    @property
    def received(self) -> int:
        """Events that reached the schemes: bad ones are not among them."""
        run = next(iter(self.runs.values()))
        return run.ledger.received - run.ledger.rejected

    def __iter__(self) -> Iterator[str]:
        return (row.label for row in self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, label: str) -> Row:
        return {row.label: row for row in self.rows}[label]

    def to_pandas(self) -> Any:
        """Return a ``pandas.DataFrame`` with a row for each scheme, the best score first."""
        return _data_frame([asdict(row) for row in self.rows])

    def summary(self) -> dict[str, Any]:
        """Sum the comparison up as one JSON object."""
        return {
            "schema_version": SCHEMA_VERSION,
            "source": dict(self.source),
            "name": self.name,
            "cost": Named.of(self.cost).as_json(),
            "latency_bound_us": self.latency_ms * 1e3,
            "execution": self.execution,
            "speed": self.speed,
            "seed": self.seed,
            "oracle": self._reached(self.oracle),
            "schemes": [
                {
                    **without_nan(asdict(row)),
                    "parameters": Named.of(self.runs[row.label].scheme).parameters,
                }
                for row in self.rows
            ],
            "version": _core.__version__,
        }

    def _reached(self, events: float) -> dict[str, float | None]:
        return {"events": events, "in_time": events / self.received if self.received else None}

    def __repr__(self) -> str:
        scores = ", ".join(f"{row.label} {_units.score(row.score)}" for row in self.rows)
        return f"<Comparison: {self.name}, {self.latency_ms:g} ms: {scores}>"


# ---- an inspection ------------------------------------------------------------------------------


OK, NOTE, WRONG = "ok", "note", "wrong"

# Times between events: 0 us, 1 us, then an octave each. No recording is longer than the last one.
BINS_FROM_US: NDArray[np.int64] = np.append(0, 1 << np.arange(54, dtype=np.int64))


@dataclass(frozen=True)
class Finding:
    """The outcome of one check.

    Attributes
    ----------
    name : str
        The check.
    count : int
        How often it was found.
    verdict : str
        ``"ok"``, ``"note"`` (worth knowing; ASAP copes) or ``"wrong"``.
    detail : str
        What was measured, in words.
    remedy : str
        What helps; empty where nothing needs help.
    event : int or None
        Number of the first such event in the source, from 0. Records that no event can hold have
        no number.
    t_us : int or None
        Its stamp as the source has it.
    byte : int or None
        Where it is in the file, if the format tells.
    """

    name: str
    count: int
    verdict: str
    detail: str
    remedy: str = ""
    event: int | None = None
    t_us: int | None = None
    byte: int | None = None


@dataclass(frozen=True, eq=False)
class Inspection(Result):
    """The findings of `check` about a recording, and what it holds.

    Rates, gaps and pixels are those of the good events. Windows are aligned to
    the first one; no more of a window counts than the recording lasts.

    Attributes
    ----------
    path : str or None
        Where the file is.
    format : str
        Format of the file, or what else the source is.
    width, height : int or None
        Size of the sensor in px.
    received, events : int
        All records, and the good ones among them.
    t_first_us : int or None
        Stamp of the first good event, as the source has it.
    duration_s : float
        From the first to the last good event, clock resets bridged.
    on_share : float
        Share of ON events.
    rate_mean_hz, rate_peak_1ms_hz, rate_peak_10ms_hz, rate_peak_100ms_hz : float
        Events per second: over all, and in the busiest window.
    longest_gap_us : int
        Longest time without an event.
    findings : dict of str to Finding
        Every check by name, in the order of the table.
    hot_pixels, busiest_pixels : ndarray, fields x, y, events
        Hot pixels, and the ten busiest ones; busiest first.
    pixel_counts : ndarray, shape (rows, columns)
        Events of each pixel; at most 4096 x 4096 of them.
    interval_counts : ndarray, shape (55,)
        Events by the time since the one before: 0 us, 1 us, 2 to 3, 4 to 7 and so on by octaves.
    rate_curve : ndarray, shape (windows, 3)
        Time in s from the first event; mean and largest 1-ms rate in ev/s. Windows of 1 ms, of more
        where a recording is longer than 16 s.
    """

    path: str | None
    format: str
    width: int | None
    height: int | None
    received: int
    events: int
    t_first_us: int | None
    duration_s: float
    on_share: float
    rate_mean_hz: float
    rate_peak_1ms_hz: float
    rate_peak_10ms_hz: float
    rate_peak_100ms_hz: float
    longest_gap_us: int
    findings: Mapping[str, Finding]
    hot_pixels: NDArray[np.void]
    busiest_pixels: NDArray[np.void]
    pixel_counts: NDArray[np.int64]
    interval_counts: NDArray[np.int64]
    rate_curve: NDArray[np.float64]

    @property
    def ok(self) -> bool:
        """Whether nothing is wrong."""
        return self.verdict != WRONG

    @property
    def verdict(self) -> str:
        """The gravest of all findings: ``"ok"``, ``"note"`` or ``"wrong"``."""
        found = {finding.verdict for finding in self.findings.values()}
        return next((verdict for verdict in (WRONG, NOTE) if verdict in found), OK)

    def summary(self) -> dict[str, Any]:
        """Return the JSON object of ``asap check --json``."""
        checks = {name: asdict(finding) for name, finding in self.findings.items()}
        for check in checks.values():
            del check["name"]
        return {
            "schema_version": SCHEMA_VERSION,
            "verdict": self.verdict,
            "source": {
                "path": self.path,
                "format": self.format,
                "width": self.width,
                "height": self.height,
                "events": self.events,
                "duration_s": self.duration_s,
            },
            "received": self.received,
            "t_first_us": self.t_first_us,
            "on_share": self.on_share,
            "rate_hz": {
                "mean": self.rate_mean_hz,
                "peak_1ms": self.rate_peak_1ms_hz,
                "peak_10ms": self.rate_peak_10ms_hz,
                "peak_100ms": self.rate_peak_100ms_hz,
            },
            "longest_gap_us": self.longest_gap_us,
            "intervals": [
                {"from_us": from_us, "events": events}
                for from_us, events in zip(
                    BINS_FROM_US.tolist(), self.interval_counts.tolist(), strict=True
                )
                if events
            ],
            "checks": checks,
            "hot_pixels": _pixels(self.hot_pixels),
            "busiest_pixels": _pixels(self.busiest_pixels),
            "version": _core.__version__,
        }

    def __repr__(self) -> str:
        name = self.path or self.format
        return f"<Inspection: {name}, {self.events} events, {self.verdict}>"


def _pixels(pixels: NDArray[np.void]) -> list[dict[str, int]]:
    names = pixels.dtype.names or ()
    return [dict(zip(names, pixel, strict=True)) for pixel in pixels.tolist()]
