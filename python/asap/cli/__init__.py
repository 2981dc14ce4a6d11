"""The command ``asap``.

Results go to stdout, everything else to stderr; ``--json`` prints one object and nothing else. Exit
codes: 0 ok, 1 a check failed, 2 usage, 3 input unreadable, corrupt or empty, 128 and the number of
the signal that ended it: 130 Ctrl-C, 143 SIGTERM, 129 SIGHUP.
"""

from __future__ import annotations

import argparse
import io
import os
import re
import sys
import warnings
from collections.abc import Sequence
from typing import Any, NoReturn

import asap
from asap.cli.options import EXAMPLES
from asap.cli.outcome import INTERRUPTED, OK, USAGE, Ended, Failure, ended_by_signals, near, say
from asap.cli.verbs import VERBS

__all__ = ["carry_out", "main"]

_EPILOG = """\
examples:
  {}

exit codes: 0 ok, 1 a check failed, 2 usage, 3 input unreadable, corrupt or empty, 130 interrupted,
143 and 129 by SIGTERM and SIGHUP, which end a run as Ctrl-C does: with its files
"""


_WRONG = re.compile(r"invalid choice: '(.*?)' \(choose from (.*)\)|arguments: (\S+)")
_WORD = re.compile(r"[\w.-]+")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line, that of the process unless given, and return the exit code."""
    return carry_out(_parser(), argv)


def carry_out(parser: argparse.ArgumentParser, argv: Sequence[str] | None = None) -> int:
    """Run what a command line asks for and return the exit code."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # as stderr: a file name may be no text
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        warnings.showwarning = lambda message, *_, **__: say(f"warning: {message}")
        try:
            with ended_by_signals():
                code = _parsed_and_done(parser, argv)
            if sys.stdout is not None:  # None: closed
                sys.stdout.flush()
            return code
        except Failure as failure:
            say(f"error: {failure}")
            return failure.code
        except KeyboardInterrupt as interrupt:
            number = interrupt.number if isinstance(interrupt, Ended) else Ended.number
            say("interrupted" if number == Ended.number else f"ended by {number.name}")
            return INTERRUPTED + number
        except BrokenPipeError:
            _drop_stdout()  # the reader of the pipe is gone
            return OK
        except OSError as error:  # files that verbs read and write are their own matter
            _drop_stdout()
            say(f"error: {error.filename or 'stdout'}: {error.strerror or error}")
            return USAGE


def _parsed_and_done(parser: argparse.ArgumentParser, argv: Sequence[str] | None) -> int:
    try:
        arguments = parser.parse_args(argv)
    except SystemExit as end:
        return int(end.code or 0)
    code: int = arguments.verb(arguments)
    return code


def _drop_stdout() -> None:
    """Let what is still in its buffer go nowhere at exit."""
    if sys.stdout is not None:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


class _Parser(argparse.ArgumentParser):
    """Says in one line what is wrong, and takes what begins as a negative number for a value."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self.options: set[str] = set()  # of all verbs
        self._negative_number_matcher = re.compile(r"-\.?\d")

    def error(self, message: str) -> NoReturn:
        if wrong := _WRONG.search(message):
            choice, choices, option = wrong.groups()
            message += near(choice or option, self.options if option else _WORD.findall(choices))
        message += " " if message.endswith("?") else "; "
        self.exit(USAGE, f"{self.prog}: error: {message}{self.prog} --help lists what there is\n")


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="asap",
        description="Event-camera events to the algorithm as soon as possible.",
        epilog=_EPILOG.format("\n  ".join(EXAMPLES.values())),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"asap {asap.__version__}")
    verbs = parser.add_subparsers(metavar="VERB", required=True)
    for add in VERBS:
        add(verbs)
    parser.options.update(*(verb._option_string_actions for verb in verbs.choices.values()))
    parser.set_defaults(parser=parser)
    return parser
