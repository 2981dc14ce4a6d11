"""Carry out tasks through any executor, resumable: every finished one is a line of a file."""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import CancelledError, Executor, Future, ProcessPoolExecutor, as_completed
from contextlib import contextmanager, suppress
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

from asap import _core
from asap._progress import OnProgress
from asap_laboratory import _native
from asap_laboratory.accuracy.cases import Accuracy
from asap_laboratory.ladder.cases import Outcomes
from asap_laboratory.ladder.cost import Costs
from asap_laboratory.measure import Figures, Measured
from asap_laboratory.probes import Few, Steady, Window
from asap_laboratory.results import Outcome, Results, Task
from asap_laboratory.rivals.cases import Rivalry

_Future: TypeAlias = "Future[tuple[Outcome, float]]"


class Ran(NamedTuple):
    """What `run` returns."""

    results: Results
    taken_from_file: int  #: tasks that an earlier call had finished
    seconds: float  #: of processor time for all tasks, earlier calls included


def run(
    tasks: Sequence[Task],
    *,
    state: Path,
    executor: Executor | None = None,
    workers: int | None = None,
    fresh: bool = False,
    on_progress: OnProgress | None = None,
) -> Ran:
    """Measure every task that the state file does not hold yet.

    Parameters
    ----------
    tasks : sequence of Task
        Cases and probes.
    state : Path
        One JSON object per line and finished task. A task is known again by its parameters, the
        version and the build of the library. A line that was cut short counts for nothing.
    executor : concurrent.futures.Executor, optional
        Where tasks are carried out; a pool of processes unless given. It is not shut down.
    workers : int, optional
        Processes of that pool; as many as there are processors unless given.
    fresh : bool
        Forget what the file holds.
    on_progress : callable, optional
        Called as on_progress(done, total, None), in simulated events.

    Returns
    -------
    Ran

    Raises
    ------
    KeyboardInterrupt
        Ctrl-C: what is finished stays in the file, the next call goes on from there. Tasks that run
        in another thread or process are waited for, unless the signal has ended them too.
    """
    if fresh:
        state.unlink(missing_ok=True)
    known = _read(state)
    keys = [key_of(task) for task in tasks]
    missing = {key: task for key, task in zip(keys, tasks, strict=True) if key not in known}
    weights = {key: task.weight() for key, task in missing.items()}
    _end_last_line(state)
    with state.open("a", encoding="utf-8") as lines, _pool(executor, workers) as pool:

        def keep(key: str, outcome: Outcome, seconds: float) -> None:
            line = {"key": key, "task": missing[key].name, "seconds": round(seconds, 3)}
            lines.write(json.dumps({**line, "outcome": asdict(outcome)}) + "\n")
            lines.flush()
            known[key] = (outcome, seconds)

        # The heavy ones first, so that none is left alone at the end.
        heavy_first = sorted(missing, key=lambda key: -weights[key])
        futures: dict[_Future, str] = {}
        done = 0.0
        try:
            with _held_back_interrupt():
                for key in heavy_first:
                    futures[pool.submit(_timed, missing[key])] = key
            for future in as_completed(futures):
                key = futures.pop(future)
                keep(key, *future.result())
                done += weights[key]
                if on_progress is not None:
                    on_progress(round(done), round(sum(weights.values())), None)
        except BaseException:
            if (
                executor is None
            ):  # the pool alone may: its thread would stumble over a cancelled one
                pool.shutdown(wait=False, cancel_futures=True)
            else:
                _cancel(futures)
            _keep_what_ran(futures, keep)
            raise
    found = [known[key] for key in keys]
    return Ran(
        Results(zip(tasks, (outcome for outcome, _ in found), strict=True)),
        len(tasks) - len(missing),
        sum(seconds for _, seconds in found),
    )


def _cancel(futures: Iterable[_Future]) -> None:
    for future in futures:
        future.cancel()


def _keep_what_ran(
    futures: dict[_Future, str], keep: Callable[[str, Outcome, float], None]
) -> None:
    """Wait for what had begun; workers that were stopped too have died."""
    for future, key in futures.items():
        with suppress(CancelledError):
            if future.exception() is None:
                keep(key, *future.result())


def key_of(task: Task) -> str:
    """Return what tells a task and the library that carries it out from all others."""
    words = [type(task).__name__, asdict(task), _core.__version__, _build()]
    return hashlib.sha256(json.dumps(words, sort_keys=True).encode()).hexdigest()[:24]


@cache
def _build() -> str:
    """Digest of the extensions: two builds of one version may measure differently."""
    native = (Path(file).read_bytes() for file in (_core.__file__, _native.__file__))
    return hashlib.sha256(b"".join(native)).hexdigest()


def _timed(task: Task) -> tuple[Outcome, float]:
    begin_s = time.process_time()
    outcome = task.measure()
    return outcome, time.process_time() - begin_s


@contextmanager
def _pool(executor: Executor | None, workers: int | None) -> Iterator[Executor]:
    if executor is not None:
        yield executor
        return
    # Spawned: a fork may inherit a lock that a thread of this process holds.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(
        workers or os.cpu_count(), mp_context=context, initializer=_die_in_company
    ) as pool:
        yield pool


@contextmanager
def _held_back_interrupt() -> Iterator[None]:
    """Ctrl-C counts at the end, and in a process that begins meanwhile once it allows it."""
    arrived = []
    here = threading.current_thread() is threading.main_thread()
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])  # the new process inherits it
    handler = signal.signal(signal.SIGINT, lambda *_: arrived.append(True)) if here else None
    try:
        yield
    finally:
        if here:
            signal.signal(signal.SIGINT, handler)
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
    if arrived:
        raise KeyboardInterrupt


def _die_in_company() -> None:
    """Let a worker go with its parent, or of a Ctrl-C, which reaches it too: without a word."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGINT])
    threading.Thread(target=_follow_parent, daemon=True).start()


def _follow_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:  # of a worker there is one
        parent.join()
        os._exit(1)


def _read(state: Path) -> dict[str, tuple[Outcome, float]]:
    known = {}
    for line in state.read_text(encoding="utf-8").splitlines() if state.exists() else ():
        try:
            entry = json.loads(line)
            known[entry["key"]] = (_outcome(entry["outcome"]), float(entry["seconds"]))
        except (ValueError, KeyError, TypeError):
            continue  # cut short, or of another version
    return known


def _outcome(fields: dict[str, Any]) -> Outcome:
    if "figures" in fields:
        figures = {label: Figures(**values) for label, values in fields["figures"].items()}
        return Measured(**{**fields, "figures": figures})
    if "scored" in fields:
        return Accuracy.restored(fields)
    if "rivals" in fields:
        return Rivalry(**fields)
    if "tried" in fields:
        return Costs.restored(fields)
    if "schemes" in fields:
        return Outcomes.restored(fields)
    if "finished" in fields:
        return Few(**fields)
    return Steady(**fields) if "theory_us" in fields else Window(**fields)


def _end_last_line(state: Path) -> None:
    """Begin on a line of our own, whatever an interruption has left."""
    if state.exists() and not state.read_bytes().endswith(b"\n"):
        with state.open("ab") as lines:
            lines.write(b"\n")
