"""The command ``asap-study``: measure, write page, data and figures, judge by the goals."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from asap import _progress
from asap.cli import carry_out
from asap.cli.options import add_out
from asap.cli.outcome import (
    CHECK_FAILED,
    OK,
    USAGE,
    Failure,
    print_json,
    print_written,
    reading,
    say,
    usage,
    writing,
)
from asap_laboratory.page import Writer
from asap_laboratory.study import Study, conduct, write

_KINDS = {
    "bounds": "Deadline over bounds and disturbed costs instead",
    "accuracy": "scores of the algorithms over gamma instead",
    "rivals": "the cluster tracker beside its rivals instead",
    "ladder": "every consumer under every scheme instead",
    "realtime": "the simulator beside this machine's clock instead",
    "cpu_share": "processor time of Deadline over latency instead",
}


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line, that of the process unless given, and return the exit code."""
    return carry_out(_parser(), argv)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="asap-study",
        description="Every scheme over all scenarios, against the goals; less than 30 minutes on "
        "two cores.",
        epilog="example: asap-study --quick --out study",
    )
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--quick", action="store_true", help="a part, in less than 2 minutes")
    form.add_argument(
        "--full", action="store_true", help="more seeds, rows with hindsight; less than 90 minutes"
    )
    kind = parser.add_mutually_exclusive_group()
    for name, words in _KINDS.items():
        kind.add_argument(f"--{name.replace('_', '-')}", action="store_true", help=words)
    words = "all of these, the study with --full, and the figures of the users' pages instead"
    kind.add_argument("--all-pages", action="store_true", help=words)
    words = (
        "the cluster tracker on recordings with boxes instead: their folders, or a folder of them"
    )
    kind.add_argument("--real", nargs="*", type=Path, metavar="FOLDER", help=words)
    add_out(parser, "asap-study")
    parser.add_argument("--workers", type=_workers, metavar="N", help="processes (default: cores)")
    parser.add_argument(
        "--fresh", action="store_true", help="forget what DIR holds of earlier runs"
    )
    words = "measure nothing: write page and figures from the data in DIR"
    parser.add_argument("--page", action="store_true", help=words)
    parser.add_argument("--json", action="store_true", help="one JSON object on stdout")
    parser.set_defaults(verb=_conduct)
    return parser


def _workers(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text}: give a number of processes, at least 1")
    return int(text)


def _conduct(arguments: Any) -> int:
    if arguments.all_pages:
        return _all_pages(arguments)
    return _one(_study(arguments), _form(arguments), arguments)


def _all_pages(arguments: Any) -> int:
    """Conduct every study for its page, and draw the figures. What is finished is not run again."""
    from asap_laboratory import STUDIES, scene_pictures, scheme_figure

    if arguments.json:
        raise Failure(USAGE, "--json: says one study; leave it out with --all-pages")
    form = _form(arguments)
    forms = {"study": "full" if form == "default" else form}
    codes = [_one(study, forms.get(name, form), arguments) for name, study in STUDIES.items()]
    with writing(arguments.out):
        print_written(*scene_pictures.write(arguments.out), scheme_figure.write(arguments.out))
    return max(codes)


def _one(study: Study, form: str, arguments: Any) -> int:
    if arguments.page:
        with usage(), writing(arguments.out):
            found = write(study, arguments.out)
    else:
        with usage(), writing(arguments.out), _progress.on_terminal() as on_progress:
            found = conduct(
                study,
                arguments.out,
                form=form,
                workers=arguments.workers,
                fresh=arguments.fresh,
                on_progress=on_progress,
            )
    if arguments.json:
        rest = {
            "taken_from_file": found.taken_from_file,
            "files": [str(path) for path in found.paths],
        }
        kind = {"study": study.name, "form": form}
        print_json({"schema_version": 2, **kind, "tables": found.tables, **rest})
    else:
        print(study.shown(found.tables, Writer(study.cells)), end="\n\n")
        print_written(*found.paths)
    missed = [goal for goal in found.tables.get("goals", ()) if goal["holds"] is False]
    return CHECK_FAILED if missed else OK


def _form(arguments: Any) -> str:
    return "quick" if arguments.quick else "full" if arguments.full else "default"


def _study(arguments: Any) -> Study:
    from asap_laboratory import STUDIES

    if arguments.real is None:
        return STUDIES[next((one for one in _KINDS if getattr(arguments, one)), "study")]
    if arguments.page:
        raise Failure(USAGE, "--page: overlays need the recordings; leave it out with --real")
    from asap_laboratory.real import real_study
    from asap_laboratory.rivals.recordings import opened

    with reading(arguments):
        scenes, left_out = opened(arguments.real)
    for words in left_out:
        say(f"left out: {words}")
    command = " ".join(["asap-study --real", *(folder.name for folder in arguments.real)])
    return real_study(scenes, left_out, command)
