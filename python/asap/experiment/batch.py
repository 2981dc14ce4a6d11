"""map: one function over many recordings, on many cores or many machines."""

from __future__ import annotations

import concurrent.futures
import copy
import importlib
import os
import sys
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future
from contextlib import ExitStack
from functools import partial
from queue import SimpleQueue
from typing import Any, Protocol

import numpy as np

from asap import _checks
from asap.experiment.runners import Progress
from asap.io import Recording
from asap.results.data import can_be_pickled

_TRIES = 2
_MODULE = "define it at the top of a module, or give executor=ThreadPoolExecutor()"


class _Worker(Protocol):
    def submit(self, function: Callable[..., Any], element: Any, /) -> Future[Any]: ...


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
        ``multiprocessing`` is set up.
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

    Notes
    -----
    A ``ProcessPoolExecutor`` of your own ends with the first process that dies: every element that
    has not finished fails with it. By default a process that dies takes no other element with it.

    Examples
    --------
    ::

        runs = asap.map(track, sorted(Path("flights").glob("*.npy")))
        failed = [one.recording for one in runs if isinstance(one, Exception)]
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
        return _called(function, elements, [executor] * len(elements), on_progress)
    _check_found(function)
    with ExitStack() as stack:
        workers = [_Process(stack) for _ in range(min(len(elements), _cores()))]
        return _called(partial(_in_process, function), elements, workers, on_progress)


def _listed(recordings: Any) -> list[Any]:
    one = isinstance(recordings, (str, bytes, os.PathLike, np.ndarray, Recording))
    if one or not isinstance(recordings, Iterable):
        raise TypeError(_checks.named("recordings", recordings, "give a list of recordings"))
    return list(recordings)


def _called(
    function: Callable[[Any], Any],
    elements: Sequence[Any],
    workers: Sequence[_Worker],
    on_progress: Progress | None,
) -> list[Any]:
    """Give each worker an element at a time; a worker that stands there twice gets two."""
    results: list[Any] = [None] * len(elements)
    tries = [0] * len(elements)
    waiting, idle = deque(range(len(elements))), deque(workers)
    running: dict[Future[Any], tuple[int, _Worker]] = {}
    ended: SimpleQueue[Future[Any]] = SimpleQueue()
    done = 0
    try:
        while waiting or running:
            while waiting and idle:
                index, worker = waiting.popleft(), idle.popleft()
                future = _submitted(worker, function, elements[index])
                running[future] = index, worker
                future.add_done_callback(ended.put)
            future = ended.get()
            index, worker = running.pop(future)
            idle.append(worker)
            tries[index] += 1
            error = CancelledError() if future.cancelled() else future.exception()
            if isinstance(error, BrokenExecutor) and tries[index] < _TRIES:
                waiting.append(index)
                continue
            results[index] = future.result() if error is None else _failure(error, elements[index])
            done += 1
            if on_progress is not None:
                on_progress(done, len(elements), {})
    finally:
        for future in running:
            future.cancel()
    return results


def _submitted(worker: _Worker, function: Callable[[Any], Any], element: Any) -> Future[Any]:
    try:
        return worker.submit(function, element)
    except BrokenExecutor as error:
        failed: Future[Any] = Future()
        failed.set_exception(error)
        return failed


def _failure(error: BaseException, element: Any) -> BaseException:
    """Note the element at its exception; where several share one, each gets its own."""
    if "recording" in vars(error):
        error = copy.copy(error)
    vars(error)["recording"] = element
    return error


class _Process:
    """One process, started anew after it has died: a death is that of the one element in it."""

    def __init__(self, stack: ExitStack) -> None:
        self._stack = stack
        self._start()

    def _start(self) -> None:
        # Imported here: it takes longer than the whole of asap.
        self._pool = self._stack.enter_context(concurrent.futures.ProcessPoolExecutor(1))

    def submit(self, function: Callable[..., Any], element: Any, /) -> Future[Any]:
        try:
            return self._pool.submit(function, element)
        except BrokenExecutor:
            self._start()
            return self._pool.submit(function, element)


def _in_process(function: Callable[[Any], Any], element: Any) -> Any:
    """Call it; an exception that a pickle would not bring back becomes a RuntimeError."""
    try:
        return function(element)
    except Exception as error:
        if _comes_back(error):
            raise
        raise RuntimeError(f"{type(error).__name__}: {error}") from error


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
