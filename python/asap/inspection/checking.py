"""check and info: one pass over a source, block by block."""

from __future__ import annotations

import os
import warnings
from dataclasses import asdict
from typing import Any

from asap import _checks, analysis
from asap.experiment.runners import Progress
from asap.inspection.findings import judge
from asap.inspection.meters import BadEvents, Meters
from asap.inspection.raw_source import RawSource
from asap.inspection.result import Inspection
from asap.io import TruncatedFileWarning, read
from asap.io.source import names_files


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
        As in `read` and `as_events`: nothing can be read. The readable part of a damaged
        file is inspected, and the rest is a finding; so is a file that ends before its first event.

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
    bad = BadEvents(raw.width, raw.height, is_file=raw.recording is not None)
    meters = Meters(raw.width, raw.height)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", TruncatedFileWarning)  # it becomes a finding
        for block in raw:
            passed = bad.check(block)
            if on_progress is not None:
                on_progress(bad.seen, None, {})
            if len(passed.events):
                meters.add(passed)
    duration_s = meters.duration_us / 1e6
    peaks_hz = meters.peaks_hz
    return Inspection(
        path=raw.path,
        format=raw.format,
        width=raw.width,
        height=raw.height,
        received=raw.losses.bad_record + raw.losses.out_of_bounds + bad.seen,
        events=meters.events,
        t_first_us=meters.first_stamp_us,
        duration_s=duration_s,
        on_share=meters.on / meters.events if meters.events else 0.0,
        rate_mean_hz=meters.events / duration_s if duration_s else 0.0,
        rate_peak_1ms_hz=peaks_hz[1],
        rate_peak_10ms_hz=peaks_hz[10],
        rate_peak_100ms_hz=peaks_hz[100],
        longest_gap_us=meters.steps.longest_us,
        findings={finding.name: finding for finding in judge(raw, bad, meters)},
        hot_pixels=meters.pixels.hot(),
        busiest_pixels=meters.pixels.busiest(),
        pixel_counts=meters.pixels.counts,
        interval_counts=meters.steps.counts,
    )


def info(path: Any, **options: Any) -> dict[str, Any]:
    """Return what a recording holds: sensor, events, duration, rates, what was rejected.

    The file is read once, in flat memory.

    Parameters
    ----------
    path
        The file or files, or what `read` returned for them.
    **options
        How to read it, as in `read`: ``width``, ``height``, ``order``, ``time_unit``, ``on_bad``.

    Returns
    -------
    dict
        ``schema_version``, ``path``, ``format``, ``width`` and ``height`` in px or None,
        ``events``, ``duration_s``, ``on_share`` 0..1, ``x_max`` and ``y_max`` in px, ``rate_hz``
        with ``mean``, ``peak_1ms`` and ``peak_10ms`` in ev/s, ``rejected`` by reason,
        ``clock_resets``, ``lost_packets``. It is the object of ``asap info --json``.

    Raises
    ------
    UnsupportedFormat, CorruptFile, NoGoodEvent, ValueError, OSError, RuntimeError
        As in `read`.

    Examples
    --------
    >>> asap.info("flight.aedat4")["rate_hz"]["mean"]  # doctest: +SKIP
    905127.3
    """
    if names_files(path):
        recording = read(path, **options)
    elif not hasattr(path, "rejected"):
        raise TypeError(_checks.named("path", path, "give a path, or what read() returned"))
    elif options:
        raise ValueError(f"{', '.join(options)}: a recording is open; say it to read()")
    else:
        recording = path
    facts = asdict(analysis.describe(recording))
    rates = {name: facts.pop(f"rate_{name}_hz") for name in ("mean", "peak_1ms", "peak_10ms")}
    return {
        "schema_version": 1,
        "path": os.fspath(recording.path),
        "format": recording.format,
        "width": recording.width,
        "height": recording.height,
        **facts,
        "rate_hz": rates,
        "rejected": dict(recording.rejected),
        "clock_resets": recording.clock_resets,
        "lost_packets": recording.lost_packets,
    }
