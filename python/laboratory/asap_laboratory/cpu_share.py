"""The knob of a board with other work: processor share against latency on the flight scene.

`Deadline` limits its share by `overhead` and `min_interval_ms`. Here both are swept, in virtual
time. ``python -m asap_laboratory.cpu_share DIR`` writes ``cpu_share.md`` and ``cpu_share.svg``,
which needs matplotlib.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean

from asap import _core, plots
from asap.events import Events
from asap.experiment import Run, simulate
from asap.synthetic import FlightOverChairs
from asap_laboratory.page import markdown

LATENCY_MS = 10.0
ALPHA_US, BETA_NS = 300.0, 200.0
SEEDS = tuple(range(20))


@dataclass(frozen=True)
class Setting:
    """The two parameters of `Deadline`."""

    overhead: float = 0.25
    min_interval_ms: float = 0.0


SETTINGS = (
    *(Setting(overhead=share) for share in (0.8, 0.5, 0.25, 0.15, 0.1)),
    *(Setting(min_interval_ms=interval) for interval in (2.0, 3.0, 4.0, 5.0)),
)


@dataclass(frozen=True)
class Row:
    """What a setting gives: means over the flights, latencies in ms."""

    setting: Setting
    cpu: float
    packages_per_s: float
    p50: float
    p99: float
    max: float
    in_time: float


def measure(
    settings: Sequence[Setting] = SETTINGS,
    *,
    seeds: Sequence[int] = SEEDS,
    duration_s: float = 4.0,
) -> list[Row]:
    """Simulate one flight per seed under every setting.

    Parameters
    ----------
    settings : sequence of Setting
        What is compared.
    seeds : sequence of int
        Of the flights.
    duration_s : float
        Of each flight.

    Returns
    -------
    list of Row
        One for each setting. `cpu` is the time in the algorithm over the duration.
    """
    found: dict[Setting, list[Row]] = {setting: [] for setting in settings}
    for seed in seeds:
        events = FlightOverChairs(duration_s=duration_s, seed=seed).events()
        for setting in settings:
            found[setting].append(_flown(events, setting, duration_s))
    names = ("cpu", "packages_per_s", "p50", "p99", "max", "in_time")
    return [
        Row(setting, **{name: fmean(getattr(row, name) for row in rows) for name in names})
        for setting, rows in found.items()
    ]


def _flown(events: Events, setting: Setting, duration_s: float) -> Row:
    run = simulate(
        events,
        cost=_core.LinearCost(ALPHA_US, BETA_NS),
        scheme=_core.Deadline(
            latency_ms=LATENCY_MS,
            overhead=setting.overhead,
            min_interval_ms=setting.min_interval_ms,
        ),
    )
    busy_s = float(run.packages["processing_us"].sum()) / 1e6
    return figures(setting, run, busy_s, duration_s)


def figures(setting: Setting, run: Run, busy_s: float, duration_s: float) -> Row:
    """Return what a run gave under a setting."""
    return Row(
        setting,
        cpu=busy_s / duration_s,
        packages_per_s=run.packages.size / duration_s,
        p50=run.latency.quantile(0.5) / 1e3,
        p99=run.latency.quantile(0.99) / 1e3,
        max=run.latency.max / 1e3,
        in_time=run.in_time,
    )


def table(rows: Sequence[Row]) -> str:
    """Write the rows as a Markdown table."""
    head = (
        "`overhead`",
        "`min_interval_ms`",
        "processor share",
        "packages per s",
        "latency p50 / p99 / max, ms",
        "in time",
    )
    return markdown(head, [_cells(row) for row in rows])


def _cells(row: Row) -> tuple[str, ...]:
    return (
        f"{row.setting.overhead:g}",
        f"{row.setting.min_interval_ms:g}",
        f"{row.cpu:.1%}".replace("%", " %"),
        f"{row.packages_per_s:.0f}",
        f"{row.p50:.2f} / {row.p99:.2f} / {row.max:.2f}",
        f"{row.in_time:.4f}",
    )


def draw(rows: Sequence[Row]) -> plots.NotebookFigure:
    """Draw the median latency over the processor share, a line for each of the two parameters."""
    import matplotlib

    with matplotlib.rc_context(plots.STYLE):
        page = plots.NotebookFigure(figsize=(4.8, 3.0), layout="constrained")
        axes = page.subplots()
        by_overhead = [row for row in rows if row.setting.min_interval_ms == 0]
        by_interval = [row for row in rows if row.setting.overhead == Setting.overhead]
        for name, colour, side, some in (
            ("overhead", plots.BLUE, "left", by_overhead),
            ("min_interval_ms", plots.VERMILION, "right", by_interval),
        ):
            shares, latencies = [100 * row.cpu for row in some], [row.p50 for row in some]
            axes.plot(shares, latencies, marker="o", color=colour, label=name)
            for row in some:
                value = getattr(row.setting, name)
                axes.annotate(
                    f"{value:g}" if value else "",
                    (100 * row.cpu, row.p50),
                    xytext=(6 if side == "left" else -6, 3),
                    textcoords="offset points",
                    horizontalalignment=side,
                    color=colour,
                )
        axes.set_xlabel("processor share of the algorithm [%]")
        axes.set_ylabel("median latency [ms]")
        axes.set_ylim(bottom=0)
        axes.legend(title="Deadline, 10 ms")
    return page


def main(words: Sequence[str]) -> int:
    """Measure, write the table and the figure into the folder; the exit code."""
    if len(words) != 1:
        print("usage: python -m asap_laboratory.cpu_share DIR", file=sys.stderr)
        return 2
    rows = measure()
    folder = Path(words[0])
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "cpu_share.md").write_text(table(rows) + "\n", encoding="utf-8")
    (folder / "cpu_share.svg").write_text(plots.svg(draw(rows)), encoding="utf-8")
    print(table(rows))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
