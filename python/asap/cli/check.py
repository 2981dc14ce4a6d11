"""``asap check``: what is wrong with a recording."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import asap
from asap import _progress
from asap.cli.options import add_recording, add_report, add_verb, open_recording
from asap.cli.outcome import (
    BAD_INPUT,
    CHECK_FAILED,
    OK,
    need_report,
    reading,
    show,
)
from asap.io.errors import CutFile


def add(verbs: Any) -> None:
    """Add the verb to the parser."""
    verb = add_verb(verbs, "check", _call, "what is wrong with a recording, where, and what helps")
    add_recording(verb, on_bad=False)
    add_report(verb)


def _call(arguments: Any) -> int:
    if arguments.report:
        need_report()
    with reading(arguments), _progress.on_terminal() as on_progress:
        inspection = asap.check(_source(arguments), on_progress=on_progress)
    show(inspection, arguments)
    if inspection.ok:
        return OK
    is_lost = inspection.events == 0 and inspection.findings["truncated"].count > 0
    return BAD_INPUT if is_lost else CHECK_FAILED


def _source(arguments: Any) -> asap.Recording | Path:
    try:
        return open_recording(arguments)
    except CutFile as cut:
        return cut.path  # nothing can be read; the table says so
