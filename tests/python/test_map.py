"""asap.map: results in order, failures at their place, processes that die, every start method."""

from __future__ import annotations

import copyreg
import multiprocessing
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import (
    BrokenExecutor,
    Executor,
    Future,
    ThreadPoolExecutor,
)
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
import streams

# Python 3.12 and later warn of every fork of a process with threads.
pytestmark = pytest.mark.filterwarnings("ignore:.*multi-threaded.*fork:DeprecationWarning")


class Counting:
    def __init__(self) -> None:
        self.events = 0

    def process(self, events: Any) -> None:
        self.events += len(events)


def doubled(value: Any) -> Any:
    return value * 2


def simulated(path: Path) -> asap.Run:
    return asap.simulate(path, cost=asap.LinearCost(100, 300), algorithm=Counting())


class Stubborn(Exception):
    """Pickles, but does not come back: its constructor wants something else."""

    def __init__(self, first: str, second: str) -> None:
        super().__init__(f"{first} and {second}")


def odd_only(number: int) -> int:
    if number % 4 == 0:
        raise Stubborn("four", "more")
    if number % 2 == 0:
        raise ValueError(f"number = {number}: it is even")
    return number


def noted(element: tuple[Path, str, int]) -> str:
    """Note the try in a file, then die in the first `deaths` of them."""
    folder, name, deaths = element
    note = folder / name
    with note.open("a") as file:
        file.write("tried\n")
    if len(note.read_text().splitlines()) <= deaths:
        os.kill(os.getpid(), signal.SIGKILL)
    return name


def closure(number: int) -> Any:
    return lambda: number


def exits(number: int) -> int:
    sys.exit(number)


async def awaited(number: int) -> int:
    return number


@pytest.fixture(autouse=True)
def plain_pickles(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pickle exceptions as Python does, where another test has imported dask, which changes it."""
    for kind in list(copyreg.dispatch_table):
        if isinstance(kind, type) and issubclass(kind, BaseException):
            monkeypatch.delitem(copyreg.dispatch_table, kind)


@pytest.fixture
def recordings(tmp_path: Path) -> list[Path]:
    paths = []
    for number in range(3):
        paths.append(tmp_path / f"{number}.npy")
        np.save(paths[-1], streams.make(np.arange(100 * (number + 1)) * 50, x=3, y=4))
    return paths


@pytest.fixture(params=multiprocessing.get_all_start_methods())
def start_method(request: pytest.FixtureRequest) -> Iterator[str]:
    before = multiprocessing.get_start_method(allow_none=True)
    multiprocessing.set_start_method(request.param, force=True)
    yield request.param
    multiprocessing.set_start_method(before, force=True)


def test_runs_come_back_in_order(recordings: list[Path], start_method: str) -> None:
    runs = asap.map(simulated, recordings)
    assert [run.source["path"] for run in runs] == [str(path) for path in recordings]
    for run, path in zip(runs, recordings, strict=True):
        assert run.summary() == simulated(path).summary()
        assert run.algorithm.events == run.ledger.delivered


def test_every_element_is_given_as_it_is(recordings: list[Path]) -> None:
    with ThreadPoolExecutor(2) as threads:
        given = [recordings[0], asap.read(recordings[1]), (1, "two"), None]
        got = asap.map(lambda one: one, iter(given), executor=threads)
        assert all(one is other for one, other in zip(got, given, strict=True))
        assert asap.map(str, [], executor=threads) == asap.map(str, []) == []


def test_a_failure_stands_at_its_place() -> None:
    found = asap.map(odd_only, [1, 2, 3, 4])
    assert [found[0], found[2]] == [1, 3]
    assert type(found[1]) is ValueError and found[1].args == ("number = 2: it is even",)
    assert type(found[3]) is RuntimeError and str(found[3]) == "Stubborn: four and more"
    assert (found[1].recording, found[3].recording) == (2, 4)
    assert "odd_only" in str(found[1].__cause__)  # where it failed, in the other process


def test_a_result_that_cannot_leave_its_process_is_a_failure() -> None:
    (found,) = asap.map(closure, [3])
    assert isinstance(found, TypeError) and found.recording == 3
    assert str(found).startswith("the result of function cannot leave its process: ")


def test_an_exit_is_a_failure() -> None:
    (found,) = asap.map(exits, [3])
    assert isinstance(found, SystemExit) and (found.code, found.recording) == (3, 3)


def test_a_process_that_dies_takes_its_own_element_only(tmp_path: Path, start_method: str) -> None:
    elements = [(tmp_path, f"{number}", deaths) for number, deaths in enumerate([0, 9, 1, 0, 0])]
    found = asap.map(noted, elements)
    assert [found[index] for index in (0, 2, 3, 4)] == ["0", "2", "3", "4"]
    assert isinstance(found[1], BrokenExecutor) and found[1].recording == elements[1]
    tries = [len((tmp_path / name).read_text().splitlines()) for name in "01234"]
    assert tries == [1, 2, 2, 1, 1]


class Dying(Executor):
    """Breaks under every call with a number that it has not seen before."""

    def __init__(self) -> None:
        self.seen: list[int] = []

    def submit(self, function: Callable[..., Any], *given: Any, **_: Any) -> Future[Any]:  # type: ignore[override]
        future: Future[Any] = Future()
        if given[0] in self.seen:
            future.set_result(function(*given))
        elif given[0] == 7:
            future.cancel()
            future.set_running_or_notify_cancel()
        else:
            future.set_exception(BrokenExecutor("one worker less"))
        self.seen.append(given[0])
        return future


def test_any_executor_serves_and_stays_open() -> None:
    dying = Dying()
    found = asap.map(doubled, [1, 2, 7], executor=dying)
    assert found[:2] == [2, 4] and sorted(dying.seen) == [1, 1, 2, 2, 7]
    assert type(found[2]).__name__ == "CancelledError" and found[2].recording == 7
    with ThreadPoolExecutor(1) as threads:
        assert asap.map(doubled, [1], executor=threads) == [2]
        assert threads.submit(doubled, 2).result() == 4


def test_progress_counts_the_elements() -> None:
    told: list[Any] = []
    asap.map(odd_only, [1, 2, 3], on_progress=lambda *given: told.append(given))
    assert told == [(1, 3, {}), (2, 3, {}), (3, 3, {})]


@pytest.mark.parametrize(
    ("function", "recordings", "words"),
    [
        (None, [1], "function = None: give a callable"),
        (5, [1], "function = 5: give a callable"),
        (awaited, [1], "asyncio.to_thread"),
        (partial(awaited, 1), [1], "asyncio.to_thread"),
        (lambda one: one, [1], "no process can find it; define it at the top of a module"),
        (doubled, "a.npy", "recordings = 'a.npy': give a list of recordings"),
        (doubled, Path("a.npy"), "give a list of recordings"),
        (doubled, np.zeros(3), "give a list of recordings"),
        (doubled, None, "recordings = None: give a list of recordings"),
    ],
)
def test_wrong_arguments_are_refused(function: Any, recordings: Any, words: str) -> None:
    with pytest.raises(TypeError, match=words):
        asap.map(function, recordings)


def test_a_script_on_its_own(recordings: list[Path]) -> None:
    script = recordings[0].with_name("script.py")
    script.write_text(
        "import asap, multiprocessing, sys\n"
        "def one(path):\n"
        "    return asap.simulate(path, cost=asap.LinearCost(100, 300))\n"
        'if __name__ == "__main__":\n'
        '    multiprocessing.set_start_method("spawn")\n'
        "    print([run.ledger.received for run in asap.map(one, sys.argv[1:])])\n"
    )
    command = [sys.executable, str(script), *map(str, recordings)]
    assert subprocess.check_output(command, text=True) == "[100, 200, 300]\n"
