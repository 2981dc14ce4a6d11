"""``asap report``: one HTML page about saved runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import asap
from asap.cli.options import add_verb, page_file
from asap.cli.outcome import OK, need_report, print_json, print_written, reading, writing


def add(verbs: Any) -> None:
    """Add the verb to the parser."""
    verb = add_verb(verbs, "report", _call, "one HTML page about saved runs")
    verb.add_argument(
        "runs", nargs="+", type=Path, metavar="RUN.npz", help="of asap run --save; .json: no curves"
    )
    verb.add_argument(
        "-o",
        "--out",
        type=page_file,
        metavar="OUT.html",
        help="default: the first run's name with .html",
    )


def _call(arguments: Any) -> int:
    need_report()
    from asap.results.page import write_runs

    with reading(arguments):
        runs = [asap.load_run(path) for path in arguments.runs]
    out = arguments.out or arguments.runs[0].with_suffix(".html")
    with writing(out):
        write_runs(runs, out)
    if arguments.json:
        print_json({"schema_version": 1, "runs": len(runs), "file": str(out)})
    else:
        print_written(out)
    return OK
