"""``asap convert``: a recording in another format."""

from __future__ import annotations

from typing import Any

import asap
from asap import _units, conversion
from asap.cli.options import add_recording, add_verb, open_recording, writable
from asap.cli.outcome import OK, print_json, reading, tell_doubt, usage, writing


def add(verbs: Any) -> None:
    """Add the verb to the parser."""
    verb = add_verb(verbs, "convert", _call, "write a recording in another format")
    add_recording(verb, "IN")
    verb.add_argument("out", type=writable, metavar="OUT", help="the file to write")
    verb.add_argument(
        "--to",
        choices=tuple(conversion.WRITERS),
        help="format (default: the suffix of OUT; .raw is evt3)",
    )
    verb.add_argument("--relative", action="store_true", help="count the time from the first event")


def _call(arguments: Any) -> int:
    out = arguments.out
    with usage():
        to = conversion.format_of(out, arguments.to)
    with reading(arguments):
        recording = open_recording(arguments)
        with writing(out):
            count = asap.convert(recording, out, to=to, relative=arguments.relative)
    tell_doubt(recording)
    if arguments.json:
        print_json({"schema_version": 1, "path": str(out), "format": to, "events": count})
    else:
        print(f"wrote {out}: {_units.count(count)} events")
    return OK
