"""Results as text: tables for terminal, log file and notebook, and verdicts in words.

A notebook gets plain HTML: no script and no style of its own, so that the notebook's applies; every
value is escaped.
"""

from __future__ import annotations

import math
import os
import re
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

from asap import _units
from asap.results.cost import BOUND_KEPT, LEAST_BOUND, RATE_SHARE, Cost, keeps
from asap.results.data import Comparison, Finding, Inspection, Row, Run
from asap.results.numbers import Diagnosis, Pauses, diagnose

_WIDTH = 78
_LONG_GAP = 0.5  # times the bound

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


def format_run(run: Run) -> str:
    """Write a run as a short text table of at most 78 columns that ends with the verdict."""
    summary = run.summary()
    lines = [run_title(summary), *_units.wrapped(run_subtitle(summary), _WIDTH), ""]
    lines += [f"  {name:<11}{value}" for name, value in run_figures(run, summary).items()]
    lines += [
        "",
        format_ledger(run.ledger, run.rejected),
        "",
        *_units.wrapped(run_verdict(run), _WIDTH),
    ]
    return "\n".join(lines)


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
    return dict(rows)


def _run_gap(gap_us: int | None) -> str:
    if not gap_us:
        return "none" if gap_us == 0 else "not known"
    return f"{_units.duration(gap_us)} at most without a processed event while events came"


def format_ledger(ledger: Mapping[str, int], rejected: Mapping[str, int] | None = None) -> str:
    """Write where every event went, one line for each cause; rejected events by reason."""
    width = max(len(_units.count(value)) for value in ledger.values())
    received, lines = ledger["received"], []
    for name, words in LEDGER_WORDS.items():
        share = _units.share(ledger[name] / received) if ledger[name] and received else ""
        number = f"{_units.count(ledger[name]):>{width}}"
        lines.append(f"  {name:<11}{number}  {share:>8}  {words}")
        if name == "rejected" and (reasons := _units.reasons(rejected or {})):
            lines.append(f"{'':<13}{reasons}")
    missing = 2 * received - sum(ledger.values())
    if missing:
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


def run_verdict(run: Run) -> str:
    """Say what limited a run, what that cost, and what would have kept 95 % of the events.

    What follows from the measured processing times is marked as estimated.
    """
    if run.ledger.received == 0:
        return "No event was received."
    if run.without_log:
        return (
            "Bottleneck: not known, since a summary holds no packages; run.save('run.npz') keeps "
            f"them. {_losses(run)}"
        )
    found = diagnose(run)
    if run.packages.size == 0 and found.limit != "data":
        return f"No event reached the algorithm. {_losses(run)}"
    bottleneck = _BOTTLENECKS[found.limit].format(scheme=run.scheme.name)
    in_time = _units.share(run.in_time).replace("100.0 %", "100 %")
    return (
        f"Bottleneck: {bottleneck}. {in_time} processed in time. "
        f"{_explanation(run, found)} {_losses(run)}"
    )


_BOTTLENECKS = {
    "data": "bad events in the data",
    "camera": "the camera",
    "scheme": "the scheme ({scheme})",
    "machine": "this machine",
    "bound": "the latency bound",
    "algorithm": "the algorithm",
    "first call": "the first call",
    "pauses": "pauses of the algorithm",
    "fixed cost": "the fixed cost of a package",
    "unknown": "not known",
}


def _explanation(run: Run, found: Diagnosis) -> str:
    if found.limit == "data":
        return (
            f"{_units.count(run.ledger.rejected)} of {_units.count(run.ledger.received)} events "
            f"were rejected ({_units.reasons(run.rejected)}). asap.check shows where."
        )
    cost = f"Estimated cost: {_run_cost(found.cost)}{_pauses(run, found.pauses)}."
    return f"{cost} {_run_remedy(run, found)}".rstrip()


def _run_cost(cost: Cost) -> str:
    noise = f"{100 * cost.noise:.0f}"
    spread = f", +- {noise} %" if noise != "0" else ""
    per_event = _units.duration((cost.beta_ns or cost.beta_error_ns) / 1e3)
    if cost.one_size is None:
        least = "at most " * (cost.beta_ns == 0 < cost.beta_error_ns)
        return (
            f"{_units.duration(cost.alpha_us)} per package + {least}{per_event} per event{spread}"
        )
    package = _units.duration(cost.alpha_us + cost.beta_ns / 1e3 * cost.one_size)
    events = "1 event" if cost.one_size == 1 else f"{_units.count(cost.one_size)} events"
    return f"{package} per package of {events}{spread}"


def _pauses(run: Run, pauses: Pauses) -> str:
    if pauses.slow < 0.01 * run.packages.size and pauses.share < 0.01:
        return ""
    which = f"{pauses.first} packages" if pauses.first > 1 else "package"
    first = f", the first {which} {_units.duration(pauses.first_us)}" if pauses.first else ""
    packages = "1 package" if pauses.slow == 1 else f"{_units.count(pauses.slow)} packages"
    return (
        f"; {packages} took more than {pauses.times:.2g} times the estimate, "
        f"{_units.share(pauses.share)} of the time{first}"
    )


def _run_remedy(run: Run, found: Diagnosis) -> str:
    bound = _units.duration(run.latency_bound_us)
    if found.limit == "machine":
        late = (
            f"The replay itself was late, by {_units.duration(run.lateness.max)} at most and by "
            f"more than half the bound for {_units.share(found.late_share)} of the time. "
            if run.lateness and found.late_share
            else ""
        )
        held = f"waited for a processor for {_units.duration(1e6 * (run.held_s or 0))} in all"
        held = f"The algorithm's thread {held}. " * found.pauses.held
        return f"{late}{held}Repeat it on a quiet machine, or in virtual time."
    if found.limit == "fixed cost":
        return _impossible(run, found.cost)
    if found.limit == "first call":
        return "Call the algorithm once before the run."
    if found.limit == "pauses":
        others = ", or other programs took the processor" * (run.held_s is None)
        return f"A garbage collector, memory, files or locks make an algorithm pause{others}."
    if found.limit == "unknown":
        return (
            "These packages are too few, or too alike in size, to tell what of it is per event. "
            "Those of another scheme may tell: asap.Greedy() takes all that waits."
        )
    if found.cost.one_size is not None:
        return ""
    faster = f"make the algorithm {math.ceil(10 * found.speedup) / 10} times as fast"
    if getattr(run.scheme, "parameters", {}).get("rate_bound", found.needed_hz) < found.needed_hz:
        faster += " and raise rate_bound"
    if found.pauses.excess_share > 0.05:
        faster += ", and call it once before the run" if found.pauses.first else ", without pauses"
    more, remedy = " asap.compare shows which scheme processes more.", ""
    if found.limit == "bound" and found.bound_us is not None:
        remedy = f"use a bound of {_units.duration(found.bound_us)} or {faster}."
    if found.limit == "algorithm":
        remedy = f"{faster}: it has to process {_units.rate(found.needed_hz)}."
    if remedy:
        up_to = f"bound of up to {_units.duration(found.longest_us)}"
        ruled_out = f"A {'longer bound' if math.isinf(found.longest_us) else up_to} does not help. "
        ruled_out *= found.bound_us is None and found.longest_us > run.latency_bound_us
        late = more * (run.kept - run.in_time > 0.05)
        return f"{ruled_out}To process 95 % in time, {remedy}{late}"
    is_told = found.cost.beta_ns > 0 and found.cost.one_size is None
    passes_hz = (found.cost if is_told else found.cost.dearest).throughput_hz(run.latency_bound_us)
    if passes_hz == float("inf"):
        passes = f"The algorithm keeps up with any event rate within {bound}."
    else:
        passes = (
            f"The algorithm can process {'' if is_told else 'at least '}{_units.rate(passes_hz)} "
            f"within {bound}; {_units.rate(found.offered_hz)} arrived on average."
        )
    return passes + more * (found.limit == "scheme")


def _impossible(run: Run, cost: Cost) -> str:
    bound_us = run.latency_bound_us
    p99, most = (f"{us / bound_us:.3g}" for us in (run.latency.quantile(0.99), run.latency.max))
    least_us = cost.least_bound_us
    if least_us > LEAST_BOUND * cost.alpha_us:
        cheaper = f"an algorithm that processes a single event in {_units.duration(bound_us / 2)}"
    else:
        cheaper = f"a fixed cost of {_units.duration(bound_us / LEAST_BOUND)}"
    return (
        f"No scheme can keep a bound of {_units.duration(bound_us)} at this cost: latency was "
        f"{p99} (p99) and {most} (max) times as long. "
        f"Use a bound of at least {_units.duration(least_us)}, or {cheaper} or less."
    )


def _losses(run: Run) -> str:
    ledger = run.ledger
    causes = ("rejected", "discarded", "stale", "overflow", "pending")  # a filter is a choice
    shares = {cause: ledger[cause] / ledger["received"] for cause in causes}
    shares["delivered late"] = run.kept - run.in_time
    lost = [f"{_units.share(share)} {cause}" for cause, share in shares.items() if share > 0]
    words = f"Lost: {', '.join(lost)}." if lost else "No event was lost."
    if ledger["filtered"] > 0:
        words += f" The filter took out {_units.share(ledger['filtered'] / ledger['received'])}."
    gap_us = run.gap_us or 0
    if ledger["delivered"] == 0 or gap_us <= _LONG_GAP * run.latency_bound_us:
        return words
    return (
        f"{words} The longest gap is {_units.duration(gap_us)} "
        f"({gap_us / run.latency_bound_us:.2g} L): events came, and none of them was processed. "
        "asap.compare shows the gaps of other schemes."
    )


def parameter_value(parameter: Any) -> str:
    """Write the value of a parameter."""
    if isinstance(parameter, (int, float)) and parameter == round(parameter):
        return _units.count(parameter)
    return f"{parameter:g}" if isinstance(parameter, float) else str(parameter)


# ---- a comparison -------------------------------------------------------------------------------


_WIDE = 100
_ALL = 0.9995  # times the oracle, likewise
_SHORT = 10.0  # latency bounds
_MOST_NAMES = 5
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
    gaps = [row.label for row in keepers if row.gap_us > _LONG_GAP * bound_us]
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
    if len(names) > _MOST_NAMES:
        names = [*names[: _MOST_NAMES - 2], f"{len(names) - _MOST_NAMES + 2} others"]
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


# ---- an inspection ------------------------------------------------------------------------------


CHECKS = {
    "empty": "whether there is any good event",
    "bad_records": "lines or records that are no event, stamps that are no time",
    "truncated": "whether the file ends where it should",
    "out_of_bounds": "pixels outside the sensor",
    "back_steps": "stamps that go back by less than 1 s",
    "clock_resets": "stamps that go back by 1 s or more: the clock was reset, or a counter wrapped",
    "lost_packets": "numbers of packets that a bag skips",
    "gaps": "100 ms or more without an event; from 1 s on something is wrong",
    "time_unit": "whether times whose unit nothing states step as those of a camera",
    "polarity": "values other than 0 and 1",
    "noise": "events without a neighbour for 20 ms; told when they are half of all",
    "hot_pixels": "pixels with at least 100 events, 0.1 % of all, and five times those of the "
    "second busiest pixel around them; wrong if they hold a tenth of the events",
}
"""Every check in words."""


def format_inspection(inspection: Inspection) -> str:
    """Write an inspection as a text table of at most 100 columns that ends with the remedies."""
    findings = inspection.findings.values()
    rows = [("check", "found", "verdict", "")]
    rows += [
        (check_name(finding), _units.count(finding.count), finding.verdict, check_detail(finding))
        for finding in findings
    ]
    name, found, word = (max(len(row[column]) for row in rows) for column in range(3))
    indent = name + found + word + 6
    head, *lines = (
        _hang(f"{row[0]:<{name}}  {row[1]:>{found}}  {row[2]:<{word}}  {row[3]}", indent)
        for row in rows
    )
    out = [inspection_title(inspection)]
    out += [
        _hang(f"  {label:<10}{value}", 12) for label, value in inspection_facts(inspection).items()
    ]
    out += ["", head, "-" * max(len(line) for text in lines for line in text.split("\n")), *lines]
    out += ["", _hang(inspection_verdict(inspection), 0)]
    out += [
        _hang(f"  {label}: {words}", 4) for label, words in inspection_remedies(inspection).items()
    ]
    return "\n".join(out)


def inspection_title(inspection: Inspection) -> str:
    """Name an inspection by its recording."""
    return os.path.basename(inspection.path or "") or inspection.format


def inspection_facts(inspection: Inspection) -> dict[str, str]:
    """Say what the recording holds, as ``asap info`` does."""
    rate = inspection.rate_mean_hz
    peaks = {
        "100 ms": inspection.rate_peak_100ms_hz,
        "10 ms": inspection.rate_peak_10ms_hz,
        "1 ms": inspection.rate_peak_1ms_hz,
    }
    size = (
        f"{inspection.width} x {inspection.height} px"
        if inspection.width and inspection.height
        else "unknown"
    )
    return {
        "format": inspection.format,
        "sensor": size,
        "events": f"{_units.count(inspection.events)} good ones of "
        f"{_units.count(inspection.received)}, {_units.share(inspection.on_share)} ON",
        "duration": _units.duration(inspection.duration_s * 1e6),
        "rate": f"mean {_units.rate(rate)}, peak "
        + ", ".join(f"{_units.rate(value)} in {window}" for window, value in peaks.items()),
        "intervals": _intervals(inspection),
    }


def _intervals(inspection: Inspection) -> str:
    counts = inspection.interval_counts
    total = int(counts.sum())
    if total == 0:
        return "none"
    below = np.cumsum(counts) / total
    half, most = (_units.duration(1 << int(np.searchsorted(below, q))) for q in (0.5, 0.99))
    return (
        f"{_units.share(counts[0] / total)} on the stamp before, half below {half}, 99 % below "
        f"{most}, longest {_units.duration(inspection.longest_gap_us)}"
    )


def check_name(finding: Finding) -> str:
    """Name a check for a reader."""
    return finding.name.replace("_", " ")


def check_detail(finding: Finding) -> str:
    """Say what was measured, and where the first one is."""
    first = []
    if finding.event is not None:
        first.append(f"event {_units.count(finding.event)} at t = {finding.t_us} us")
    if finding.byte is not None:
        first.append(f"byte {_units.count(finding.byte)}")
    where = [f"first: {' or '.join(first)}"] if first else []
    return "; ".join([*filter(None, [finding.detail]), *where])


def inspection_verdict(inspection: Inspection) -> str:
    """Say in one or two sentences whether the recording can be used as it is."""
    by_verdict: dict[str, list[str]] = {"wrong": [], "note": []}
    for finding in inspection.findings.values():
        if finding.verdict != "ok":
            by_verdict[finding.verdict].append(check_name(finding))
    wrong, notes = by_verdict["wrong"], by_verdict["note"]
    if not wrong and not notes:
        return "Verdict: ok. Nothing is wrong with this recording."
    also = f" To note: {', '.join(notes)}." if notes else ""
    if not wrong:
        return f"Verdict: ok. Nothing is wrong with this recording.{also}"
    return f"Verdict: wrong. Problems: {', '.join(wrong)}.{also}"


def inspection_remedies(inspection: Inspection) -> dict[str, str]:
    """Say for everything that is wrong or worth knowing what helps; what is wrong comes first."""
    found = [finding for finding in inspection.findings.values() if finding.verdict != "ok"]
    found.sort(key=lambda finding: finding.verdict != "wrong")
    return {check_name(finding): finding.remedy for finding in found}


def _hang(text: str, indent: int) -> str:
    # A number stays on the line of its unit.
    tied = re.sub(r"(?<=[\d=<>]) (?=[^\s\d])", "\xa0", text[indent:])
    wrapped = textwrap.fill(
        tied,
        _WIDE,
        initial_indent=text[:indent],
        subsequent_indent=" " * indent,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return (wrapped or text).replace("\xa0", " ").rstrip()


# ---- in a notebook ------------------------------------------------------------------------------


def run_html(run: Run) -> str:
    """Show a run: its figures, where every event went, the verdict."""
    summary, received = run.summary(), run.ledger["received"]
    reasons = _units.reasons(run.rejected)
    ledger = [
        (
            cause,
            _units.count(run.ledger[cause]),
            _share_of(run.ledger[cause], received),
            f"{words}: {reasons}" if cause == "rejected" and reasons else words,
        )
        for cause, words in LEDGER_WORDS.items()
    ]
    return (
        heading(run_title(summary), run_subtitle(summary))
        + table((), run_figures(run, summary).items())
        + table(("", "events", "share", ""), ledger)
        + _verdict_html(run_verdict(run))
    )


def comparison_html(comparison: Comparison) -> str:
    """Show a comparison: a row for each scheme, the oracle, the verdict."""
    rows = [comparison_cells(row, comparison.latency_ms) for row in comparison.rows]
    return (
        heading(comparison_title(comparison), comparison_subtitle(comparison))
        + table(tuple(COLUMNS), rows + oracle_rows(comparison))
        + _verdict_html(comparison_verdict(comparison))
    )


def inspection_html(inspection: Inspection) -> str:
    """Show an inspection: what the recording holds, every check, the verdict, what helps."""
    checks = [
        (check_name(one), _units.count(one.count), one.verdict, check_detail(one))
        for one in inspection.findings.values()
    ]
    remedies = inspection_remedies(inspection)
    return (
        heading(inspection_title(inspection))
        + table((), inspection_facts(inspection).items())
        + table(("check", "found", "verdict", ""), checks)
        + _verdict_html(inspection_verdict(inspection))
        + (table((), remedies.items()) if remedies else "")
    )


def _share_of(count: int, received: int) -> str:
    return _units.share(count / received) if count and received else ""


def heading(title: str, subtitle: str = "") -> str:
    """Write a heading in one or two lines."""
    return f"<p><b>{_text(title)}</b>{'<br>' if subtitle else ''}{_text(subtitle)}</p>"


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Write a table; the first cell of a row is its name."""
    names = "".join(f'<th scope="col">{_text(name)}</th>' for name in head)
    lines = [
        f'<tr><th scope="row">{_text(name)}</th>'
        + "".join(f"<td>{_text(cell)}</td>" for cell in cells)
        + "</tr>"
        for name, *cells in rows
    ]
    top = f"<thead><tr>{names}</tr></thead>" if names else ""
    return f"<table>{top}<tbody>{''.join(lines)}</tbody></table>"


def _verdict_html(sentences: str) -> str:
    return f"<p><b>Verdict:</b> {_text(sentences.removeprefix('Verdict: '))}</p>"


def _text(words: str) -> str:
    return escape(_units.tied(words))
