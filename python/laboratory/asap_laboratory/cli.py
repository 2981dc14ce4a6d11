"""The command ``asap-study``: measure, write tables and figures, judge by the goals."""

from __future__ import annotations

import argparse
import importlib
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, TypeVar

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
from asap.results.data import without_nan

_Found = TypeVar("_Found")


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
        "--full", action="store_true", help="three seeds, rows with hindsight; less than 90 minutes"
    )
    form.add_argument(
        "--realtime", action="store_true", help="the simulator beside this machine's clock instead"
    )
    parser.add_argument(
        "--accuracy", action="store_true", help="scores of the algorithms over gamma instead"
    )
    parser.add_argument(
        "--rivals", action="store_true", help="the cluster tracker beside its rivals instead"
    )
    parser.add_argument(
        "--ladder", action="store_true", help="every consumer under every scheme instead"
    )
    words = (
        "the cluster tracker on recordings with boxes instead: their folders, or a folder of them"
    )
    parser.add_argument("--real", nargs="*", type=Path, metavar="FOLDER", help=words)
    add_out(parser, "asap-study")
    parser.add_argument("--workers", type=_workers, metavar="N", help="processes (default: cores)")
    parser.add_argument(
        "--fresh", action="store_true", help="forget what DIR holds of earlier runs"
    )
    parser.add_argument("--json", action="store_true", help="one JSON object on stdout")
    parser.set_defaults(verb=_conduct)
    return parser


def _workers(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text}: give a number of processes, at least 1")
    return int(text)


def _conduct(arguments: Any) -> int:
    asked = [kind for kind in _KINDS if getattr(arguments, kind) not in (False, None)]
    if len(asked) > 1:
        raise Failure(USAGE, " and ".join(f"--{kind}" for kind in asked) + ": give one of them")
    return _KINDS[asked[0]](arguments) if asked else _schemes(arguments)


def _schemes(arguments: Any) -> int:
    from asap_laboratory import study

    found = _conducted(arguments, study, "asap-study")
    if arguments.json:
        _print_json(arguments, found, goals=[asdict(goal) for goal in found.goals])
    else:
        for goal in found.goals:
            word = {True: "pass", False: "FAIL", None: "-"}[goal.holds]
            print(f"{goal.id:<4} {word:<5} {goal.test}")
            print(f"           {goal.measured}  (goal: {goal.target})")
        print_written(*found.paths)
    return OK if found.holds else CHECK_FAILED


def _accuracy(arguments: Any) -> int:
    from asap_laboratory import accuracy, accuracy_study

    found = _conducted(arguments, accuracy_study, "asap-study --accuracy")
    _say_missing(found)
    if arguments.json:
        _print_json(arguments, found, accuracy=[curve.summary() for curve in found.curves])
        return OK
    for column, heading in (("mota", "MOTA"), ("f_measure", "corners, F")):
        some = [curve for curve in found.curves if column in curve.rows[0].mean]
        corners = [curve for curve in some if "mota" not in curve.rows[0].mean]
        if shown := some if column == "mota" else corners:
            print(f"{heading}\n\n{accuracy.document.by_scene(shown, column)}\n")
    print_written(*found.paths)
    return OK


def _rivals(arguments: Any) -> int:
    from asap_laboratory import rivals, rivals_study

    found = _conducted(arguments, rivals_study, "asap-study --rivals")
    if arguments.json:
        curves = [curve.summary() for curve in found.curves]
        _print_json(arguments, found, rivals=curves, recordings=without_nan(found.recordings))
        return OK
    document = rivals.document
    print(f"{document.verdict(found.curves)}\n\nMOTA\n\n{document.accuracy(found.curves)}\n")
    print(f"ns of processor time per event\n\n{document.cost(found.curves)}\n")
    if found.recordings:
        print(f"recordings\n\n{document.recordings_table(found.recordings)}\n")
    print_written(*found.paths)
    return OK


def _ladder(arguments: Any) -> int:
    from asap_laboratory import ladder, ladder_study

    found = _conducted(arguments, ladder_study, "asap-study --ladder")
    _say_missing(found)
    if arguments.json:
        _print_json(arguments, found, ladder=[row.to_dict() for row in found.rows])
        return OK
    print(f"finished within L\n\n{ladder.document.in_time_table(found.rows)}\n")
    print(f"accuracy in use\n\n{ladder.document.accuracy_table(found.rows, 'in_use')}\n")
    print_written(*found.paths)
    return OK


def _real(arguments: Any) -> int:
    from asap_laboratory import real, real_study
    from asap_laboratory.real.folders import opened

    with reading(arguments):
        scenes, left_out = opened(arguments.real)
    for words in left_out:
        say(f"left out: {words}")
    with usage(), writing(arguments.out), _progress.on_terminal() as on_progress:
        found = real_study(
            arguments.out,
            list(scenes.values()),
            left_out=left_out,
            figures=_can_draw(),
            command=" ".join(["asap-study --real", *(folder.name for folder in arguments.real)]),
            on_progress=on_progress,
        )
    if arguments.json:
        sets = [one.summary() for one in found.sets]
        files = [str(path) for path in found.paths]
        print_json({"schema_version": 1, "form": "real", "sets": sets, "files": files})
        return OK
    print(f"{real.document.table(found.sets)}\n")
    print_written(*found.paths)
    return OK


def _beside_the_clock(arguments: Any) -> int:
    from asap_laboratory import realtime

    with usage(), writing(arguments.out):
        pairs = realtime.replay_beside_simulation()
        table = realtime.format_pairs(pairs, realtime.scheduling_jitter(5.0))
        arguments.out.mkdir(parents=True, exist_ok=True)
        path = arguments.out / "realtime.md"
        path.write_text(table + "\n", encoding="utf-8")
    if arguments.json:
        print_json({"schema_version": 1, "form": "realtime", "pairs": realtime.as_json(pairs)})
    else:
        print(table)
        print_written(path)
    return OK


_KINDS = {
    "ladder": _ladder,
    "accuracy": _accuracy,
    "rivals": _rivals,
    "real": _real,
    "realtime": _beside_the_clock,
}


def _form(arguments: Any) -> str:
    return "quick" if arguments.quick else "full" if arguments.full else "default"


def _conducted(arguments: Any, study: Callable[..., _Found], command: str) -> _Found:
    form = _form(arguments)
    with usage(), writing(arguments.out), _progress.on_terminal() as on_progress:
        return study(
            arguments.out,
            form=form,
            workers=arguments.workers,
            fresh=arguments.fresh,
            figures=_can_draw(),
            command=command if form == "default" else f"{command} --{form}",
            on_progress=on_progress,
        )


def _say_missing(found: Any) -> None:
    for label in found.missing:
        say(f"{label}: not in this build")


def _print_json(arguments: Any, found: Any, **figures: Any) -> None:
    rest = {
        "seconds": found.seconds,
        "taken_from_file": found.taken_from_file,
        "files": [str(path) for path in found.paths],
    }
    print_json({"schema_version": 1, "form": _form(arguments), **figures, **rest})


def _can_draw() -> bool:
    try:
        importlib.import_module("asap_laboratory.figures")
    except ImportError:
        say("no figures: they need matplotlib; install asap-events[report]")
        return False
    return True
