"""What has to be awaited is refused before anything is read: a run would never await it."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Iterator
from functools import partial
from typing import Any
from unittest.mock import AsyncMock

import numpy as np
import pytest

import asap

EVENTS = np.zeros(5, asap.EVENT_DTYPE)
COST = asap.LinearCost(1, 1)


async def coroutine(events: Any, gain: float = 1.0) -> None:
    """Stands for an algorithm that a user has written for asyncio."""


async def generator(events: Any = None) -> AsyncIterator[Any]:
    yield EVENTS


class Processes:
    async def process(self, events: Any) -> None:
        """Never awaited."""


class Called:
    async def __call__(self, events: Any) -> None:
        """Never awaited."""


class Told:
    def process(self, events: Any) -> None:
        """Return nothing."""

    async def set_gamma(self, gamma: float) -> None:
        """Never awaited."""


WORKERS = {
    "async def": coroutine,
    "process": Processes(),
    "bound method": Processes().process,
    "__call__": Called(),
    "partial": partial(coroutine, gain=2.0),
    "partial of a partial": partial(partial(coroutine), gain=2.0),
    "partial of __call__": partial(Called()),
    "set_gamma": Told(),
    "async generator": generator,
    "mock": AsyncMock(),
}


class Unread:
    """A source that fails if anything of it is read."""

    def __iter__(self) -> Iterator[Any]:
        raise AssertionError("it was read")


ENTRIES: dict[str, tuple[str, Callable[[Any], Any]]] = {
    "run": ("algorithm", lambda worker: asap.run(Unread(), algorithm=worker)),
    "run, file": ("algorithm", lambda worker: asap.run("no such file", algorithm=worker)),
    "run, before": (
        "before",
        lambda worker: asap.run(Unread(), algorithm=print, before=worker),
    ),
    "simulate": (
        "algorithm",
        lambda worker: asap.simulate(Unread(), cost=COST, algorithm=worker),
    ),
    "simulate, before": (
        "before",
        lambda worker: asap.simulate(Unread(), cost=COST, before=worker),
    ),
    "Pipeline": ("algorithm", asap.Pipeline),
    "Pipeline, before": ("before", lambda worker: asap.Pipeline(before=worker)),
}


@pytest.mark.parametrize("worker", WORKERS.values(), ids=WORKERS)
@pytest.mark.parametrize(("field", "call"), ENTRIES.values(), ids=ENTRIES)
def test_an_async_worker_is_refused(field: str, call: Callable[[Any], Any], worker: Any) -> None:
    with pytest.raises(TypeError, match=rf"^{field} = .*asyncio\.to_thread"):
        call(worker)


def yields(events: Any) -> Iterator[None]:
    yield


def takes_nothing() -> None:
    """Stand for a function that forgot its parameter."""


def takes_two(events: Any, sensor: Any) -> None:
    """Stand for a function that wants more than it gets."""


@pytest.mark.parametrize(("field", "call"), ENTRIES.values(), ids=ENTRIES)
@pytest.mark.parametrize(
    ("worker", "words"),
    [
        (yields, "its yield makes a call do nothing"),
        (takes_nothing, "takes no array of events; give it one parameter"),
        (takes_two, "takes no array of events; give it one parameter"),
    ],
)
def test_a_function_that_cannot_work_is_refused(
    field: str, call: Callable[[Any], Any], worker: Any, words: str
) -> None:
    with pytest.raises(TypeError, match=rf"^{field} = .*{words}"):
        call(worker)


SOURCES: dict[str, Callable[[], Any]] = {
    "async generator": generator,
    "its function": lambda: generator,
    "async def": lambda: coroutine,
}


@pytest.mark.parametrize("make", SOURCES.values(), ids=SOURCES)
@pytest.mark.parametrize(
    "call",
    [
        lambda source: asap.run(source, algorithm=print),
        lambda source: asap.simulate(source, cost=COST),
        lambda source: asap.compare(source, cost=COST),
        lambda source: asap.oracle(source, cost=COST, latency_ms=10),
        asap.check,
    ],
    ids=["run", "simulate", "compare", "oracle", "check"],
)
def test_an_async_source_is_refused(call: Callable[[Any], Any], make: Callable[[], Any]) -> None:
    with pytest.raises(TypeError, match=r"^source = .*asyncio\.to_thread"):
        call(make())


def test_an_async_callback_is_refused() -> None:
    with pytest.raises(TypeError, match=r"^on_progress = .*asyncio\.to_thread"):
        asap.simulate(EVENTS, cost=COST, on_progress=coroutine)
