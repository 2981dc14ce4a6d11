"""What a run has left behind, and how it is shown as text."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from asap import _checks, _core, _units
from asap.results import html
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

_WIDTH = 78
LONG_GAP = 0.5  # times the bound


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
LEDGER_WORDS = {
    "received": "handed to ASAP",
    "rejected": "bad data, such as times that go back",
    "filtered": "taken out by the filter in front",
    "discarded": "thinned out by gamma, at random: a choice",
    "stale": "thrown away as too old for the bound",
    "overflow": "did not fit into the buffer: a failure",
    "pending": "still waiting at the end",
    "delivered": "processed by the algorithm",
}
"""Every entry of the ledger in words, in the order in which an event may leave."""


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
        cost = fit(packages, self.learned, self.execution)
        return {
            "bound_needed_us": bound_needed_us(cost, self.latency_bound_us, self.latency.max),
            "estimated_cost": cost,
            **package_figures(
                int(packages.size),
                self.source["duration_s"] / self.speed,
                int(packages["size"].sum()),
                int(packages["size"].max(initial=0)),
                _thinned(packages),
                float(packages["gamma"].min(initial=1.0)),
            ),
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
        from asap import plots

        return plots.figure(self)

    def report(self, path: str | os.PathLike[str]) -> Path:
        """Write one self-contained HTML page and return its path; needs the extra `report`."""
        from asap.results import page

        return page.write_runs(self, path)

    def animate(self, path: str | os.PathLike[str]) -> Path:
        """Write events and clusters over time as ``.gif`` or ``.mp4`` and return its path.

        In real time, of a run whose algorithm was an `asap.Tracks`. Needs the extra `report`, and
        for MP4 the program ffmpeg.
        """
        from asap.viewer import animation

        return animation.write(self, path)

    def _repr_html_(self) -> str:
        from asap.results.diagnosis import verdict

        summary, reasons = self.summary(), _units.reasons(self.rejected)
        ledger = [
            (*cells, f"{words}: {reasons}" if cells[0] == "rejected" and reasons else words)
            for *cells, words in _ledger_rows(self.ledger)
        ]
        return (
            html.heading(run_title(summary), run_subtitle(summary))
            + html.table((), run_figures(self, summary).items())
            + html.table(("", "events", "share", ""), ledger)
            + html.verdict(verdict(self))
        )

    def __str__(self) -> str:
        """Write a short text table of at most 78 columns that ends with the verdict."""
        from asap.results.diagnosis import verdict

        summary = self.summary()
        return "\n".join(
            [
                run_title(summary),
                *_units.wrapped(run_subtitle(summary), _WIDTH),
                "",
                *(f"  {name:<11}{value}" for name, value in run_figures(self, summary).items()),
                "",
                format_ledger(self.ledger, self.rejected),
                "",
                *_units.wrapped(verdict(self), _WIDTH),
            ]
        )

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


def package_figures(
    count: int, elapsed_s: float, size: int, size_max: int, thinned: int, gamma_min: float
) -> dict[str, Any]:
    """Sum packages up: how many, their events, and what came to gamma and was kept."""
    return {
        "packages": {
            "count": count,
            "per_s": count / elapsed_s if elapsed_s > 0 else 0.0,
            "size_mean": size / count if count else 0.0,
            "size_max": size_max,
        },
        "gamma": {"mean": size / thinned if thinned else 1.0, "min": gamma_min},
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


# ---- as text ------------------------------------------------------------------------------------


def run_figures(run: Run, summary: Mapping[str, Any]) -> dict[str, str]:
    """Write what a run came to, by name."""
    latency, packages, gamma = summary["latency_us"], summary["packages"], summary["gamma"]
    bound = _units.duration(run.latency_bound_us)
    rows = [
        ("kept", _units.share(run.kept)),
        ("in time", f"{_units.share(run.in_time)} within {bound}"),
        (
            "latency",
            f"p50 {_units.duration(latency['p50'])}, p99 {_units.duration(latency['p99'])}, "
            f"max {_units.duration(latency['max'])}"
            if run.ledger.delivered
            else "-",
        ),
        (
            "packages",
            f"{_units.count(packages['count'])}, {_units.count(packages['per_s'])} per s; "
            f"size mean {_units.count(packages['size_mean'])}, "
            f"max {_units.count(packages['size_max'])}",
        ),
        ("gap", _run_gap(summary["gap_us"])),
        ("gamma", f"mean {gamma['mean']:.3f}, min {gamma['min']:.3f}; seed {summary['seed']}"),
        ("busy", f"{_units.share(summary['cpu'])} of the time in the algorithm"),
    ]
    cost = summary["estimated_cost"] and Cost(**summary["estimated_cost"])
    if cost and cost.one_size is None and cost.alpha_us > 0:
        both_us = cost.least_bound_us, 100 * cost.alpha_us  # 10 us: the shortest bound there is
        least, most = (_units.duration(max(us, 10)) for us in both_us)
        rows.append(
            (
                "bounds",
                f"at least {least} at this cost; from {most} on nearly all that its speed allows",
            )
        )
    if pacing := summary["pacing_us"]:
        late = ", ".join(f"{q} {_units.duration(pacing[q])}" for q in ("p50", "p99", "max"))
        rows.append(("pace", f"{late}: by so much the replay itself was late"))
    lost = summary["source"].get("upstream_lost", {})
    if any(lost.values()):
        rows.append(
            ("driver", f"lost {lost['marks']} marks, {lost['packets']} packets before ASAP")
        )
    if isinstance(refused := getattr(run.algorithm, "refused", 0), int) and refused:
        words = f"all slots taken, {_units.count(refused)} times no cluster could begin"
        rows.append(("clusters", f"{words}; give it more slots"))
    return dict(rows)


def _run_gap(gap_us: int | None) -> str:
    if not gap_us:
        return "none" if gap_us == 0 else "not known"
    return f"{_units.duration(gap_us)} at most without a processed event while events came"


def _ledger_rows(ledger: Mapping[str, int]) -> list[tuple[str, str, str, str]]:
    """Write where every event went: cause, events, share of all and what it means."""
    received = ledger["received"]

    def share_of(events: int) -> str:
        return _units.share(events / received) if events and received else ""

    return [
        (name, _units.count(ledger[name]), share_of(ledger[name]), words)
        for name, words in LEDGER_WORDS.items()
    ]


def format_ledger(ledger: Mapping[str, int], rejected: Mapping[str, int] | None = None) -> str:
    """Write where every event went, one line for each cause; rejected events by reason."""
    rows = _ledger_rows(ledger)
    width = max(len(count) for _, count, _, _ in rows)
    lines = [f"  {name:<11}{n:>{width}}  {share:>8}  {words}" for name, n, share, words in rows]
    if reasons := _units.reasons(rejected or {}):
        lines.insert([*LEDGER_WORDS].index("rejected") + 1, f"{'':<13}{reasons}")
    if missing := 2 * ledger["received"] - sum(ledger.values()):
        lines.append(f"  NOT BALANCED: {_units.count(missing)} events are unaccounted for")
    return "\n".join(lines)


def run_title(summary: Mapping[str, Any]) -> str:
    """Name a run by its recording (its format, where it has no path) and its scheme."""
    source = summary["source"]
    name = os.path.basename(source["path"] or "") or source["format"]
    return f"{name}: {summary['scheme']['name']}"


def run_subtitle(summary: Mapping[str, Any]) -> str:
    """Say what was run: recording, clock, algorithm and the parameters of the scheme."""
    source, scheme = summary["source"], dict(summary["scheme"])
    clock = "virtual time" if summary["mode"] == "virtual" else "real time"
    if summary["speed"] != 1:
        clock += f" at {summary['speed']:g} times the speed"
    name = scheme.pop("name")
    parameters = ", ".join(
        f"{key} {parameter_value(value)}" for key, value in scheme.items() if value is not None
    )
    return (
        f"{sensor(source)}, {_units.count(source['events'])} events in "
        f"{source['duration_s']:.3g} s, {clock}, "
        f"algorithm {summary['algorithm']['name']}, scheme {name}"
        + (f" ({parameters})" if parameters else "")
    )


def sensor(source: Mapping[str, Any]) -> str:
    """Name the sensor of a source, and which addresses could not be checked for want of it."""
    width, height = source["width"], source["height"]
    if not (width or height):
        return "sensor unknown, addresses not checked"
    unchecked = "" if width and height else f", {'y' if width else 'x'} not checked"
    return f"{width or '?'} x {height or '?'} px{unchecked}"


def parameter_value(parameter: Any) -> str:
    """Write the value of a parameter."""
    if isinstance(parameter, (int, float)) and parameter == round(parameter):
        return _units.count(parameter)
    return f"{parameter:g}" if isinstance(parameter, float) else str(parameter)
