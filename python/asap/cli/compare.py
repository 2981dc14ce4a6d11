"""``asap compare``: every scheme on the same recording, beside the oracle."""

from __future__ import annotations

from typing import Any

import asap
from asap import _progress, _units
from asap.cli.options import add_recording, add_report, add_verb, open_recording, typed
from asap.cli.outcome import OK, USAGE, Failure, need_report, reading, show, usage


def add(verbs: Any) -> None:
    """Add the verb to the parser."""
    verb = add_verb(verbs, "compare", _call, "every scheme on the same events, beside the oracle")
    add_recording(verb)
    verb.add_argument(
        "--cost",
        type=typed(_units.parse_cost, "cost"),
        metavar="100us+300ns",
        help="required: what the algorithm takes per package + per event, as asap run estimates it "
        "for yours",
    )
    verb.add_argument(
        "--latency",
        type=typed(_units.parse_duration_us, "latency"),
        metavar="10ms",
        help="latency bound of all (default: 10ms)",
    )
    verb.add_argument(
        "--opaque",
        action="store_true",
        help="the algorithm takes a package as a whole, as a Python callback does",
    )
    verb.add_argument(
        "--speed",
        type=float,
        default=1.0,
        help="compress the stamps: 10 makes a quiet recording ten times as busy (default: 1)",
    )
    verb.add_argument("--seed", type=int, default=0, help="of the gamma filter (default: 0)")
    add_report(verb)


def _call(arguments: Any) -> int:
    if arguments.cost is None:
        raise Failure(
            USAGE,
            "--cost is missing: give what the algorithm takes per package + per event, such as "
            "100us+300ns; the verdict of asap run estimates it for yours",
        )
    if arguments.report:
        need_report()
    with usage():
        cost = asap.LinearCost(*arguments.cost)
    with reading(arguments), _progress.on_terminal() as on_progress:
        comparison = asap.compare(
            open_recording(arguments),
            cost=cost,
            latency_ms=None if arguments.latency is None else arguments.latency / 1e3,
            seed=arguments.seed,
            opaque=arguments.opaque,
            speed=arguments.speed,
            on_bad=arguments.on_bad,
            on_progress=on_progress,
        )
    show(comparison, arguments)
    return OK
