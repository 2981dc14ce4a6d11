"""What a run has left behind."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from asap import _checks, _core
from asap.results.cost import Cost, bound_needed_us, fit, keeps
from asap.results.result import (
    SCHEMA_VERSION,
    Named,
    Result,
    can_be_pickled,
    data_frame,
    share,
    without_nan,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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


@dataclass(frozen=True, eq=False, repr=False)
class Run(Result):
    """Result of a run. It always pickles; an algorithm that cannot is replaced by None.

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
        The source: path, format, width, height, events (all that were received, bad ones too) and
        duration_s, from the first good one to the last.
    gap_us : int or None
        Longest time between two delivered events in a row of which at least one between was lost
        (discarded, stale or overflow), us; the first and the last event received count as
        delivered. It is of the timestamps divided by `speed`, not of processing times: 0 where no
        event was lost, however long the camera was silent. None in a run that an earlier version
        saved.
    clock_resets : int
        How often the sensor's clock jumped back by 1 s or more; time then continued 1 us later.
    lateness : LatencyHistogram or None
        In real time: how late the paced producer pushed, us, which is this machine's own jitter.
    slots : ndarray or None
        In virtual time: one row per 1 ms of timestamps that holds an event: slot (ms),
        received, delivered (events), latency_max_us. Not saved.
    kept_mask : ndarray of bool, shape (events,), or None
        With keep_mask=True: whether the algorithm got each event of the source;
        ``events[run.kept_mask]`` are the delivered ones, in order. Where the reader of a file has
        dropped some, the events are those that `load` gives. The first of equal events counts as
        kept. None where `before` changes events, too. Not saved.
    learned : Cost or None
        The cost that the scheme had learned by the end; None where it learns none.
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
        return share(self.ledger.delivered, self.ledger.received)

    @property
    def in_time(self) -> float:
        """Delivered within the bound / received; nan of nothing."""
        return share(self.latency.within_bound, self.ledger.received)

    @property
    def bound_kept(self) -> bool:
        """Whether no event was delivered later than 1.01 times the bound."""
        return keeps(self.latency.max, self.latency_bound_us)

    def to_pandas(self) -> Any:
        """Return `packages` as a ``pandas.DataFrame``, a row for each package."""
        check_run(self)
        return data_frame({name: self.packages[name] for name in self.packages.dtype.names or ()})

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

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write a file and return its path: ``.npz`` holds log and summary, ``.json`` the summary.

        `asap.load_run` and ``asap report`` read both. Only the ``.npz`` brings back the packages,
        and with them the curves and the verdict.
        """
        from asap.results import saved

        file = _checks.new_file("path", path)
        saved.check_name(file)
        _checks.other_file("path", file, self.source["path"])
        if file.suffix.lower() == ".json":
            return super().save(file)
        saved.write(self, file)
        return file

    def plot(self) -> Figure:
        """Draw the paper's figure: package size, R, gamma, margin and latency over time."""
        from asap.results import figures

        return figures.figure(self)

    def report(self, path: str | os.PathLike[str]) -> Path:
        """Write one self-contained HTML page and return its path; needs the extra `report`."""
        from asap.results import page

        return page.write_runs(self, path)

    def animate(self, path: str | os.PathLike[str]) -> Path:
        """Write events and clusters over time as ``.gif`` or ``.mp4`` and return its path.

        In real time, of a run whose algorithm was an `asap.Tracks`. Needs the extra `report`, and
        for MP4 the program ffmpeg.
        """
        from asap.results import animation

        return animation.write(self, path)

    def _repr_html_(self) -> str:
        from asap.results import run_text

        return run_text.run_html(self)

    def __str__(self) -> str:
        from asap.results import run_text

        return run_text.format_run(self)

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


def _thinned(packages: NDArray[np.void]) -> int:
    """Events that came to the gamma filter: without those that a filter in front had dropped."""
    return int(np.rint(packages["size"] / packages["gamma"]).sum())


def _busy_share(packages: NDArray[np.void], speed: float) -> float:
    if packages.size == 0:
        return 0.0
    first, last = packages[0], packages[-1]
    elapsed_us = (last["start_us"] - first["start_us"]) / speed + last["processing_us"]
    return float(packages["processing_us"].sum() / elapsed_us) if elapsed_us > 0 else 0.0
