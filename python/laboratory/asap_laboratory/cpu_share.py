"""The knob of a board with other work: processor share against latency on the flight scene.

`Deadline` limits its share by `overhead` and `min_interval_ms`. Here both are swept, in virtual
time. Its table and its figure stand in ``notebooks/board.md``.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from asap import _core, plots
from asap.events import Events
from asap.experiment import simulate
from asap.synthetic import FlightOverChairs
from asap_laboratory.page import Row, Rows, Tables, over_seeds
from asap_laboratory.study import Batch, Study

LATENCY_MS = 10.0
ALPHA_US, BETA_NS = 300.0, 200.0
USUAL_OVERHEAD = 0.25

SETTINGS: tuple[dict[str, Any], ...] = (
    *({"overhead": share, "min_interval_ms": 0.0} for share in (0.8, 0.5, 0.25, 0.15, 0.1)),
    *(
        {"overhead": USUAL_OVERHEAD, "min_interval_ms": interval}
        for interval in (2.0, 3.0, 4.0, 5.0)
    ),
)
_FIGURES = ("cpu", "packages_per_s", "p50", "p99", "max", "in_time")


@dataclass(frozen=True)
class FlightCase:
    """One flight under every setting."""

    seed: int
    duration_s: float = 4.0

    def weight(self) -> float:
        """Seconds, by the million."""
        return 1e6 * self.duration_s

    def measure(self) -> Rows:
        """Run it."""
        events = FlightOverChairs(duration_s=self.duration_s, seed=self.seed).events()
        return [{**setting, **self._under(setting, events)} for setting in SETTINGS]

    def _under(self, setting: dict[str, Any], events: Events) -> Row:
        scheme = _core.Deadline(latency_ms=LATENCY_MS, **setting)
        run = simulate(events, cost=_core.LinearCost(ALPHA_US, BETA_NS), scheme=scheme)
        busy_us = float(run.packages["processing_us"].sum())
        return {
            "cpu": busy_us / (1e6 * self.duration_s),
            "packages_per_s": run.packages.size / self.duration_s,
            "p50": run.latency.quantile(0.5) / 1e3,
            "p99": run.latency.quantile(0.99) / 1e3,
            "max": run.latency.max / 1e3,
            "in_time": run.in_time,
        }


def _batches(form: str) -> Generator[Batch, Rows, None]:
    yield Batch([FlightCase(seed) for seed in range(20)])


def _summary(rows: Rows) -> Tables:
    return {"cpu_share": over_seeds(rows, ("overhead", "min_interval_ms"), _FIGURES)}


def _figures(tables: Tables) -> Mapping[str, Any]:
    import matplotlib

    rows = tables["cpu_share"]
    with matplotlib.rc_context(plots.STYLE):
        page = plots.NotebookFigure(figsize=(4.8, 3.0), layout="constrained")
        axes = page.subplots()
        by_overhead = [row for row in rows if row["min_interval_ms"] == 0]
        by_interval = [row for row in rows if row["overhead"] == USUAL_OVERHEAD]
        for name, colour, side, some in (
            ("overhead", plots.BLUE, "left", by_overhead),
            ("min_interval_ms", plots.VERMILION, "right", by_interval),
        ):
            places = [(100 * row["cpu"], row["p50"]) for row in some]
            axes.plot(*zip(*places, strict=True), marker="o", color=colour, label=name)
            for row, place in zip(some, places, strict=True):
                axes.annotate(
                    f"{row[name]:g}" if row[name] else "",
                    place,
                    xytext=(6 if side == "left" else -6, 3),
                    textcoords="offset points",
                    horizontalalignment=side,
                    color=colour,
                )
        axes.set_xlabel("processor share of the algorithm [%]")
        axes.set_ylabel("median latency [ms]")
        axes.set_ylim(bottom=0)
        axes.legend(title="Deadline, 10 ms")
    return {"cpu_share": page}


COLUMNS = {
    "overhead": "`overhead`",
    "min_interval_ms": "`min_interval_ms`",
    "share": "processor share",
    "packages_per_s": "packages per s",
    "latency": "latency p50 / p99 / max, ms",
    "in_time": "in time",
}
CPU_SHARE = Study(
    name="cpu_share",
    command="asap-study --cpu-share",
    template=Path(__file__).with_suffix(".md"),
    batches=_batches,
    summary=_summary,
    tables=("cpu_share",),
    cells={
        "share": lambda row: f"{row['cpu']:.1%}".replace("%", " %"),
        "packages_per_s": lambda row: f"{row['packages_per_s']:.0f}",
        "latency": lambda row: " / ".join(f"{row[name]:.2f}" for name in ("p50", "p99", "max")),
        "in_time": lambda row: f"{row['in_time']:.4f}",
    },
    figures=_figures,
    facts=lambda tables: {"columns": COLUMNS},
    shown=lambda tables, writer: writer.listing(tables["cpu_share"], COLUMNS),
)
