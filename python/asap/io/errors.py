"""What can be wrong with a file, and the border where foreign libraries' errors become ours."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

MAX_RATIO = 1000  # decompressed to compressed, for what is beyond HARMLESS bytes
HARMLESS = 1 << 28


class UnsupportedFormat(ValueError):
    """No reader serves this format."""


class CorruptFile(ValueError):
    """A file that cannot be read, or not further: the message names the byte offset."""

    def __init__(self, path: Path, offset: int, fault: str) -> None:
        super().__init__(f"{path}: byte {offset}: {fault}")
        self.path = path
        self.offset = offset
        self.fault = fault

    def __reduce__(self) -> tuple[type[CorruptFile], tuple[Path, int, str]]:
        return type(self), (self.path, self.offset, self.fault)


class CutFile(CorruptFile):
    """A file that ends so early that nothing of it can be read."""


class MissingLibrary(RuntimeError):
    """What reads or unpacks the file is not installed."""


class NoGoodEvent(ValueError):
    """A file of which not one event is good: columns, sensor or unit are not what was said."""


class LossWarning(UserWarning):
    """Events of the file were dropped, or do not come as they were."""


class TruncatedFileWarning(LossWarning):
    """The file ends too early, or a packet in it cannot be read; the rest was read."""


def cut_file(path: Path, offset: int, format_name: str, fault: str) -> CutFile:
    """Say what is there of a file of which nothing can be read, and what helps."""
    size = path.stat().st_size
    what = f"nothing can be read of the {size} bytes that are there of this {format_name} file"
    return CutFile(path, offset, f"{fault}; {what}. Copy it again; a file never closed is lost")


def unclear_unit(path: Path, are_floats: bool) -> ValueError:
    """Return the question for a unit that only the user knows."""
    what, other = "whole numbers written as floats", "s"
    if not are_floats:
        what, other = "whole multiples of 1000", "ns"
    return ValueError(
        f"time_unit = None: the times of {path} are {what}; say time_unit='us' or "
        f"time_unit={other!r}"
    )


def refuse_bomb(path: Path, offset: int, what: str, promised: int, stored: int) -> None:
    """Raise where `stored` bytes promise more than any good file unpacks to."""
    if promised > max(HARMLESS, MAX_RATIO * stored):
        fault = f"{what} decompresses to {promised} bytes, more than {MAX_RATIO} times its size"
        raise CorruptFile(path, offset, fault)


def library(name: str, what: str, extra: str) -> Any:
    """Import the library that reads `what`, or say how to install it."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        package = name.partition(".")[0]
        raise MissingLibrary(
            f"{what} needs the package {package}: pip install 'asap-events[{extra}]'"
        ) from error


@contextmanager
def foreign(path: Path, offset: int = 0) -> Iterator[None]:
    """Turn whatever a library raises into `CorruptFile`, panics outside ``Exception`` included.

    An OSError with a number and a file is the file system's, not the format's, and stays one.
    """
    try:
        yield
    except (CorruptFile, UnsupportedFormat, MissingLibrary):
        raise
    except (KeyboardInterrupt, SystemExit, GeneratorExit):
        raise
    except BaseException as error:
        if isinstance(error, OSError) and error.errno and error.filename:
            raise
        raise CorruptFile(path, offset, str(error) or type(error).__name__) from error
