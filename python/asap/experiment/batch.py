"""map: one function over many recordings, on many cores or many machines."""

from __future__ import annotations

import copy
import importlib
import os
import pickle
import sys
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future
from functools import partial
from queue import SimpleQueue
from typing import Any

import numpy as np

from asap import _checks
from asap.experiment.runners import Progress
from asap.io import Recording
from asap.io.errors import library
from asap.results.result import can_be_pickled

_TRIES = 2
_MODULE = "define it at the top of a module, or give executor=ThreadPoolExecutor()"

_Submit = Callable[[Any], "Future[Any]"]


def map(
    function: Callable[[Any], Any],
    recordings: Iterable[Any],
    *,
    executor: Executor | None = None,
    on_progress: Progress | None = None,
) -> list[Any]:
    """Call a function with each of many recordings, by default on all cores of this machine.

    Parameters
    ----------
    function : callable
        Takes one element of `recordings`. Another process has to find it: define it at the top of a
        module, and let a script call `map` below ``if __name__ == "__main__":``.
    recordings : iterable
        Paths, recordings, arrays, tuples: each element is given as it is.
    executor : concurrent.futures.Executor, optional
        Makes the calls, such as ``ThreadPoolExecutor()`` or the ``client.get_executor()`` of
        ``dask.distributed``; it stays open. Default: a process for each core, started as
        ``multiprocessing`` is set up; that needs ``asap-events[map]``.
    on_progress : callable, optional
        Called as on_progress(done, total, {}) after each element.

    Returns
    -------
    list
        The results in the order of `recordings`. Where a call failed stands its exception, with the
        element as ``.recording``. An element whose process dies is tried once more; then its
        exception is a ``BrokenExecutor``.

    Raises
    ------
    TypeError
        An argument of the wrong kind, or a function that another process cannot find.
    RuntimeError
        Pebble, which keeps the processes, is not installed.

    Notes
    -----
    A ``ProcessPoolExecutor`` of your own ends with the first process that dies: every element that
    has not finished fails with it. By default a process that dies takes no other element with it.

    Examples
    --------
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> np.save("flight.npy", asap.synthetic.FlightOverChairs(duration_s=0.1).events())
    >>> paths = ["flight.npy", "absent.npy"]
    >>> found = asap.map(asap.info, paths, executor=ThreadPoolExecutor())
    >>> [one.recording for one in found if isinstance(one, Exception)]
    ['absent.npy']
    """
    if function is None:
        raise TypeError(_checks.named("function", function, "give a callable"))
    _checks.callback("function", function)
    _checks.callback("on_progress", on_progress)
    elements = _listed(recordings)
    if executor is not None:
        if not hasattr(executor, "submit"):
            remedy = "give an executor of concurrent.futures, or None"
            raise TypeError(_checks.named("executor", executor, remedy))
        return _called(lambda element: executor.submit(function, element), elements, on_progress)
    _check_found(function)
    pebble = library("pebble", "asap.map without an executor", "map")
    with pebble.ProcessPool(max(min(len(elements), _cores()), 1)) as pool:
        submit = partial(pool.submit, partial(_in_process, function), None)  # None: no time limit
        return _called(submit, elements, on_progress, dead=pebble.ProcessExpired, read=pickle.loads)


def _listed(recordings: Any) -> list[Any]:
    one = isinstance(recordings, (str, bytes, os.PathLike, np.ndarray, Recording))
    if one or not isinstance(recordings, Iterable):
        raise TypeError(_checks.named("recordings", recordings, "give a list of recordings"))
    return list(recordings)


def _called(
    submit: _Submit,
    elements: Sequence[Any],
    on_progress: Progress | None,
    dead: type[BaseException] = BrokenExecutor,
    read: Callable[[Any], Any] = lambda result: result,
) -> list[Any]:
    """Submit every element, once more where its process was `dead`, and `read` what comes back."""
    results: list[Any] = [None] * len(elements)
    running: dict[Future[Any], tuple[int, int]] = {}  # the element, and which try it is
    ended: SimpleQueue[Future[Any]] = SimpleQueue()

    def begin(index: int, tries: int) -> None:
        try:
            future = submit(elements[index])
        except BrokenExecutor as error:  # it is broken for good
            future = Future()
            future.set_exception(error)
        running[future] = index, tries
        future.add_done_callback(ended.put)

    try:
        for index in range(len(elements)):
            begin(index, 1)
        for done in range(1, len(elements) + 1):
            while True:
                future = ended.get()
                index, tries = running.pop(future)
                error = CancelledError() if future.cancelled() else future.exception()
                if not isinstance(error, dead) or tries == _TRIES:
                    break
                begin(index, tries + 1)
            if isinstance(error, dead) and not isinstance(error, BrokenExecutor):
                error = BrokenExecutor(str(error))
            if error is None:
                results[index] = read(future.result())
            else:
                results[index] = _failure(error, elements[index])
            if on_progress is not None:
                on_progress(done, len(elements), {})
    finally:
        for future in running:
            future.cancel()
    return results


def _failure(error: BaseException, element: Any) -> BaseException:
    """Note the element at its exception; where several share one, each gets its own."""
    if "recording" in vars(error):
        error = copy.copy(error)
    vars(error)["recording"] = element
    return error


def _in_process(function: Callable[[Any], Any], element: Any) -> bytes:
    """Return the pickle of a result; an exception that none would bring back is a RuntimeError."""
    try:
        result = function(element)
    except Exception as error:
        if _comes_back(error):
            raise
        raise RuntimeError(f"{type(error).__name__}: {error}") from error
    try:
        return pickle.dumps(result, pickle.HIGHEST_PROTOCOL)
    except Exception as error:
        words = f"the result of function cannot leave its process: {error}"
        raise TypeError(words) from None


def _comes_back(error: Exception) -> bool:
    try:
        copy.copy(error)  # made anew of its arguments, as by a pickle
    except Exception:
        return False
    return can_be_pickled(error)


def _check_found(function: Callable[[Any], Any]) -> None:
    """Refuse what a new process cannot import, before one is started."""
    if not can_be_pickled(function):
        raise TypeError(_checks.named("function", function, f"no process can find it; {_MODULE}"))
    multiprocessing = importlib.import_module("multiprocessing")
    at_a_prompt = not hasattr(sys.modules["__main__"], "__file__")
    is_of_main = getattr(function, "__module__", None) == "__main__"
    if at_a_prompt and is_of_main and multiprocessing.get_start_method() != "fork":
        words = f"a new process finds nothing of a notebook; {_MODULE}"
        raise TypeError(_checks.named("function", function, words))


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
