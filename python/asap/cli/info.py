"""``asap info``: what a recording holds."""

from __future__ import annotations

import os
from dataclasses import asdict
from typing import Any

from asap import analysis, units
from asap.cli.options import add_recording, add_verb, open_recording
from asap.cli.outcome import OK, print_json, reading
from asap.report import run_table

__all__ = ["add"]


def add(verbs: Any) -> None:
    """Add the verb to the parser."""
    verb = add_verb(verbs, "info", _call, "what a recording holds")
    add_recording(verb)


def _call(arguments: Any) -> int:
    with reading(arguments):
        recording = open_recording(arguments)
        found = analysis.describe(recording)
    if arguments.json:
        facts = asdict(found)
        facts["rate_hz"] = {
            name: facts.pop(f"rate_{name}_hz") for name in ("mean", "peak_1ms", "peak_10ms")
        }
        print_json(
            {
                "schema_version": 1,
                "path": str(arguments.file),
                "format": recording.format,
                "width": recording.width,
                "height": recording.height,
                **facts,
                "rejected": dict(recording.rejected),
            }
        )
        return OK
    sensor = (
        f"{recording.width} x {recording.height} px"
        if recording.width
        else "unknown: addresses are not checked; give --width and --height"
    )
    rows = {
        "format": recording.format,
        "sensor": sensor,
        "events": f"{units.count(found.events)}, {units.share(found.on_share)} ON",
        "duration": units.duration(found.duration_s * 1e6),
        "rate": f"mean {units.rate(found.rate_mean_hz)}, "
        f"peak {units.rate(found.rate_peak_10ms_hz)} in 10 ms, "
        f"{units.rate(found.rate_peak_1ms_hz)} in 1 ms",
        "rejected": run_table.reasons_of(recording.rejected) or "none",
    }
    print(os.path.basename(arguments.file))
    for name, value in rows.items():
        print(f"  {name:<10}{value}")
    return OK
