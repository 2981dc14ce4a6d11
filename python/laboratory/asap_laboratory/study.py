"""How a study is conducted: its tasks run on some cores, resumable; then tables, page, figures."""

from __future__ import annotations

import datetime
import hashlib
import json
import multiprocessing
import os
import platform
import signal
import threading
import time
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor, as_completed
from contextlib import closing, contextmanager
from dataclasses import asdict, dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from asap import _checks, _core, plots
from asap._progress import OnProgress
from asap_laboratory import _native
from asap_laboratory.page import Cell, Rows, Tables, Writer, read_tables, write_tables

FORMS = ("quick", "default", "full")


class Task(Protocol):
    """Something to measure: a dataclass whose fields tell it from all others."""

    def weight(self) -> float:
        """How long it takes, in events, about."""
        ...

    def measure(self) -> Rows:
        """Run it; return rows that JSON can hold."""
        ...


class Batch(NamedTuple):
    """Tasks that may run beside each other; those that read the clock run one at a time."""

    tasks: Sequence[Task]
    one_at_a_time: bool = False


@dataclass(frozen=True)
class Study:
    """What tells a study from the others.

    Attributes
    ----------
    name : str
        Of its page, its data and its state file.
    command : str
        What has to be typed to conduct it.
    template : Path
        Its page.
    batches : callable
        Takes a form; a generator of `Batch` that is sent the rows of each.
    summary : callable
        Makes the tables of all rows.
    tables : tuple of str
        Their names.
    cells : dict of str to callable
        How the page writes a row, by the names that the template uses.
    figures : callable, optional
        Makes the figures of the tables, by the names of their SVG files.
    facts : callable, optional
        Makes what else the template needs of the tables.
    shown : callable, optional
        Writes of tables what the command prints.
    """

    name: str
    command: str
    template: Path
    batches: Callable[[str], Generator[Batch, Rows, None]]
    summary: Callable[[Rows], Tables]
    tables: tuple[str, ...]
    cells: Mapping[str, Cell]
    figures: Callable[[Tables], Mapping[str, Any]] = lambda tables: {}
    facts: Callable[[Tables], Mapping[str, Any]] = lambda tables: {}
    shown: Callable[[Tables, Writer], str] = lambda tables, writer: ""


@dataclass(frozen=True)
class Conducted:
    """What `conduct` returns."""

    tables: Tables
    paths: list[Path] = field(default_factory=list)  #: files written, the page first
    taken_from_file: int = 0  #: tasks that an earlier call had finished


def conduct(
    study: Study,
    out: str | Path,
    *,
    form: str = "default",
    workers: int | None = None,
    fresh: bool = False,
    on_progress: OnProgress | None = None,
) -> Conducted:
    """Measure what the folder does not hold yet; write the page, its data and its figures.

    Parameters
    ----------
    study : Study
        One of `STUDIES`.
    out : path
        Folder to write to; made where it does not exist. What it holds of an earlier call with the
        same build of the library is not run again.
    form : {"quick", "default", "full"}
        How much is measured.
    workers : int, optional
        Processes; as many as there are processors unless given. 1: none but this one. A script that
        needs more of them needs ``if __name__ == "__main__":``.
    fresh : bool
        Run everything again.
    on_progress : callable, optional
        Called as on_progress(done, total, None) for each batch, in events.

    Returns
    -------
    Conducted

    Raises
    ------
    ValueError
        There is no such form, or workers is below 1.
    KeyboardInterrupt
        Ctrl-C: what is finished stays in the state file, the next call goes on from there.
    """
    folder = _checks.folder_or_file("out", out)
    _checks.choice("form", form, FORMS)
    if workers is not None:
        _checks.whole("workers", workers, 1, 10_000, "give at least 1")
    _checks.flag("fresh", fresh)
    _checks.callback("on_progress", on_progress)
    folder.mkdir(parents=True, exist_ok=True)
    state = State(folder / f"{study.name}.jsonl", fresh=fresh)
    rows: Rows = []
    seconds, taken = 0.0, 0
    batches = study.batches(form)
    found: Rows | None = None
    while (batch := _next(batches, found)) is not None:
        taken += state.run(batch, workers=workers, on_progress=on_progress)
        entries = [state.entries[key_of(task)] for task in batch.tasks]
        found = [row for entry in entries for row in entry["rows"]]
        seconds += sum(entry["seconds"] for entry in entries)
        rows += found
    tables = {**study.summary(rows), "run": [_origin(study.command, form, seconds)]}
    write_tables(folder, study.name, tables)
    return write(study, folder, taken_from_file=taken)


def _next(batches: Generator[Batch, Rows, None], found: Rows | None) -> Batch | None:
    try:
        return next(batches) if found is None else batches.send(found)
    except StopIteration:
        return None


def write(study: Study, folder: Path, *, taken_from_file: int = 0) -> Conducted:
    """Write the page and the figures of a study from the data in a folder."""
    tables = read_tables(folder, study.name, (*study.tables, "run"))
    paths = [folder / f"{study.name}.md"]
    facts = {**study.facts(tables), "tables": tables, "run": tables["run"][0]}
    text = Writer(study.cells).page(study.template, **facts)
    paths[0].write_text(text, encoding="utf-8")
    paths += [folder / "data" / f"{study.name}.csv"]
    for name, drawn in study.figures(tables).items():
        paths.append(folder / f"{name}.svg")
        paths[-1].write_text(plots.svg(drawn), encoding="utf-8")
    return Conducted(tables, paths, taken_from_file)


def _origin(command: str, form: str, seconds: float) -> dict[str, Any]:
    return {
        "command": command if form == "default" else f"{command} --{form}",
        "form": form,
        "date": datetime.date.today().isoformat(),
        "version": _core.__version__,
        "machine": f"{_processor()}, {os.cpu_count()} cores, {platform.system()} "
        f"{platform.machine()}",
        "minutes": round(seconds / 60, 1),
    }


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.processor() or "unknown processor")


# ---- tasks ---------------------------------------------------------------------------------------


class State:
    """A file with one JSON object for each task that is finished, and what it holds by key.

    A line that was cut short counts for nothing.
    """

    def __init__(self, path: Path, *, fresh: bool = False) -> None:
        self._path = path
        self.entries: dict[str, dict[str, Any]] = {}
        if fresh:
            path.unlink(missing_ok=True)
        for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else ():
            try:
                entry = json.loads(line)
                self.entries[entry["key"]] = {"seconds": entry["seconds"], "rows": entry["rows"]}
            except (ValueError, KeyError, TypeError):
                continue

    def run(
        self, batch: Batch, *, workers: int | None = None, on_progress: OnProgress | None = None
    ) -> int:
        """Measure the tasks that the file does not hold; return how many it held."""
        missing = {key_of(task): task for task in batch.tasks}
        missing = {key: task for key, task in missing.items() if key not in self.entries}
        weights = {key: task.weight() for key, task in missing.items()}
        # The heavy ones first, so that none is left alone at the end.
        order = sorted(missing, key=lambda key: -weights[key])
        workers = 1 if batch.one_at_a_time else workers or os.cpu_count() or 1
        done = 0.0
        with closing(_measured({key: missing[key] for key in order}, workers)) as measured:
            for key, rows, seconds in measured:
                self._keep(key, type(missing[key]).__name__, rows, seconds)
                done += weights[key]
                if on_progress is not None:
                    on_progress(round(done), round(sum(weights.values())), None)
        return len(batch.tasks) - len(missing)

    def _keep(self, key: str, task: str, rows: Rows, seconds: float) -> None:
        entry = {"seconds": round(seconds, 3), "rows": rows}
        cut = self._path.exists() and not self._path.read_bytes().endswith(b"\n")
        with self._path.open("a", encoding="utf-8") as lines:
            lines.write("\n" * cut + json.dumps({"key": key, "task": task, **entry}) + "\n")
        self.entries[key] = entry


def key_of(task: Task) -> str:
    """Return what tells a task and the library that carries it out from all others."""
    fields: Any = task
    words = [type(task).__name__, asdict(fields), _core.__version__, _build()]
    return hashlib.sha256(json.dumps(words, sort_keys=True).encode()).hexdigest()[:24]


@cache
def _build() -> str:
    """Digest of the extensions: two builds of one version may measure differently."""
    native = (Path(file).read_bytes() for file in (_core.__file__, _native.__file__))
    return hashlib.sha256(b"".join(native)).hexdigest()


def _measured(
    tasks: Mapping[str, Task], workers: int
) -> Generator[tuple[str, Rows, float], None, None]:
    """Yield what each task has found, as they finish, and the processor time that it took."""
    if workers == 1 or not tasks:
        for key, task in tasks.items():
            yield key, *_timed(task)
        return
    with _pool(workers) as pool:
        futures = {pool.submit(_timed, task): key for key, task in tasks.items()}
        for future in as_completed(futures):
            yield futures.pop(future), *future.result()


def _timed(task: Task) -> tuple[Rows, float]:
    begin_s = time.process_time()
    rows = task.measure()
    return rows, time.process_time() - begin_s


@contextmanager
def _pool(workers: int) -> Iterator[Executor]:
    """Give processes that end with this block, however it is left, and with this process."""
    others = set(multiprocessing.active_children())
    # Spawned: a fork may inherit a lock that a thread of this process holds.
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(workers, mp_context=context, initializer=_begin_worker)
    try:
        yield pool
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        for worker in set(multiprocessing.active_children()) - others:
            worker.terminate()
        raise
    finally:
        pool.shutdown()


def _begin_worker() -> None:
    """Leave Ctrl-C to the parent, which ends the workers, and go when it dies."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_follow_parent, daemon=True).start()


def _follow_parent() -> None:
    if (parent := multiprocessing.parent_process()) is not None:
        parent.join()
        os._exit(1)
