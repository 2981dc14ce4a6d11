"""``asap completion``: a script that completes verbs, options and their choices in a shell.

Written out from the parser, so that completing takes no Python and no extra.
"""

from __future__ import annotations

import argparse
import shlex
from typing import Any

from asap.cli.choices import ALGORITHMS
from asap.cli.options import add_verb
from asap.cli.outcome import OK, print_json

_BASH = """\
# eval "$(asap completion bash)"
_asap() {{
  local word="${{COMP_WORDS[COMP_CWORD]}}" before="${{COMP_WORDS[COMP_CWORD-1]}}" found
  local verb="${{COMP_WORDS[1]}}" at="$COMP_CWORD"
{cases}
  COMPREPLY=($(compgen -W "$found" -- "$word"))
}}
complete -o default -F _asap asap
"""

_ZSH = """\
#compdef asap
# eval "$(asap completion zsh)", after compinit
_asap() {{
  local word="${{words[CURRENT]}}" before="${{words[CURRENT-1]}}" found
  local verb="${{words[2]}}" at=$((CURRENT - 1))
{cases}
  compadd -- ${{=found}} || _files
}}
compdef _asap asap
"""

_SHELLS = {"bash": _BASH, "zsh": _ZSH}

# Names that are not argparse's choices, because others are allowed too.
_ALSO = {("run", "--algorithm"): sorted(ALGORITHMS)}


def add(verbs: Any) -> None:
    """Add the verb to the parser."""
    verb = add_verb(verbs, "completion", _call, "a script that completes asap in a shell")
    verb.add_argument("shell", choices=tuple(_SHELLS), help="of bash or of zsh")
    verb.set_defaults(verbs=verbs)


def _call(arguments: Any) -> int:
    script = _SHELLS[arguments.shell].format(cases=_cases(arguments.verbs.choices))
    if arguments.json:
        print_json({"schema_version": 1, "shell": arguments.shell, "script": script})
    else:
        print(script, end="")
    return OK


def _cases(verbs: dict[str, argparse.ArgumentParser]) -> str:
    """Branch on verb, word before and word: what both shells write alike."""
    lines = [
        '  if [ "$at" -eq 1 ]; then',
        f"    found={shlex.quote(' '.join([*verbs, '--help', '--version']))}",
        "  else",
        '    case "$verb $before" in',
    ]
    for verb, parser in verbs.items():
        for action in parser._actions:
            for option in action.option_strings:
                if (words := _values(verb, option, action)) is not None:
                    lines.append(f'      "{verb} {option}") found={shlex.quote(words)} ;;')
    lines += ['      *) case "$verb $word" in']
    for verb, parser in verbs.items():
        options = " ".join(parser._option_string_actions)
        others = " ".join(_choices(parser))
        lines.append(f'        "{verb} -"*) found={shlex.quote(options)} ;;')
        lines.append(f'        "{verb} "*) found={shlex.quote(others)} ;;')
    return "\n".join([*lines, "      esac ;;", "    esac", "  fi"])


def _values(verb: str, option: str, action: argparse.Action) -> str | None:
    """List what may follow an option; "" is anything, such as a file; None: it takes no value."""
    if action.nargs == 0:
        return None
    return " ".join(map(str, _ALSO.get((verb, option), action.choices or ())))


def _choices(parser: argparse.ArgumentParser) -> list[str]:
    return [
        str(choice)
        for action in parser._get_positional_actions()
        for choice in action.choices or ()
    ]
