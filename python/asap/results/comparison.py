"""Every scheme on the same events, beside the oracle."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from asap import _core, _units
from asap.results.result import SCHEMA_VERSION, Named, Result, data_frame, share, without_nan
from asap.results.run import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
        from asap.results import figures

        return figures.comparison_figure(self)

    def report(self, path: str | os.PathLike[str]) -> Path:
        """Write one self-contained HTML page and return its path; needs the extra `report`."""
        from asap.results import page

        return page.write_comparison(self, path)

    def _repr_html_(self) -> str:
        from asap.results import comparison_text

        return comparison_text.comparison_html(self)

    def __str__(self) -> str:
        from asap.results import comparison_text

        return comparison_text.format_comparison(self)

    def _reached(self, events: float) -> dict[str, float | None]:
        return {"events": events, "in_time": events / self.received if self.received else None}

    def __repr__(self) -> str:
        scores = ", ".join(f"{row.label} {_units.score(row.score)}" for row in self.rows)
        return f"<Comparison: {self.name}, {self.latency_ms:g} ms: {scores}>"
