"""``asap info``: what a recording holds."""

from __future__ import annotations

import os
from typing import Any

import asap
from asap import _units
from asap.cli.options import add_recording, add_verb, open_recording
from asap.cli.outcome import OK, print_json, reading, tell_doubt


def add(verbs: Any) -> None:
    """Add the verb to the parser."""
    verb = add_verb(verbs, "info", _call, "what a recording holds")
    add_recording(verb)


def _call(arguments: Any) -> int:
    with reading(arguments):
        recording = open_recording(arguments)
        facts = asap.info(recording)
    tell_doubt(recording)
    if arguments.json:
        print_json(facts)
        return OK
    width, height = facts["width"], facts["height"]
    sensor = f"{width or '?'} x {height or '?'} px" if width or height else "unknown"
    if not (width and height):
        reach = f"events reach x = {facts['x_max']}, y = {facts['y_max']}"
        sensor += f": addresses are not checked; {reach}. Give --width and --height"
    rate = {name: _units.rate(value) for name, value in facts["rate_hz"].items()}
    rows = {
        "format": facts["format"],
        "sensor": sensor,
        "events": f"{_units.count(facts['events'])}, {_units.share(facts['on_share'])} ON",
        "duration": _units.duration(facts["duration_s"] * 1e6),
        "rate": f"mean {rate['mean']}, peak {rate['peak_10ms']} in 10 ms, "
        f"{rate['peak_1ms']} in 1 ms",
        "rejected": _units.reasons(facts["rejected"]) or "none",
    }
    if facts["clock_resets"]:
        rows["clock"] = (
            f"set back {facts['clock_resets']} x by 1 s or more: the duration leaves that out"
        )
    print(os.path.basename(facts["path"]))
    for name, value in rows.items():
        print(f"  {name:<10}{value}")
    return OK
