"""How a verb ends: exit codes, what is told on stderr, and the one object of ``--json``."""

from __future__ import annotations

import difflib
import importlib
import json
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import asap

OK, CHECK_FAILED, USAGE, BAD_INPUT, INTERRUPTED = 0, 1, 2, 3, 128  # and the signal's number


class Failure(Exception):
    """What the user is told, and the exit code."""

    def __init__(self, code: int, message: str) -> None:
        super().__init__(message)
        self.code = code


class Ended(KeyboardInterrupt):
    """A signal that ends a verb as Ctrl-C does."""

    number = signal.SIGINT


@contextmanager
def ended_by_signals() -> Iterator[None]:
    """Let SIGTERM and SIGHUP end what is done, but not what is then written."""

    def end(number: int, _: Any) -> None:
        for one in before:
            signal.signal(one, signal.SIG_IGN)
        ended = Ended()
        ended.number = signal.Signals(number)
        raise ended

    before: dict[signal.Signals, Any] = {}
    if threading.current_thread() is threading.main_thread():
        for one in (signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(one) != signal.SIG_IGN:  # as under nohup
                before[one] = signal.signal(one, end)
    try:
        yield
    finally:
        for one, handler in before.items():
            signal.signal(one, handler)


@contextmanager
def usage() -> Iterator[None]:
    """Turn what the user asked for and cannot have into wrong use."""
    try:
        yield
    except (TypeError, ValueError) as error:
        raise Failure(USAGE, str(error)) from error


@contextmanager
def reading(arguments: Any) -> Iterator[None]:
    """Tell input that cannot be read from options that contradict each other."""
    try:
        yield
    except (
        asap.io.UnsupportedFormat,
        asap.io.CorruptFile,
        asap.io.NoGoodEvent,
        RuntimeError,
    ) as error:
        raise Failure(BAD_INPUT, str(error)) from error
    except FileNotFoundError as error:
        name = os.fspath(error.filename or _first_file(arguments))
        raise Failure(BAD_INPUT, f"{name}: no such file{near_file(Path(name))}") from error
    except OSError as error:
        name = error.filename or _first_file(arguments)
        raise Failure(BAD_INPUT, f"{name}: {error.strerror or error}") from error
    except (TypeError, ValueError) as error:
        lenient = getattr(arguments, "on_bad", "raise") != "raise"
        raise Failure(USAGE if lenient else BAD_INPUT, str(error)) from error


def _first_file(arguments: Any) -> str:
    return str(getattr(arguments, "file", ["input"])[0])


def near_file(path: Path) -> str:
    """Ask for the file of the nearest name in the same folder; "" if there is none."""
    files = [one.name for one in path.parent.iterdir()] if path.parent.is_dir() else []
    return near(path.name, {name: path.parent / name for name in files})


def near(word: str, known: Iterable[str]) -> str:
    """Ask for the nearest of these words; "" if there is none. A mapping says how it is shown."""
    shown = known if isinstance(known, Mapping) else {one: one for one in known}
    found = difflib.get_close_matches(word, shown, n=1)
    return f"; did you mean {shown[found[0]]}?" if found else ""


@contextmanager
def writing(path: object) -> Iterator[None]:
    """Tell that a result cannot be written where the user wants it."""
    try:
        yield
    except OSError as error:  # on a full disk without a name
        raise Failure(USAGE, f"{error.filename or path}: {error.strerror or error}") from error
    except RuntimeError as error:  # of a program or a library that writes
        raise Failure(USAGE, str(error)) from error


def show(
    result: Any,
    arguments: Any,
    *files: tuple[Path | None, Callable[[Path], object]],
    written: tuple[Path | None, ...] = (),
) -> int:
    """Write the files of a result, and print it: a table, or the object of ``--json``.

    Return the exit code: what cannot be written is told, and keeps nothing else from being shown.
    """
    done: list[Path] = []
    failures: list[str] = []
    for path, write in files:
        if path is None:
            continue
        try:
            with writing(path):
                write(path)
            done.append(path)
        except Failure as failure:
            failures.append(str(failure))
    if arguments.json:
        print_json(result.summary())
    else:
        print(result)
        print_written(*done, *written)
    for words in failures:
        say(f"error: {words}")
    return USAGE if failures else OK


def code_of(result: Any) -> int:
    """Return the exit code of a run or a comparison; say so where there was nothing to judge."""
    if result.source["events"]:
        return OK
    say("error: no event was received")
    return BAD_INPUT


def hand_over(run: Any, arguments: Any, tracks: Any, *written: Path | None) -> int:
    """Write what ``--save``, ``--tracks``, ``--video`` and ``--report`` ask for; show the run."""
    files = [
        (arguments.save, run.save),
        (arguments.video, run.animate),
        (arguments.report, run.report),
    ]
    if tracks is not None:
        files.insert(1, (arguments.tracks, tracks.save))
    return show(run, arguments, *files, written=written) or code_of(run)


def need_report() -> None:
    """Say that a page cannot be written before the run, not after it."""
    _needed("asap.plots")
    _needed("asap.results.page")


def need_video(path: Path) -> None:
    """Say that a video cannot be written before the run, not after it."""
    animation = _needed("asap.viewer.animation")
    with usage(), writing(path):
        animation.check_name(path)


def _needed(module: str) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise Failure(USAGE, str(error)) from error


def print_json(value: dict[str, Any]) -> None:
    """Print the one object of ``--json``."""
    print(json.dumps(value, indent=2))


def print_written(*paths: Path | None) -> None:
    """Name the files that were written, in their order."""
    for path in paths:
        if path is not None:
            print(f"wrote {path}")


def say(message: str) -> None:
    """Tell the user something that is no result."""
    if sys.stderr is None:  # closed; print would take stdout
        return
    with suppress(OSError):  # the terminal has gone
        print(f"asap: {message}", file=sys.stderr)


def tell_doubt(recording: Any) -> None:
    """Warn where fewer than half of the events were good."""
    if (doubt := recording._doubt) is not None:
        say(f"warning: {doubt}")
