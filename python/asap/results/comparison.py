"""Every scheme on the same events, beside the oracle; as a table, with a verdict in words."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from asap import _core, _units
from asap.results import html
from asap.results.cost import BOUND_KEPT, RATE_SHARE, Cost, keeps
from asap.results.result import SCHEMA_VERSION, Named, Result, data_frame, share, without_nan
from asap.results.run import LONG_GAP, Run, sensor

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_WIDE = 100
_ALL = 0.9995  # times the oracle, likewise
_SHORT = 10.0  # latency bounds
_MAX_NAMES = 5
_READ = (
    "Read score and p99/L together: a scheme that discards most events has a low latency, and one "
    "that keeps all of them may process them too late."
)

COLUMNS = {
    "scheme": "the rule that decides size and gamma of a package",
    "score": "events processed in time, as a share of those that the oracle processes in time",
    "kept": "events processed, in time or late, as a share of all events received",
    "p50": "median latency of the processed events",
    "p99": "99 % of them had at most this latency",
    "p99/L": f"the same in latency bounds: up to {BOUND_KEPT} the bound is kept",
    "max": "the largest latency",
    "gap": "the longest time between two processed events of which one between was lost",
    "overflow": "events lost because the buffer was full, of all",
    "pkg/s": "packages per second",
    "busy": "share of the time that the algorithm worked",
}
"""Every column in words."""


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
            overflow=share(run.ledger.overflow, received),
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
        Best score first, then the lower p99 latency.
    oracle : float
        OB(L), a bound in fluid: no policy that does not know the random part of the cost finishes
        more events in time, whatever it discards and however well it knows the arrivals.
    runs : dict of str to Run
        By label, in the order of the rows.
    source : dict
        The source: path, format, width, height, events, duration_s (after `speed`).
    name : str
        The recording or profile.
    cost : LinearCost
        The simulated algorithm.
    latency_ms : float
        The bound of all.
    execution : str
        How the algorithm, also the oracle's, took its packages: "whole" or "anytime".
    speed : float
        Factor by which time was compressed.
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
        return data_frame([asdict(row) for row in self.rows])

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

    def plot(self) -> Figure:
        """Draw latency and kept share over time, a row of the figure for each scheme."""
        from asap import plots

        return plots.comparison_figure(self)

    def report(self, path: str | os.PathLike[str]) -> Path:
        """Write one self-contained HTML page and return its path; needs the extra `report`."""
        from asap.results import page

        return page.write_comparison(self, path)

    def _repr_html_(self) -> str:
        rows = [_cells(row, self.latency_ms) for row in self.rows]
        return (
            html.heading(_title(self), _subtitle(self))
            + html.table(tuple(COLUMNS), [*rows, _oracle_row(self)])
            + html.verdict(verdict(self))
        )

    def __str__(self) -> str:
        """Write a text table of at most 100 columns, with a verdict."""
        rows = [_cells(row, self.latency_ms) for row in self.rows]
        (head, *schemes, oracle), rule = _units.aligned([tuple(COLUMNS), *rows, _oracle_row(self)])
        above = [_title(self), *_units.wrapped(_subtitle(self), _WIDE), ""]
        below = ["", *_units.wrapped(verdict(self), _WIDE)]
        return "\n".join([*above, head, rule, *schemes, rule, oracle, *below])

    def _reached(self, events: float) -> dict[str, float | None]:
        return {"events": events, "in_time": events / self.received if self.received else None}

    def __repr__(self) -> str:
        scores = ", ".join(f"{row.label} {_units.score(row.score)}" for row in self.rows)
        return f"<Comparison: {self.name}, {self.latency_ms:g} ms: {scores}>"


# ---- as text ------------------------------------------------------------------------------------


def _title(comparison: Comparison) -> str:
    """Name a comparison by its recording or profile."""
    count = len(comparison.rows)
    schemes = "one scheme" if count == 1 else f"{count} schemes"
    return f"{comparison.name}: {schemes} beside the oracle"


def _subtitle(comparison: Comparison) -> str:
    """Say what was compared: recording, algorithm, bound."""
    source, cost = comparison.source, comparison.cost.parameters
    speed = f" ({comparison.speed:g} times as fast as recorded)" if comparison.speed != 1 else ""
    noise = f", noise {cost['noise']:g}" if cost["noise"] else ""
    drift = ", drifting" if "drift" in cost else ""
    outages = ", with outages" if "outages_ms" in cost else ""
    whole = ", package by package as a whole" if comparison.execution == "whole" else ""
    return (
        f"{sensor(source)}, {_units.count(source['events'])} events in "
        f"{source['duration_s']:.3g} s{speed}; "
        f"an algorithm of {_units.duration(cost['alpha_us'])} per package + "
        f"{_units.duration(cost['beta_ns'] / 1e3)} per event{noise}{drift}{outages}{whole}; "
        f"latency bound L = {_units.duration(comparison.latency_ms * 1e3)}; virtual time"
        f"{_rate_bounds(comparison)}"
    )


def _rate_bounds(comparison: Comparison) -> str:
    """Say the rate bound of each scheme that has one, and whether the cost can do it."""
    cost = comparison.cost.parameters
    most_hz = Cost(cost["alpha_us"], cost["beta_ns"]).throughput_hz(comparison.latency_ms * 1e3)
    return "".join(
        f"; {label} with the rate bound a = {_units.rate(a_hz)}"
        + f", {100 * RATE_SHARE:.0f} % of what this cost can do within L"
        * math.isclose(a_hz, RATE_SHARE * most_hz)
        for label, run in comparison.runs.items()
        if (a_hz := run.scheme.parameters.get("rate_bound"))
    )


def _cells(row: Row, latency_ms: float) -> tuple[str, ...]:
    """Write a row, one text for each of `COLUMNS`."""
    latencies = [_units.duration(value_us) for value_us in (row.p50_us, row.p99_us, row.max_us)]
    latencies.insert(2, _ratio(row.p99_us / (latency_ms * 1e3)))
    return (
        row.label,
        _units.score(row.score),
        _units.share(row.kept),
        *(latencies if row.kept > 0 else "----"),
        _units.duration(row.gap_us) if row.gap_us else "-",
        _units.share(row.overflow) if row.overflow else "-",
        _units.count(row.packages_per_s),
        f"{100 * row.cpu:.0f} %",
    )


def _oracle_row(comparison: Comparison) -> tuple[str, ...]:
    """Write the oracle's line: one text for each of `COLUMNS`, empty where there is no number."""
    name = "oracle (whole)" if comparison.execution == "whole" else "oracle"
    score = "1.000" if comparison.oracle > 0 else "-"
    reached = _units.share(comparison.oracle / comparison.received) if comparison.received else "-"
    return name, score, reached, *[""] * (len(COLUMNS) - 3)


def verdict(comparison: Comparison) -> str:
    """Say which schemes keep the bound, and which of them processes the most in time.

    A scheme that processes more in time than `Deadline`, the default, is named with its figure,
    whether it keeps the bound or not.
    """
    bound_us = comparison.latency_ms * 1e3
    bound = _units.duration(bound_us)
    if comparison.received == 0:
        return "No event was received."
    if comparison.oracle <= 0:
        return (
            f"No scheme can process an event within {bound}: one package takes longer. Use a "
            "longer bound or a faster algorithm."
        )
    keepers = [row for row in comparison.rows if row.kept and keeps(row.p99_us, bound_us)]
    if not keepers:
        none = f"No scheme keeps the bound of {bound} for 99 % of its events."
        return " ".join([none, *_more_than_default(comparison), _READ])
    late = {row.label: row.late / (row.kept * comparison.received) for row in keepers if row.late}
    never = [row.label for row in keepers if not row.late]
    sentences = [_best(keepers, bound_us), *_more_than_default(comparison)]
    if never:
        sentences.append(f"No event is late with {_listed(never)}.")
    if late:
        most = math.ceil(1000 * max(late.values())) / 10
        sentences.append(f"Up to {most:g} % of the events are late with {_listed([*late])}.")
    gaps = [row.label for row in keepers if row.gap_us > LONG_GAP * bound_us]
    if gaps:
        sentences.append(f"Gaps of more than L/2 occur with {_listed(gaps)}.")
    if comparison.oracle >= _ALL * comparison.received:
        sentences.append("The events do not overload this algorithm; a larger speed does.")
    sentences.append(_READ)
    lasted = comparison.source["duration_s"] * 1e6 / bound_us
    if lasted < _SHORT:
        sentences.append(
            f"The events last for only {lasted:.2g} L, so start and end weigh heavily in the score."
        )
    return " ".join(sentences)


def _best(keepers: Sequence[Row], bound_us: float) -> str:
    best, bound = keepers[0], _units.duration(bound_us)
    p99 = f"{_ratio(best.p99_us / bound_us)} L"
    perfect = [row for row in keepers if row.score >= _ALL]
    if len(perfect) > 1:
        return (
            f"{len(perfect)} schemes process as many events within {bound} as the oracle; "
            f"{best.label} has the lowest p99, {p99}."
        )
    share = "as many as the oracle" if perfect else f"{_units.share(best.score)} of the oracle's"
    return (
        f"{best.label} processes the most events within {bound} of all schemes that keep the "
        f"bound: {share}, p99 {p99}."
    )


def _more_than_default(comparison: Comparison) -> Iterator[str]:
    """Name the scheme that processes the most in time, if that is more than `Deadline` does."""
    most = max(comparison.rows, key=lambda row: row.score)
    default = next((row for row in comparison.rows if row.scheme == "deadline"), most)
    if round(most.score, 3) > round(default.score, 3):
        bound_us = comparison.latency_ms * 1e3
        is_late = not keeps(most.p99_us, bound_us)
        p99 = f", but its p99 is {_ratio(most.p99_us / bound_us)} L" * is_late
        yield (
            f"{most.label} processes more in time than {default.label}: {most.score:.3f} of the "
            f"oracle's events instead of {default.score:.3f}{p99}."
        )


def _ratio(value: float) -> str:
    return f"{value:.2f}" if value < 9.995 else f"{value:,.3g}" if value < 1000 else f"{value:,.0f}"


def _listed(names: Sequence[str]) -> str:
    if len(names) > _MAX_NAMES:
        names = [*names[: _MAX_NAMES - 2], f"{len(names) - _MAX_NAMES + 2} others"]
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
