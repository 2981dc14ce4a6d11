"""An inspection as text: what a recording holds, every check, the verdict, what helps."""

from __future__ import annotations

import os
import re
import textwrap

import numpy as np

from asap import _units
from asap.results import html
from asap.results.inspection import Finding, Inspection

_WIDE = 100


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
        f"{_units.share(counts[0] / total)} on the timestamp before, half below {half}, 99 % below "
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


def inspection_html(inspection: Inspection) -> str:
    """Show an inspection: what the recording holds, every check, the verdict, what helps."""
    checks = [
        (check_name(one), _units.count(one.count), one.verdict, check_detail(one))
        for one in inspection.findings.values()
    ]
    remedies = inspection_remedies(inspection)
    return (
        html.heading(inspection_title(inspection))
        + html.table((), inspection_facts(inspection).items())
        + html.table(("check", "found", "verdict", ""), checks)
        + html.verdict(inspection_verdict(inspection))
        + (html.table((), remedies.items()) if remedies else "")
    )
