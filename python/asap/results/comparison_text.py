"""A comparison as text: table, and the verdict in words."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from asap import _units
from asap.results import html
from asap.results.comparison import Comparison, Row
from asap.results.cost import BOUND_KEPT, RATE_SHARE, Cost, keeps
from asap.results.run_text import LONG_GAP, sensor

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


def format_comparison(comparison: Comparison) -> str:
    """Write a comparison as a text table of at most 100 columns, with a verdict."""
    table = [
        tuple(COLUMNS),
        *(comparison_cells(row, comparison.latency_ms) for row in comparison.rows),
    ]
    oracles = oracle_rows(comparison)
    (head, *lines), rule = _units.aligned(table + oracles)
    schemes, best = lines[: -len(oracles)], lines[-len(oracles) :]
    above = [
        comparison_title(comparison),
        *_units.wrapped(comparison_subtitle(comparison), _WIDE),
        "",
    ]
    below = ["", *_units.wrapped(comparison_verdict(comparison), _WIDE)]
    return "\n".join([*above, head, rule, *schemes, rule, *best, *below])


def comparison_title(comparison: Comparison) -> str:
    """Name a comparison by its recording or profile."""
    count = len(comparison.rows)
    schemes = "one scheme" if count == 1 else f"{count} schemes"
    return f"{comparison.name}: {schemes} beside the oracle"


def comparison_subtitle(comparison: Comparison) -> str:
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


def comparison_cells(row: Row, latency_ms: float) -> tuple[str, ...]:
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


def oracle_rows(comparison: Comparison) -> list[tuple[str, ...]]:
    """Write the oracle's line: one text for each of `COLUMNS`, empty where there is no number."""
    name = "oracle (whole)" if comparison.execution == "whole" else "oracle"
    score = "1.000" if comparison.oracle > 0 else "-"
    reached = _units.share(comparison.oracle / comparison.received) if comparison.received else "-"
    return [(name, score, reached, *[""] * (len(COLUMNS) - 3))]


def comparison_verdict(comparison: Comparison) -> str:
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


def comparison_html(comparison: Comparison) -> str:
    """Show a comparison: a row for each scheme, the oracle, the verdict."""
    rows = [comparison_cells(row, comparison.latency_ms) for row in comparison.rows]
    return (
        html.heading(comparison_title(comparison), comparison_subtitle(comparison))
        + html.table(tuple(COLUMNS), rows + oracle_rows(comparison))
        + html.verdict(comparison_verdict(comparison))
    )
