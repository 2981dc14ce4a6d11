"""What `check` found about a recording."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from asap import _core
from asap.results.result import SCHEMA_VERSION, Result

OK, NOTE, WRONG = "ok", "note", "wrong"

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
        from asap.results import inspection_text

        return inspection_text.inspection_html(self)

    def __str__(self) -> str:
        from asap.results import inspection_text

        return inspection_text.format_inspection(self)

    def __repr__(self) -> str:
        name = self.path or self.format
        return f"<Inspection: {name}, {self.events} events, {self.verdict}>"


def _pixels(pixels: NDArray[np.void]) -> list[dict[str, int]]:
    names = pixels.dtype.names or ()
    return [dict(zip(names, pixel, strict=True)) for pixel in pixels.tolist()]
