"""A user's own algorithm by ``package.module:name``, as ``asap run --algorithm`` takes it."""

from __future__ import annotations

import importlib
import os
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType, TracebackType
from typing import Any

from asap import _checks
from asap.cli.outcome import CHECK_FAILED, USAGE, Failure, say
from asap.cli.parser import hint


def imported(spec: str, width: int | None, height: int | None) -> Any:
    """Import ``package.module:name``, the current directory first; construct it if it is a class.

    The name may have dots, as in ``module:Outer.Inner``. A class is constructed with width and
    height.
    """
    module_name, _, path = spec.partition(":")
    if not (module_name and path):
        raise Failure(USAGE, f"--algorithm {spec}: write package.module:name")
    module = _module(spec, module_name)
    found = _attribute(spec, module, path)
    if isinstance(found, type):
        if not (width and height):
            raise Failure(
                USAGE, f"--algorithm {spec}: the class is made for a sensor; give --width, --height"
            )
        try:
            found = found(width, height)
        except Exception as error:
            words = f"{path}({width}, {height}) in {_where(module)} failed: {_said(error)}"
            raise Failure(USAGE, f"--algorithm {spec}: {words}") from error
    if not (hasattr(found, "process") or callable(found)):
        words = f"in {_where(module)} it is neither callable nor has process(events)"
        raise Failure(USAGE, f"--algorithm {spec}: {words}")
    try:
        _checks.worker("algorithm", found)
    except TypeError as error:
        raise Failure(USAGE, f"--algorithm {spec} in {_where(module)}: {error}") from error
    return found


@contextmanager
def failures_of(spec: str, algorithm: Any) -> Iterator[None]:
    """Tell an error of the user's own code from one of the recording or of the options."""
    homes = [spec.partition(":")[0], type(algorithm).__module__]
    homes.append(getattr(algorithm, "__module__", None) or homes[0])
    packages = {home.partition(".")[0] for home in homes} - {"asap", "builtins", "functools"}
    try:
        yield
    except Exception as error:
        own = error.__traceback__
        while own is not None and _package(own) not in packages:
            own = own.tb_next
        if own is None:
            raise
        text = "".join(traceback.format_exception(type(error), error, own)).rstrip()
        say(f"the algorithm failed:\n{text}")
        raise Failure(CHECK_FAILED, f"--algorithm {spec}: {_said(error)}") from error


def _module(spec: str, name: str) -> ModuleType:
    here = os.getcwd()
    if not getattr(sys.flags, "safe_path", False) and sys.path[:1] not in ([here], [""]):
        sys.path.insert(0, here)  # stays: the module may import later
    importlib.invalidate_caches()
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{name}.".startswith(f"{error.name}."):
            raise _unimportable(spec, name, error) from error
        raise Failure(
            USAGE,
            f"--algorithm {spec}: there is no module {error.name} in {here} or on Python's path",
        ) from error
    except Exception as error:
        raise _unimportable(spec, name, error) from error


def _unimportable(spec: str, name: str, error: Exception) -> Failure:
    return Failure(USAGE, f"--algorithm {spec}: importing {name} failed: {_said(error)}")


def _attribute(spec: str, module: ModuleType, path: str) -> Any:
    found: Any = module
    for name in path.split("."):
        try:
            found = getattr(found, name)
        except AttributeError as error:
            known = [one for one in vars(found) if not one.startswith("_")]
            near = hint(name, known, "it has") if known else "it is empty"
            words = f"{_where(module)} has no {name}; {near}"
            raise Failure(USAGE, f"--algorithm {spec}: {words}") from error
    return found


def _where(module: ModuleType) -> str:
    return f"module {module.__name__} ({getattr(module, '__file__', None) or 'built in'})"


def _said(error: Exception) -> str:
    """Kind, message and, where a frame of the user's own code is known, its line."""
    own = _own(error.__traceback__)
    frames = traceback.extract_tb(own)
    at = f" ({frames[-1].filename}:{frames[-1].lineno})" if frames else ""
    return f"{type(error).__name__}: {' '.join(str(error).split())}{at}"


def _own(frames: TracebackType | None) -> TracebackType | None:
    """Find the first frame that is neither asap's nor the import machinery's."""
    while frames is not None and _package(frames) in ("asap", "importlib"):
        frames = frames.tb_next
    return frames


def _package(frames: TracebackType) -> str:
    return str(frames.tb_frame.f_globals.get("__name__", "")).partition(".")[0]
