"""What an argument has to be, said once: a refusal names the field, its value and the remedy.

As core/check.hpp and the bindings do it for what is native: ValueError for a value out of range,
TypeError for one of the wrong kind. An error of the argument itself comes out unchanged.
"""

from __future__ import annotations

import errno
import inspect
import math
import operator
import os
import stat
import sys
from collections.abc import AsyncIterable, Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

_LONGEST = 200
_WIDEST = 65536  # px
_AWAIT = (
    "asap awaits nothing; give a plain {kind}, and from a coroutine call asap in a thread: "
    "await asyncio.to_thread(...)"
)
_UNMASK = "take out or repair what is masked, and give array.data"


def named(field: str, value: Any, remedy: str) -> str:
    """Field, value and remedy in one line; a value that cannot be shown is told by its type."""
    try:
        text = " ".join(repr(value).split())
    except Exception:  # a whole number may have too many digits to be written
        text = f"<{type(value).__name__}>"
    return f"{field} = {text if len(text) <= _LONGEST else text[:_LONGEST] + '...'}: {remedy}"


def require(ok: bool, field: str, value: Any, remedy: str) -> None:
    """Refuse a value that is not ok."""
    if not ok:
        raise ValueError(named(field, value, remedy))


def number(field: str, value: Any, low: float, high: float, remedy: str) -> float:
    """Return it as a float; refuse what is no number, or none from low to high."""
    try:
        in_range = None if getattr(value, "shape", ()) else bool(low <= value <= high)
        found = float(value) if in_range else math.nan
    except (TypeError, ValueError):  # None, text
        in_range = None
    except ArithmeticError:  # a decimal that is not a number
        in_range = False
    if in_range is None:
        raise TypeError(named(field, value, "give a number"))
    require(in_range, field, value, remedy)
    return found


def index(field: str, value: Any) -> int:
    """Refuse what is no whole number."""
    try:
        return operator.index(value)
    except TypeError:
        raise TypeError(named(field, value, "give a whole number")) from None


def whole(field: str, value: Any, low: int, high: int, remedy: str) -> None:
    """Refuse what is no whole number, or none from low to high."""
    require(low <= index(field, value) <= high, field, value, remedy)


def sides(width: Any, height: Any) -> tuple[int | None, int | None]:
    """Refuse what is no side of a sensor in px; None: not known. NumPy's numbers become int."""
    return (
        None if width is None else _side("width", width),
        None if height is None else _side("height", height),
    )


def _side(field: str, value: Any) -> int:
    side = index(field, value)
    remedy = f"give the sensor's {field} in pixels, at most {_WIDEST}, or 0 for no check"
    require(0 <= side <= _WIDEST, field, side, remedy)
    return side


def sensor(width: Any, height: Any, known: Any, source: object) -> tuple[int | None, int | None]:
    """Return the sides that are given or that `known` states; refuse a contradiction."""
    given = sides(width, height)
    stated = sides(getattr(known, "width", None), getattr(known, "height", None))
    return (
        _agreed("width", given[0], stated[0], source),
        _agreed("height", given[1], stated[1], source),
    )


def _agreed(field: str, given: int | None, stated: int | None, source: object) -> int | None:
    """Return the side that is known; refuse a given one that the source contradicts."""
    if given and stated and given != stated:
        raise ValueError(named(field, given, f"{source} states {stated}; leave {field} out"))
    return given if stated is None else stated


def listed(field: str, values: Any) -> list[Any]:
    """Refuse what holds no values, or gives them only once."""
    try:
        len(values)  # a generator has none
        found = list(values)
    except TypeError:
        raise TypeError(named(field, values, "give a list")) from None
    require(bool(found), field, values, "give at least one")
    return found


def flag(field: str, value: Any) -> None:
    """Refuse what is neither true nor false by itself, such as a text or an array."""
    is_one = value is None or (hasattr(type(value), "__bool__") and not getattr(value, "shape", ()))
    if not is_one:
        raise TypeError(named(field, value, "give True or False"))


def choice(field: str, value: Any, choices: Iterable[str]) -> None:
    """Refuse what is none of these texts."""
    choices = tuple(choices)
    is_one = isinstance(value, str) and value in choices
    require(is_one, field, value, f"give one of {', '.join(choices)}")


def callback(field: str, value: Any) -> None:
    """Refuse what cannot be called, unless it is None, and what has to be awaited."""
    if value is not None and not callable(value):
        raise TypeError(named(field, value, "give a callable or None"))
    if _is_async(value):
        raise TypeError(named(field, value, _AWAIT.format(kind="function")))


def is_camera(source: Any) -> bool:
    """Whether it feeds a pipeline by itself; `asap.camera` is above this module."""
    return hasattr(type(source), "_feed")


def source(value: Any) -> None:
    """Refuse a camera, and a stream that has to be awaited, before anything of it is read."""
    if is_camera(value):
        remedy = "a camera is no recording; use asap.run, or write one with camera.record(path)"
        raise TypeError(named("source", value, remedy))
    if isinstance(value, AsyncIterable) or inspect.isawaitable(value) or _is_async(value):
        raise TypeError(named("source", value, _AWAIT.format(kind="iterable of arrays")))


def worker(field: str, value: Any) -> None:
    """Refuse an algorithm or a filter that is a class, or that has to be awaited."""
    methods = [getattr(value, name, None) for name in ("process", "set_gamma")]
    if inspect.isawaitable(value) or any(_is_async(one) for one in (value, *methods)):
        raise TypeError(named(field, value, _AWAIT.format(kind="function or process(events)")))
    if isinstance(value, type) and hasattr(value, "process"):
        raise TypeError(
            named(field, value, f"give an object of it, such as {value.__name__}(346, 260)")
        )
    works = methods[0] if callable(methods[0]) else value
    if _is_a(inspect.isgeneratorfunction, works):
        raise TypeError(named(field, value, "its yield makes a call do nothing; take it out"))
    if callable(works) and not _takes_one(works):
        raise TypeError(named(field, value, "takes no array of events; give it one parameter"))


def workers(**given: Any) -> None:
    """Refuse by its name what `worker` refuses."""
    for field, value in given.items():
        worker(field, value)


def _is_async(function: Any) -> bool:
    """Whether a call gives what has to be awaited."""
    return _is_a(inspect.iscoroutinefunction, function) or _is_a(
        inspect.isasyncgenfunction, function
    )


def _is_a(kind: Callable[[Any], bool], function: Any) -> bool:
    """Whether it is a function of that kind; looks through partials and at __call__."""
    while isinstance(function, partial):
        function = function.func
    return kind(function) or kind(getattr(type(function), "__call__", None))  # noqa: B004


def _takes_one(function: Callable[..., Any]) -> bool:
    """Whether it can be called with one argument, as far as it says what it takes."""
    try:
        inspect.signature(function).bind(None)
    except ValueError:  # native code that does not say it
        return True
    except TypeError:
        return False
    return True


def folder_or_file(field: str, value: Any) -> Path:
    """Refuse what is no path."""
    try:
        path = Path(value)
    except TypeError:
        raise TypeError(named(field, value, "give a path, as text or pathlib.Path")) from None
    require(bool(os.fspath(value)), field, value, "give a path")  # Path("") is the current folder
    return path


def new_file(field: str, value: Any) -> Path:
    """Refuse where no file can be written, before anything is made to be written there."""
    path = folder_or_file(field, value)
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, "a folder; give a file in it", str(path))
    if not path.parent.is_dir():
        raise FileNotFoundError(errno.ENOENT, f"there is no folder {path.parent}", str(path))
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))
    return path


def page_file(field: str, value: Any) -> Path:
    """Refuse where no HTML page can be written, and a name that promises something else."""
    path = new_file(field, value)
    ending(field, path, (".html", ".htm"), "give a name that ends in .html")
    return path


def other_file(field: str, path: Path, source: str | os.PathLike[str] | None) -> None:
    """Refuse to write over the recording, if the events come from one."""
    if source is not None and path.exists() and Path(source).exists() and path.samefile(source):
        raise ValueError(named(field, os.fspath(path), "is the recording itself; give another"))


def ending(field: str, path: Path, known: Iterable[str], remedy: str) -> None:
    """Refuse a file whose name says nothing of what is to be in it."""
    require(path.suffix.lower() in known, field, os.fspath(path), remedy)


def regular_file(path: Path) -> None:
    """Refuse a pipe, a socket or a device: a file is read more than once, and ends."""
    mode = path.stat().st_mode
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):  # a folder is refused where it is opened
        raise OSError(errno.ESPIPE, "no regular file; save it to one first", str(path))


def is_masked(array: Any) -> bool:
    """Whether a mask hides an element, or a field of one (which np.ma.is_masked cannot tell)."""
    ma: Any = sys.modules.get(
        "numpy.ma"
    )  # to import it would hold the first push up for 10 to 20 ms
    kind = getattr(ma, "MaskedArray", None)  # another thread may be importing it
    if kind is None or not isinstance(array, kind):
        return False
    mask: Any = ma.getmaskarray(array)
    parts = [mask] if mask.dtype.names is None else [mask[name] for name in mask.dtype.names]
    return any(bool(part.any()) for part in parts)


def unmasked(field: str, array: Any) -> None:
    """Refuse an array with a mask that hides something."""
    if is_masked(array):
        raise ValueError(f"{field} = masked array: {_UNMASK}")


def column(field: str, values: Any) -> npt.NDArray[Any]:
    """Refuse what is no one-dimensional array of numbers."""
    unmasked(field, values)
    try:
        array: npt.NDArray[Any] = np.asarray(values)
    except ValueError:  # lists of different lengths
        array = np.empty((), object)
    if array.ndim != 1 or array.dtype.kind not in "biuf":
        raise TypeError(named(field, values, "give a one-dimensional array of numbers"))
    return array
