"""A run as text: tables for terminal, log file and notebook, and the verdict in words."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from typing import Any

from asap import _units
from asap.results import html
from asap.results.cost import MIN_BOUND, Cost
from asap.results.numbers import Diagnosis, Pauses, diagnose
from asap.results.run import Run

_WIDTH = 78
LONG_GAP = 0.5  # times the bound

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
    if isinstance(refused := getattr(run.algorithm, "refused", 0), int) and refused:
        words = f"all slots taken, {_units.count(refused)} times no cluster could begin"
        rows.append(("clusters", f"{words}; give it more slots"))
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
            "Those of another scheme may tell: asap.Greedy() takes all that waits. If the first "
            "call compiles or loads something, call the algorithm once before the run."
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
    if least_us > MIN_BOUND * cost.alpha_us:
        cheaper = f"an algorithm that processes a single event in {_units.duration(bound_us / 2)}"
    else:
        cheaper = f"a fixed cost of {_units.duration(bound_us / MIN_BOUND)}"
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
    if ledger["delivered"] == 0 or gap_us <= LONG_GAP * run.latency_bound_us:
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
        html.heading(run_title(summary), run_subtitle(summary))
        + html.table((), run_figures(run, summary).items())
        + html.table(("", "events", "share", ""), ledger)
        + html.verdict(run_verdict(run))
    )


def _share_of(count: int, received: int) -> str:
    return _units.share(count / received) if count and received else ""
