"""``asap compare``: every scheme on the same recording or profile, beside the oracle."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import asap
from asap import _progress, _units, profiles
from asap.cli.options import add_recording, add_report, add_verb, open_recording, typed
from asap.cli.outcome import (
    BAD_INPUT,
    OK,
    USAGE,
    Failure,
    near_file,
    need_matplotlib,
    reading,
    show,
    usage,
)
from asap.cli.parser import hint

_RECORDING_COST_S = 60.0  # for which drift and outages are drawn where the duration is not known


class _Named(NamedTuple):
    """A cost model by name."""

    name: str


def add(verbs: Any) -> None:
    """Add the verb to the parser."""
    verb = add_verb(verbs, "compare", _call, "every scheme on the same events, beside the oracle")
    add_recording(
        verb,
        metavar="FILE|PROFILE",
        words="a recording, as for asap info; or event rates over time by name: "
        f"{', '.join(profiles.PROFILES)}",
    )
    verb.add_argument(
        "--cost",
        type=typed(_parse_cost, "cost"),
        metavar="100us+300ns",
        help="required: what the algorithm takes per package + per event, as asap run estimates it "
        "for yours, or a model of the study: "
        f"{', '.join(profiles.COSTS)}",
    )
    verb.add_argument(
        "--latency",
        type=typed(_units.parse_duration_us, "latency"),
        metavar="10ms",
        help="latency bound of all (default: that of the cost model, else 10ms)",
    )
    verb.add_argument("--all", action="store_true", help="the baselines of the study too")
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
    verb.add_argument(
        "--duration",
        type=typed(_units.parse_duration_us, "duration"),
        metavar="2s",
        help="of a profile (default: 5s; with a cost model by name, that of the study)",
    )
    verb.add_argument(
        "--seed", type=int, default=0, help="of profile, cost and gamma filter (default: 0)"
    )
    add_report(verb)


def _call(arguments: Any) -> int:
    if arguments.cost is None:
        raise Failure(
            USAGE,
            "--cost is missing: give what the algorithm takes per package + per event, such as "
            "100us+300ns; the verdict of asap run estimates it for yours",
        )
    if arguments.report:
        need_matplotlib()
    source, cost, latency_ms = _contest(arguments)
    if arguments.latency is not None:
        latency_ms = arguments.latency / 1e3
    with reading(arguments), _progress.on_terminal() as on_progress:
        comparison = asap.compare(
            source,
            cost=cost,
            latency_ms=latency_ms,
            seed=arguments.seed,
            opaque=arguments.opaque,
            speed=arguments.speed,
            on_bad=arguments.on_bad,
            baselines=arguments.all,
            on_progress=on_progress,
        )
    show(comparison, arguments)
    return OK


def _contest(arguments: Any) -> tuple[Any, asap.LinearCost, float | None]:
    """Find what is compared: the source, the simulated algorithm, the latency that goes with it."""
    profile = arguments.file if arguments.file in profiles.PROFILES else None
    if profile is None or Path(arguments.file).exists():
        return _recording(arguments)
    size = {name: getattr(arguments, name) for name in ("width", "height")}
    given = {name: value for name, value in size.items() if value is not None}
    if arguments.duration is not None:
        given["duration_s"] = arguments.duration / 1e6
    with usage():
        if isinstance(arguments.cost, _Named):
            return profiles.scenario(profile, arguments.cost.name, seed=arguments.seed, **given)
        source = profiles.Profile(profile, seed=arguments.seed, **given)
        return source, asap.LinearCost(*arguments.cost), None


def _recording(arguments: Any) -> tuple[Any, asap.LinearCost, float | None]:
    if not Path(arguments.file).exists():
        raise Failure(*_not_found(arguments.file))
    if arguments.duration is not None:
        raise Failure(USAGE, "--duration: only a profile has one; a recording is used whole")
    with reading(arguments):
        recording = open_recording(arguments)
    with usage():
        if not isinstance(arguments.cost, _Named):
            return recording, asap.LinearCost(*arguments.cost), None
        name = arguments.cost.name
        cost = profiles.cost(name, seed=arguments.seed, duration_s=_RECORDING_COST_S)
        return recording, cost, profiles.LATENCY_MS[name]


def _not_found(text: str) -> tuple[int, str]:
    """Tell a profile that is not there from a file that is not, with what is near."""
    path = Path(text)
    if path.suffix or len(path.parts) > 1:
        return BAD_INPUT, f"{text}: no such file{near_file(path)}"
    near_profile = hint(text, profiles.PROFILES, "profiles are")
    return USAGE, f"{text}: neither a file nor a profile; {near_profile}"


def _parse_cost(text: str, *, field: str) -> tuple[float, float] | _Named:
    if text in profiles.COSTS:
        return _Named(text)
    if text.replace("_", "").isalpha():
        near = hint(text, profiles.COSTS, "there are")
        raise ValueError(f"{field} = {text}: no such cost model; {near}")
    return _units.parse_cost(text, field=field)
