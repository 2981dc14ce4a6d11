"""What `check` found about a recording, and how it is shown as text."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from asap import _core, _units
from asap.results import html
from asap.results.result import SCHEMA_VERSION, Result

OK, NOTE, WRONG = "ok", "note", "wrong"
_HEAD = ("check", "found", "verdict", "")
_WIDE = 100

# Times between events: 0 us, 1 us, then an octave each. No recording is longer than the last one.
BINS_FROM_US: NDArray[np.int64] = np.append(0, 1 << np.arange(54, dtype=np.int64))


@dataclass(frozen=True)
class Finding:
    """The outcome of one check.

    Attributes
    ----------
    name : str
        The check.
    count : int
        How often it was found.
    verdict : str
        ``"ok"``, ``"note"`` (worth knowing; ASAP copes) or ``"wrong"``.
    detail : str
        The measurement, in words.
    remedy : str
        The remedy; empty where none is needed.
    event : int or None
        Number of the first such event in the source, from 0. Records that no event can hold have
        no number.
    t_us : int or None
        Its timestamp as the source has it.
    byte : int or None
        Where it is in the file, if the format tells.
    """

    name: str
    count: int
    verdict: str
    detail: str
    remedy: str = ""
    event: int | None = None
    t_us: int | None = None
    byte: int | None = None


@dataclass(frozen=True, eq=False)
class Inspection(Result):
    """The findings of `check` about a recording, and what it holds.

    Rates, gaps and pixels are those of the good events. Windows are aligned to
    the first one; no more of a window counts than the recording lasts.

    Attributes
    ----------
    path : str or None
        Where the file is.
    format : str
        Format of the file, or what else the source is.
    width, height : int or None
        Size of the sensor in px.
    received, events : int
        All records, and the good ones among them.
    t_first_us : int or None
        Timestamp of the first good event, as the source has it.
    duration_s : float
        From the first to the last good event, clock resets bridged.
    on_share : float
        Share of ON events.
    rate_mean_hz, rate_peak_1ms_hz, rate_peak_10ms_hz, rate_peak_100ms_hz : float
        Events per second: over all, and in the busiest window.
    longest_gap_us : int
        Longest time without an event.
    findings : dict of str to Finding
        Every check by name, in the order of the table.
    hot_pixels, busiest_pixels : ndarray, fields x, y, events
        Hot pixels, and the ten busiest ones; busiest first.
    pixel_counts : ndarray, shape (rows, columns)
        Events of each pixel; at most 4096 x 4096 of them.
    interval_counts : ndarray, shape (55,)
        Events by the time since the one before: 0 us, 1 us, 2 to 3, 4 to 7 and so on by octaves.
    """

    path: str | None
    format: str
    width: int | None
    height: int | None
    received: int
    events: int
    t_first_us: int | None
    duration_s: float
    on_share: float
    rate_mean_hz: float
    rate_peak_1ms_hz: float
    rate_peak_10ms_hz: float
    rate_peak_100ms_hz: float
    longest_gap_us: int
    findings: Mapping[str, Finding]
    hot_pixels: NDArray[np.void]
    busiest_pixels: NDArray[np.void]
    pixel_counts: NDArray[np.int64]
    interval_counts: NDArray[np.int64]

    @property
    def ok(self) -> bool:
        """Whether nothing is wrong."""
        return self.verdict != WRONG

    @property
    def verdict(self) -> str:
        """The gravest of all findings: ``"ok"``, ``"note"`` or ``"wrong"``."""
        found = {finding.verdict for finding in self.findings.values()}
        return next((verdict for verdict in (WRONG, NOTE) if verdict in found), OK)

    def summary(self) -> dict[str, Any]:
        """Return the JSON object of ``asap check --json``."""
        checks = {name: asdict(finding) for name, finding in self.findings.items()}
        for check in checks.values():
            del check["name"]
        return {
            "schema_version": SCHEMA_VERSION,
            "verdict": self.verdict,
            "source": {
                "path": self.path,
                "format": self.format,
                "width": self.width,
                "height": self.height,
                "events": self.events,
                "duration_s": self.duration_s,
            },
            "received": self.received,
            "t_first_us": self.t_first_us,
            "on_share": self.on_share,
            "rate_hz": {
                "mean": self.rate_mean_hz,
                "peak_1ms": self.rate_peak_1ms_hz,
                "peak_10ms": self.rate_peak_10ms_hz,
                "peak_100ms": self.rate_peak_100ms_hz,
            },
            "longest_gap_us": self.longest_gap_us,
            "intervals": [
                {"from_us": from_us, "events": events}
                for from_us, events in zip(
                    BINS_FROM_US.tolist(), self.interval_counts.tolist(), strict=True
                )
                if events
            ],
            "checks": checks,
            "hot_pixels": _pixels(self.hot_pixels),
            "busiest_pixels": _pixels(self.busiest_pixels),
            "version": _core.__version__,
        }

    def _repr_html_(self) -> str:
        remedies = _remedies(self)
        return (
            html.heading(_title(self))
            + html.table((), _facts(self).items())
            + html.table(_HEAD, _rows(self))
            + html.verdict(_verdict(self))
            + (html.table((), remedies.items()) if remedies else "")
        )

    def __str__(self) -> str:
        """Write a text table of at most 100 columns that ends with the remedies."""
        rows = [_HEAD, *_rows(self)]
        name, found, verdict = (max(len(row[column]) for row in rows) for column in range(3))
        indent = name + found + verdict + 6
        head, *checks = (
            _lines(f"{row[0]:<{name}}  {row[1]:>{found}}  {row[2]:<{verdict}}  {row[3]}", indent)
            for row in rows
        )
        rule = "-" * max(len(line) for lines in checks for line in lines)
        facts = [_lines(f"  {label:<10}{value}", 12) for label, value in _facts(self).items()]
        remedies = [_lines(f"  {label}: {words}", 4) for label, words in _remedies(self).items()]
        above, below = [[_title(self)], *facts, [""], head], [[""], _lines(_verdict(self))]
        return "\n".join(chain(*above, [rule], *checks, *below, *remedies))

    def __repr__(self) -> str:
        name = self.path or self.format
        return f"<Inspection: {name}, {self.events} events, {self.verdict}>"


def _pixels(pixels: NDArray[np.void]) -> list[dict[str, int]]:
    names = pixels.dtype.names or ()
    return [dict(zip(names, pixel, strict=True)) for pixel in pixels.tolist()]


# ---- as text ------------------------------------------------------------------------------------


def _lines(text: str, indent: int = 0) -> list[str]:
    return _units.wrapped(text, _WIDE, indent)


def _title(inspection: Inspection) -> str:
    """Name an inspection by its recording."""
    return os.path.basename(inspection.path or "") or inspection.format


def _facts(inspection: Inspection) -> dict[str, str]:
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


def _rows(inspection: Inspection) -> list[tuple[str, ...]]:
    """Write every check: one text for each of `_HEAD`."""
    return [
        (_name(one), _units.count(one.count), one.verdict, _detail(one))
        for one in inspection.findings.values()
    ]


def _name(finding: Finding) -> str:
    """Name a check for a reader."""
    return finding.name.replace("_", " ")


def _detail(finding: Finding) -> str:
    """Say what was measured, and where the first one is."""
    first = []
    if finding.event is not None:
        first.append(f"event {_units.count(finding.event)} at t = {finding.t_us} us")
    if finding.byte is not None:
        first.append(f"byte {_units.count(finding.byte)}")
    where = [f"first: {' or '.join(first)}"] if first else []
    return "; ".join([*filter(None, [finding.detail]), *where])


def _verdict(inspection: Inspection) -> str:
    """Say in one or two sentences whether the recording can be used as it is."""
    by_verdict: dict[str, list[str]] = {"wrong": [], "note": []}
    for finding in inspection.findings.values():
        if finding.verdict != "ok":
            by_verdict[finding.verdict].append(_name(finding))
    wrong, notes = by_verdict["wrong"], by_verdict["note"]
    if not wrong and not notes:
        return "Verdict: ok. Nothing is wrong with this recording."
    also = f" To note: {', '.join(notes)}." if notes else ""
    if not wrong:
        return f"Verdict: ok. Nothing is wrong with this recording.{also}"
    return f"Verdict: wrong. Problems: {', '.join(wrong)}.{also}"


def _remedies(inspection: Inspection) -> dict[str, str]:
    """Say for everything that is wrong or worth knowing what helps; what is wrong comes first."""
    found = [finding for finding in inspection.findings.values() if finding.verdict != "ok"]
    found.sort(key=lambda finding: finding.verdict != "wrong")
    return {_name(finding): finding.remedy for finding in found}
