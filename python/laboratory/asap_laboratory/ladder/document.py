"""The ladder as tables and a document."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from asap_laboratory import writer
from asap_laboratory.ladder.cases import REAL_LATENCY_MS
from asap_laboratory.ladder.results import Figures, LadderRow, Mean, OverLatency, Told
from asap_laboratory.ladder.rungs import LATENCY_MS, SLOWDOWN
from asap_laboratory.tables import markdown

_OPENING = """\
What is left of each algorithm when the stream overloads it? Every algorithm of the library, over
three decades of cost, gets the same stream on a computer that can process all of it or a
five-hundredth. `Deadline` knows the latency bound L and nothing else; the other schemes were tuned
to each algorithm with hindsight. The figure shows what was processed within L, as a share of what
is possible, and the accuracy that is left then. Corner detectors do not tolerate thinning."""

_HOW_TO_READ = f"""\
Every consumer of the library gets the same stream: 100 objects at up to 800 px/s on 1280 x 720 px
for 0.3 s, 9 Mev/s. alpha and beta are measured here, from Python, over packages of 1 to 10,000
events of its second half (lower quartile); a cost in a name is stated, not measured: 450 ns is the
published rule without an index, 2 us the authors' class, 300 ns the fast engine on a smaller
computer. In virtual time the computer is {SLOWDOWN:g} times slower than this one, L =
{LATENCY_MS:g} ms; the load is the event rate times its beta, "possible" 1 / load: what is finished
in the L after the stream comes on top.

Deadline knows L and nothing else. The baselines lose events only where the ring is too small for
the queue, so each has two numbers, size, period or rate bound and the ring. Both were chosen
with hindsight among 21 to 68 settings, on the first 100 ms of seed 0 in virtual time with the true
cost: most events within L of those whose p99 is within L. Asap2020 knows the true beta besides.
"One for all" is the setting that does best over the whole ladder, as Deadline has to."""

_ACCURACY = """\
MOTA of the trackers, F of the corner detectors; mean and standard deviation over the seeds. "All
events": none discarded, no latency. *Delivered*: asked every 5 ms after the last event before it
that got through, as `score` does, so that latency costs nothing. *In use*: asked what is known
at that moment, from the packages that were finished by then, against the truth of that moment: what
a robot gets. For corners, F of the delivered events among themselves, and of all events of the
stream, where an event that was discarded or late is no corner. Each baseline had the latency that
was chosen for it, at most L; what another L does is in the table over L."""

_TOLD = """\
An algorithm with `set_keep` stays accurate if it knows what fraction it gets. A scheme that
discards by gamma says so with every package; a ring that overflows cannot. Here the same packages
again, with nothing told, and with the mean of the whole run told, which is known afterwards."""


def write(
    path: Path,
    rows: Sequence[LadderRow],
    bounds: Sequence[OverLatency],
    told: Sequence[Told],
    *,
    command: str,
    seconds: float,
    figures: Iterable[Path] = (),
    missing: Sequence[str] = (),
) -> list[Path]:
    """Write the document and its data; return their paths.

    Parameters
    ----------
    path, command, seconds
        As in `writer.write`.
    rows, bounds, told
        What was measured.
    figures : iterable of Path
        Beside the document.
    missing : sequence of str
        Consumers that this build does not have.
    """
    seeds = max(row.seeds for row in rows)
    late_ms = max(row.late_us for row in rows) / 1e3
    sections = [
        _HOW_TO_READ,
        *([f"Not in this build: {', '.join(missing)}."] if missing else []),
        "## Finished within L, share of all events",
        in_time_table(rows),
        "## p99 / largest latency, in L",
        _by_scheme(rows, lambda one: f"{one['p99_of_bound'].mean:.2f} / {_worst(one)}"),
        "## Kept / overflow / stale, share of all events",
        _by_scheme(rows, lambda one: " / ".join(map(_share, _where(one)))),
        "## Accuracy that is left",
        _ACCURACY,
        "### In use",
        accuracy_table(rows, "in_use"),
        "### Delivered",
        accuracy_table(rows, "delivered"),
        *(["### In use over L, under Deadline", _over_latency(bounds)] if bounds else []),
        *(["### In use, told otherwise", _TOLD, _told_otherwise(rows, told)] if told else []),
        "## In real time",
        f"The algorithms themselves on this machine (BusyWait for stated costs), the stream "
        f"{SLOWDOWN:g} times as fast and four times over, L = {REAL_LATENCY_MS:g} ms, rings and "
        f"sizes scaled alike. Shares within L; p99 in L. The producer was late by {late_ms:.1f} ms "
        f"at p99 in the worst run: what of that is beyond L no scheme can mend. Virtual time knows "
        f"one cost per event; here it changes with what an algorithm gets, and who discards reads "
        f"every event first.",
        _by_scheme(
            rows,
            lambda one: f"{_share(one['in_time'])}, {one['p99_of_bound'].mean:.2f}",
            of=lambda row: row.real,
        ),
        "## Settings",
        _settings(rows),
    ]
    return writer.write(
        path,
        "ASAP over the ladder",
        _OPENING,
        sections,
        [*_rows(rows), *_rows_over_latency(bounds), *_rows_told(told)],
        command=command,
        seconds=seconds,
        notes=f"; {seeds} seed{'s' * (seeds != 1)}",
        lead=writer.pictures(figures),
    )


def _rows(rows: Iterable[LadderRow]) -> Iterator[dict[str, Any]]:
    for row in rows:
        for clock, schemes in (("virtual", row.virtual), ("real", row.real)):
            for scheme, figures in schemes.items():
                yield {
                    **{
                        name: getattr(row, name) for name in ("rung", "alpha_us", "beta_ns", "load")
                    },
                    "clock": clock,
                    "scheme": scheme,
                    "setting": str(row.settings[scheme]),
                    **_means(figures),
                }


def _rows_over_latency(bounds: Iterable[OverLatency]) -> Iterator[dict[str, Any]]:
    for one in bounds:
        figures = {name: getattr(one, name) for name in ("kept", "delivered", "in_use")}
        yield {"rung": one.rung, "latency_ms": one.latency_ms, **_means(figures)}


def _rows_told(told: Iterable[Told]) -> Iterator[dict[str, Any]]:
    for one in told:
        for scheme, in_use in one.in_use.items():
            what = {"rung": one.rung, "told": one.told, "scheme": scheme}
            yield {**what, **_means({"in_use": in_use})}


def _means(figures: Mapping[str, Mean]) -> dict[str, float]:
    means = {name: value.mean for name, value in figures.items()}
    return means | {f"{name}_spread": value.spread for name, value in figures.items()}


def in_time_table(rows: Sequence[LadderRow]) -> str:
    """Write what every scheme finished within L, beside cost and load."""
    labels = list(rows[0].virtual)
    return markdown(
        ("", "alpha us", "ns/event", "load", "possible", *labels),
        [
            (
                row.rung,
                "stated" if row.stated else f"{row.alpha_us:.2f}",
                f"{row.beta_ns:.3g}" if row.beta_ns < 1000 else f"{row.beta_ns:.0f}",
                f"{row.load:.3g}",
                _share(row.possible),
                *(_share(row.virtual[label]["in_time"]) for label in labels),
            )
            for row in rows
        ],
    )


def accuracy_table(rows: Sequence[LadderRow], figure: str) -> str:
    """Write one accuracy of the consumers that have one, beside that with all events."""
    some = [row for row in rows if row.score]
    labels = list(rows[0].virtual)
    return markdown(
        ("", "", "all events", *labels),
        [
            (
                row.rung,
                {"tracker": "MOTA", "corners": "F"}[row.score or ""],
                _both(row.alone),
                *(_both(row.virtual[label][figure]) for label in labels),
            )
            for row in some
        ],
    )


def _by_scheme(
    rows: Sequence[LadderRow],
    cell: Callable[[dict[str, Mean]], str],
    of: Callable[[LadderRow], Figures] = lambda row: row.virtual,
) -> str:
    labels = list(of(rows[0]))
    return markdown(
        ("", *labels), [(row.rung, *(cell(of(row)[label]) for label in labels)) for row in rows]
    )


def _over_latency(bounds: Sequence[OverLatency]) -> str:
    return markdown(
        ("", "L ms", "kept", "delivered", "in use"),
        [
            (one.rung, f"{one.latency_ms:g}", *map(_both, (one.kept, one.delivered, one.in_use)))
            for one in bounds
        ],
    )


def _told_otherwise(rows: Sequence[LadderRow], told: Sequence[Told]) -> str:
    labels = list(told[0].in_use)
    by_scheme = {
        row.rung: {label: row.virtual[label]["in_use"] for label in labels} for row in rows
    }
    lines = []
    for rung in dict.fromkeys(one.rung for one in told):
        ways = [Told(rung, "what the scheme says", by_scheme[rung])]
        for one in (*ways, *(one for one in told if one.rung == rung)):
            lines.append((rung, one.told, *(_both(one.in_use[label]) for label in labels)))
    return markdown(("", "told", *labels), lines)


def _settings(rows: Sequence[LadderRow]) -> str:
    labels = list(rows[0].settings)
    single = [label for label in labels if len({str(row.settings[label]) for row in rows}) == 1]
    each = [label for label in labels if label not in single]
    lines = [f"{label}: {rows[0].settings[label]}." for label in single]
    table = markdown(
        ("", *each),
        [(row.rung, *(str(row.settings[label]) for label in each)) for row in rows],
        numbers=False,
    )
    return "\n".join(f"* {line}" for line in lines) + "\n\n" + table


def _where(one: dict[str, Mean]) -> tuple[Mean, Mean, Mean]:
    return one["kept"], one["overflow"], one["stale"]


def _worst(one: dict[str, Mean]) -> str:
    return f"{one['max_of_bound'].mean:.2f}"


def _share(value: float | Mean) -> str:
    """Three digits after the point, more where nothing would be left."""
    number = value.mean if isinstance(value, Mean) else value
    if math.isnan(number):
        return "-"
    text = f"{number:.3f}" if number >= 0.01 or number == 0 else f"{number:.1g}"
    return "0" if number == 0 else re.sub(r"^0\.", ".", text)


def _both(value: Mean) -> str:
    if math.isnan(value.mean):
        return "-"
    numbers = [value.mean] + ([] if math.isnan(value.spread) else [value.spread])
    return "±".join(re.sub(r"^(-?)0\.", r"\1.", f"{number:.3f}") for number in numbers)
