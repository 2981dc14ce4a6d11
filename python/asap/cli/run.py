"""``asap run``: a recording through a closed loop, in real or in virtual time."""

from __future__ import annotations

from contextlib import nullcontext
from typing import Any

import asap
from asap import _checks, _progress, _units
from asap.cli.choices import ALGORITHMS, algorithm_name, algorithm_of, scheme_of, schemes
from asap.cli.imported import failures_of
from asap.cli.options import (
    add_recording,
    add_report,
    add_verb,
    open_recording,
    run_file,
    typed,
)
from asap.cli.outcome import (
    OK,
    USAGE,
    Failure,
    need_report,
    reading,
    show,
    tell_doubt,
    usage,
    writing,
)


def add(verbs: Any) -> None:
    """Add the verb to the parser."""
    verb = add_verb(verbs, "run", _call, "run an algorithm on a recording, in closed loop")
    add_recording(verb)
    verb.add_argument(
        "--algorithm",
        type=algorithm_name,
        metavar="NAME|MODULE:NAME",
        help=f"{', '.join(sorted(ALGORITHMS))}; or your own, as package.module:name, from the "
        "current directory or Python's path: a class is made with (width, height), of an object "
        "process(events) is used, a callable is called (default: clusters)",
    )
    verb.add_argument(
        "--cost",
        type=typed(_units.parse_cost, "cost"),
        metavar="100us+300ns",
        help="virtual time: an algorithm that takes this per package + per event",
    )
    verb.add_argument(
        "--opaque",
        action="store_true",
        help="with --cost: the algorithm takes a package as a whole, as a Python callback does",
    )
    verb.add_argument("--scheme", choices=schemes(), help="default: deadline")
    verb.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        dest="settings",
        help="a parameter of the scheme, for example rate_bound=5e6; repeatable",
    )
    verb.add_argument(
        "--latency",
        type=typed(_units.parse_duration_us, "latency"),
        metavar="10ms",
        help="latency bound (default: the scheme's own, else 10ms)",
    )
    verb.add_argument(
        "--speed", type=float, default=1.0, help="of the replay (default: 1, as recorded)"
    )
    verb.add_argument("--seed", type=int, default=0, help="of the gamma filter (default: 0)")
    add_report(verb)
    verb.add_argument(
        "--save",
        type=run_file,
        metavar="RUN.npz",
        help="keep the run, for asap report: .npz log and summary, .json the summary alone",
    )


def _call(arguments: Any) -> int:
    if arguments.opaque and not arguments.cost:
        raise Failure(USAGE, "--opaque: needs --cost, the simulated algorithm that it describes")
    if arguments.cost and arguments.speed != 1.0:
        raise Failure(USAGE, "--speed: not with --cost; only a replay in real time has a speed")
    if arguments.report:
        need_report()
    with usage():
        scheme = scheme_of(arguments.scheme, arguments.settings)
        cost = asap.LinearCost(*arguments.cost) if arguments.cost else None
    with reading(arguments):
        recording = open_recording(arguments)
    if arguments.save:
        with usage():
            _checks.other_file("--save", arguments.save, recording.path)
    name = arguments.algorithm or (None if cost else "clusters")
    with usage():
        algorithm = algorithm_of(name, recording) if name else None
    options: dict[str, Any] = {
        "algorithm": algorithm,
        "scheme": scheme,
        "latency_ms": None if arguments.latency is None else arguments.latency / 1e3,
        "on_bad": arguments.on_bad,
        "seed": arguments.seed,
    }
    own = failures_of(name, algorithm) if name and ":" in name else nullcontext()
    with reading(arguments), own, _progress.on_terminal() as on_progress:
        if cost is not None:
            options["opaque"] = arguments.opaque
            run = asap.simulate(recording, cost=cost, on_progress=on_progress, **options)
        else:
            run = asap.run(recording, speed=arguments.speed, on_progress=on_progress, **options)
    tell_doubt(recording)
    if arguments.save:
        with writing(arguments.save):
            run.save(arguments.save)
    show(run, arguments, arguments.save)
    return OK
