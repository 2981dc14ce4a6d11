"""``asap study``: the door to the laboratory, a distribution of its own."""

from __future__ import annotations

import argparse
import importlib.util
from pathlib import Path
from typing import Any

from asap.cli.options import add_out, add_verb
from asap.cli.outcome import USAGE, Failure


def add(verbs: Any) -> None:
    """Add the verb to the parser."""
    words = "every scheme over all scenarios, against the goals; less than 30 minutes on two cores"
    verb = add_verb(verbs, "study", _call, words)
    form = verb.add_mutually_exclusive_group()
    form.add_argument("--quick", action="store_true", help="a part, in less than 2 minutes")
    form.add_argument(
        "--full", action="store_true", help="three seeds, rows with hindsight; less than 90 minutes"
    )
    form.add_argument(
        "--realtime", action="store_true", help="the simulator beside this machine's clock instead"
    )
    verb.add_argument(
        "--accuracy", action="store_true", help="scores of the algorithms over gamma instead"
    )
    verb.add_argument(
        "--rivals", action="store_true", help="the cluster tracker beside its rivals instead"
    )
    verb.add_argument(
        "--ladder", action="store_true", help="every consumer under every scheme instead"
    )
    words = (
        "the cluster tracker on recordings with boxes instead: their folders, or a folder of them"
    )
    verb.add_argument("--real", nargs="*", type=Path, metavar="FOLDER", help=words)
    add_out(verb, "asap-study")
    verb.add_argument("--workers", type=_workers, metavar="N", help="processes (default: cores)")
    verb.add_argument("--fresh", action="store_true", help="forget what DIR holds of earlier runs")


def _workers(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text}: give a number of processes, at least 1")
    return int(text)


def _call(arguments: Any) -> int:
    if importlib.util.find_spec("asap_laboratory") is None:
        words = "asap study: needs the laboratory; pip install ./python/laboratory from a checkout"
        raise Failure(USAGE, words)
    code: int = importlib.import_module("asap_laboratory.cli").conduct(arguments)
    return code
