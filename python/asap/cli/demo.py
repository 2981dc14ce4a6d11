"""``asap demo``: the paper's two experiments, what the paper claims, and `Deadline` beside it."""

from __future__ import annotations

import textwrap
from dataclasses import asdict
from typing import Any

from asap import _progress
from asap.cli.options import add_out, add_verb
from asap.cli.outcome import (
    CHECK_FAILED,
    OK,
    need_report,
    print_json,
    print_written,
    writing,
)
from asap.results import text


def add(verbs: Any) -> None:
    """Add the verb to the parser."""
    verb = add_verb(verbs, "demo", _call, "the paper's two experiments on synthetic scenes")
    add_out(verb, "asap-demo")
    verb.add_argument("--quick", action="store_true", help="shorter scenes")


def _call(arguments: Any) -> int:
    need_report()
    from asap import demo

    with writing(arguments.out), _progress.on_terminal() as on_progress:
        runs, paths = demo.run(arguments.out, quick=arguments.quick, on_progress=on_progress)
    *experiments, default = runs
    claims = [demo.claims(run) for run in experiments]
    if arguments.json:
        print_json(
            {
                "schema_version": 1,
                "runs": [run.summary() for run in runs],
                "claims": [[asdict(claim) for claim in of_run] for of_run in claims],
                "files": [str(path) for path in paths],
            }
        )
    else:
        for run, of_run in zip(experiments, claims, strict=True):
            print(text.format_run(run), end="\n\n")
            for claim in of_run:
                print(f"  {'holds' if claim.holds else 'FAILS':<7}{claim.sentence}")
                print(textwrap.indent(textwrap.fill(claim.seen, 69), " " * 9))
            print()
        print("The first experiment again, under the default scheme:\n")
        print(demo.side_by_side(experiments[0], default), end="\n\n")
        print_written(*paths)
    return OK if all(claim.holds for of_run in claims for claim in of_run) else CHECK_FAILED
