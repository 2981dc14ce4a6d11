"""The parser of the command line: errors on one line, with the nearest name that exists."""

from __future__ import annotations

import argparse
import difflib
import sys
from collections.abc import Iterable, Sequence
from typing import Any, NoReturn

from asap.cli.outcome import USAGE, say


def hint(name: str, known: Iterable[str], words: str = "choose from") -> str:
    """Name the nearest of the known names; all of them where none is near."""
    known = list(known)
    near = difflib.get_close_matches(name, known, n=1)
    return f"did you mean {near[0]}?" if near else f"{words} {', '.join(known)}"


class Parser(argparse.ArgumentParser):
    """An ArgumentParser whose errors take one line and name what is near."""

    def error(self, message: str) -> NoReturn:
        """Say what is wrong on one line of stderr; exit code 2."""
        say(f"error: {' '.join(message.split())} (see {self.prog} --help)")
        sys.exit(USAGE)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Refuse an unknown option by name, before argparse misses what its value should be."""
        args = sys.argv[1:] if args is None else list(args)
        for name in self._names(args):
            if not any(known.startswith(name) for known in self._option_string_actions):
                self.error(f"unknown option {name}; {self._nearest_option(name)}")
        return super().parse_known_args(args, namespace)

    def _names(self, args: Sequence[str]) -> Iterable[str]:
        for text in args:
            is_name = text.startswith("--")
            if text == "--" or (self._subparsers is not None and not text.startswith("-")):
                return  # what follows a verb is its own matter
            if is_name:
                yield text.partition("=")[0]

    def _nearest_option(self, name: str) -> str:
        known = [one for one in self._option_string_actions if one.startswith("--")]
        return hint(name, known, "there are")

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            raise argparse.ArgumentError(
                action, f"invalid choice: {value!r}; {hint(str(value), map(str, action.choices))}"
            )
