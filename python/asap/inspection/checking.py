"""check: one pass over a source, block by block, through every meter."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from asap import _checks
from asap.experiment.runners import Progress
from asap.inspection.door import Door
from asap.inspection.findings import Meters, judge
from asap.inspection.meters import Duplicates, Gaps, Intervals, RateMeter, Stamps
from asap.inspection.pixels import PixelMap
from asap.inspection.raw_source import RawSource
from asap.io import TruncatedFileWarning
from asap.results import Inspection


def check(
    source: Any,
    *,
    width: int | None = None,
    height: int | None = None,
    order: str | None = None,
    time_unit: str | None = None,
    on_progress: Progress | None = None,
) -> Inspection:
    """Look for everything that can be wrong with a recording: how often, and where first.

    The source is read once, as its file or array has it, in flat memory; no event is repaired.

    Parameters
    ----------
    source
        A path, a `Recording`, an array (whatever `as_events` takes), or an iterable of arrays.
    width, height
        Size of the sensor in px, where the source does not state it. Without it addresses are not
        checked, which the result says.
    order, time_unit
        How to read a file or array that does not say it, as in `read`.
    on_progress : callable, optional
        Called as on_progress(done, None, {}) after each block: events looked at so far.

    Returns
    -------
    Inspection
        ``print`` it for a table that ends with a verdict and the remedies; ``.ok``, ``.findings``,
        ``.hot_pixels``, ``.summary()``, ``.plot()``, ``.report(path)``.

    Raises
    ------
    UnsupportedFormat, CorruptFile, ValueError, OSError, RuntimeError, TypeError
        As in `read` and `as_events`: nothing can be read. What can be read in part is inspected,
        and the rest is a finding; so is a file that ends before its first event.

    Examples
    --------
    >>> import numpy as np
    >>> events = np.zeros(3, asap.EVENT_DTYPE)
    >>> events["t"] = [10, 30, 20]
    >>> asap.check(events, width=346, height=260).findings["back_steps"].event
    2
    """
    _checks.callback("on_progress", on_progress)
    raw = RawSource(source, width=width, height=height, order=order, time_unit=time_unit)
    door = Door(raw.width, raw.height, is_file=raw.recording is not None)
    meters = Meters(
        door,
        Gaps(),
        Stamps(),
        Duplicates(),
        PixelMap(raw.width, raw.height),
        RateMeter(),
        Intervals(),
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", TruncatedFileWarning)  # it becomes a finding
        for block in raw:
            passed = door.check(block)
            if on_progress is not None:
                on_progress(door.seen, None, {})
            if len(passed.events) == 0:
                continue
            meters.begin(passed)
            for meter in (meters.gaps, meters.stamps, meters.duplicates, meters.intervals):
                meter.add(passed)
            meters.pixels.add(passed.events)
            meters.rates.add(passed.events["t"] - meters.begin_us)
    meters.stamps.finish()
    meters.rates.curve.finish()
    time_s, mean_hz, peak_hz = meters.rates.curve.curves()
    duration_s = meters.duration_us / 1e6
    peaks_hz = meters.rates.peaks_hz
    return Inspection(
        path=raw.path,
        format=raw.format,
        width=raw.width,
        height=raw.height,
        received=raw.bad_records + raw.out_of_bounds + door.seen,
        events=meters.events,
        t_first_us=meters.first_stamp_us,
        duration_s=duration_s,
        on_share=meters.on / meters.events if meters.events else 0.0,
        rate_mean_hz=meters.events / duration_s if duration_s else 0.0,
        rate_peak_1ms_hz=peaks_hz[1],
        rate_peak_10ms_hz=peaks_hz[10],
        rate_peak_100ms_hz=peaks_hz[100],
        longest_gap_us=meters.gaps.longest_us,
        most_on_one_stamp=meters.stamps.most,
        findings={finding.name: finding for finding in judge(raw, meters)},
        hot_pixels=meters.pixels.hot(),
        busiest_pixels=meters.pixels.busiest(),
        pixel_counts=meters.pixels.counts,
        interval_counts=meters.intervals.counts,
        rate_curve=np.column_stack((time_s, mean_hz, peak_hz)),
    )
