"""Schemes and algorithms: ours by name, the user's own by ``package.module:name``."""

from __future__ import annotations

import argparse
import importlib
import inspect
import os
import sys
import textwrap
import traceback
from collections.abc import Collection, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from operator import attrgetter
from pathlib import Path
from typing import Any, NamedTuple

import asap
from asap import _checks, _core
from asap.cli.options import latency_ms
from asap.cli.outcome import CHECK_FAILED, USAGE, Failure, near

SCHEMES = {kind().name: kind for kind in _core.SCHEMES}
ALGORITHMS = {kind.name: kind.__name__ for kind in _core.ALGORITHMS}

FILTERS = tuple(kind.name for kind in _core.FILTERS)

Setting = tuple[str, int | float | str]


def setting(text: str) -> Setting:
    """Parse NAME=VALUE; the scheme itself refuses what it does not take."""
    name, equals, value = text.partition("=")
    if not (name and equals):
        raise argparse.ArgumentTypeError(f"{text}: write NAME=VALUE")
    for kind in (int, float):
        try:
            return name, kind(value)
        except ValueError:
            pass
    return name, value


def scheme_of(name: str | None, settings: Sequence[Setting]) -> asap.Scheme | None:
    """Make the scheme with its parameters; None leaves the choice to the library."""
    if name is None and not settings:
        return None
    return SCHEMES[name or "deadline"](**dict(settings))


class Chosen(NamedTuple):
    """An algorithm or filter: one of ours by name or ``package.module:name``, and parameters."""

    name: str
    parameters: dict[str, int | float | str]
    is_own: bool


def chosen(text: str, known: Collection[str] = ALGORITHMS) -> Chosen:
    """Parse ``NAME``, ``NAME:parameter=value,...``, and either with ``package.module:name``."""
    name, _, settings = text.rpartition(":")
    if not (name and "=" in settings):
        name, settings = text, ""
    module, colon, inner = name.partition(":")
    if not (module and inner if colon else name in known):
        words = f"{text}: give one of {', '.join(sorted(known))}, or package.module:name"
        words += near(name, list(known))
        raise argparse.ArgumentTypeError(words)
    return Chosen(name, dict(setting(one) for one in settings.split(",") if one), bool(colon))


def algorithm_of(
    chosen: Chosen, recording: asap.Recording | asap.Camera, threads: int | None = None
) -> Any:
    """Make the algorithm for the sensor of a source; import it if it is the user's own."""
    name = chosen.name
    found = _imported(name) if chosen.is_own else getattr(asap, ALGORITHMS[name])
    if chosen.is_own and not isinstance(found, type):
        if chosen.parameters or threads is not None:
            raise Failure(USAGE, f"{name}: is no class, so it takes no parameters")
        return found
    width, height = recording.width, recording.height
    if not (width and height):
        raise Failure(
            USAGE,
            f"{getattr(recording, 'path', recording)}: sensor = unknown: {name} needs its size. "
            "Give --width and --height; asap info shows how far the events reach",
        )
    try:
        if threads is not None:
            return asap.Tiled(found, width, height, threads=threads, **chosen.parameters)
        return found(width, height, **chosen.parameters)
    except Exception as error:
        if not chosen.is_own:
            raise
        raise _failed(USAGE, name) from error


def described() -> str:
    """List the built-in algorithms and what each takes, as ``asap run --help algorithm`` does."""
    lines = ["Algorithms and filters, for --algorithm and --before as NAME:PARAMETER=VALUE,...", ""]
    for name, kind in ALGORITHMS.items():
        _, _, *given = inspect.signature(getattr(asap, kind)).parameters.values()
        takes = ", ".join(f"{one.name}={one.default}" for one in given)
        lines += [f"{name}  (asap.{kind})", textwrap.indent(textwrap.fill(takes, 74), " " * 4)]
    return "\n".join(
        [*lines, "", "Your own class takes them as package.module:name:PARAMETER=VALUE."]
    )


class Workers(NamedTuple):
    """What a run of the command line is given to work with."""

    algorithm: Any
    before: Any
    tracks: asap.Tracks | None
    own: AbstractContextManager[None]  # of the user's own code, if the algorithm is that


def workers_of(
    arguments: Any, source: asap.Recording | asap.Camera, *, default: str | None
) -> Workers:
    """Make what ``--algorithm``, ``--before``, ``--tracks`` and ``--every`` ask for."""
    name = arguments.algorithm or (chosen(default) if default else None)
    algorithm = algorithm_of(name, source, arguments.threads) if name else None
    before = algorithm_of(arguments.before, source) if arguments.before else None
    tracks = None
    if arguments.tracks:
        _checks.ending("--tracks", arguments.tracks, (".csv",), "give a name that ends in .csv")
    if arguments.tracks or arguments.video:
        every_ms = arguments.every / 1e3 if arguments.every else None
        algorithm = tracks = asap.Tracks(algorithm, every_ms=every_ms)
    own = own_code(name.name) if name and name.is_own else nullcontext()
    return Workers(algorithm, before, tracks, own)


def run_options(arguments: Any, scheme: asap.Scheme | None, workers: Workers) -> dict[str, Any]:
    """Return what every run of the command line is told, in real or in virtual time."""
    return {
        "algorithm": workers.algorithm,
        "before": workers.before,
        "scheme": scheme,
        "latency_ms": latency_ms(arguments),
        "on_bad": arguments.on_bad,
        "seed": arguments.seed,
        "execution": arguments.execution,
    }


class Help(argparse.Action):
    """``--help``, or ``--help algorithm``: the topic instead of the options."""

    def __call__(self, parser: argparse.ArgumentParser, _: Any, topic: Any, *__: Any) -> None:
        """Print and end."""
        print(described() if topic == "algorithm" else parser.format_help())
        parser.exit()


def _imported(spec: str) -> Any:
    """Import ``package.module:name``, the current directory first; the name may have dots."""
    module, _, name = spec.partition(":")
    here = os.getcwd()
    if not getattr(sys.flags, "safe_path", False) and sys.path[:1] not in ([here], [""]):
        sys.path.insert(0, here)  # stays: the module may import later
    try:
        imported = importlib.import_module(module)
        try:
            found = attrgetter(name)(imported)
        except AttributeError as error:
            words = f"{module} has no {name}{near(name, vars(imported).keys())}"
            raise Failure(USAGE, f"--algorithm {spec}: {words}") from error
        if not isinstance(found, type):
            _checks.worker("algorithm", found)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{module}.".startswith(f"{error.name}."):
            raise _failed(USAGE, spec) from error  # of what the module imports
        words = f"there is no module {error.name} in {here} or on Python's path"
        words += near(error.name, [file.stem for file in Path(here).glob("*.py")])
        raise Failure(USAGE, f"--algorithm {spec}: {words}") from error
    except Failure:
        raise
    except Exception as error:
        raise _failed(USAGE, spec) from error
    return found


@contextmanager
def own_code(spec: str) -> Iterator[None]:
    """Show the traceback of an error that passed the user's own module; others are not its."""
    package = spec.partition(":")[0].partition(".")[0]
    try:
        yield
    except Exception as error:
        frames = (frame for frame, _ in traceback.walk_tb(error.__traceback__))
        passed = {str(frame.f_globals.get("__name__")).partition(".")[0] for frame in frames}
        if package not in passed - {"asap"}:
            raise
        raise _failed(CHECK_FAILED, spec) from error


def _failed(code: int, spec: str) -> Failure:
    return Failure(code, f"--algorithm {spec} failed:\n{traceback.format_exc().rstrip()}")
