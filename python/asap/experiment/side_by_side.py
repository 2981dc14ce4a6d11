"""side_by_side: one pass over a stream feeds every contender and the oracle; memory stays flat.

Each run equals the one that ``simulate`` would give, bit for bit: the runs share the events and
nothing else.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np

from asap import _core
from asap._checks import number
from asap.events import Events
from asap.experiment.contenders import Contender
from asap.experiment.runners import Progress, make_config, remember
from asap.experiment.source import Source
from asap.results import Run
from asap.synthetic import joined

_CHUNK = 1 << 16  # events that all get before any gets more
_MOST_HELD = 1 << 20  # events, for the exact clairvoyant
_MOST_EXACT_STEPS = 4e9  # some seconds


class SideBySide(NamedTuple):
    """What one pass has found."""

    runs: list[Run]  #: in the order of the contenders
    oracle: float  #: OB(L) for an algorithm whose loop the library owns, events
    opaque_oracle: float  #: the same for one that takes a package as a whole
    exact: int | None  #: EC(L), events; None where it would take long, or the cost drifts


class CheckedStream(Source):
    """A source behind one door for all: good events only, their stamps compressed by `speed`.

    `speed` makes a quiet recording a busy one: t becomes t0 + (t - t0) / speed in whole us, where
    t0 is the first good stamp.
    """

    def __init__(
        self,
        source: Any,
        *,
        width: int | None = None,
        height: int | None = None,
        on_bad: str = "drop",
        speed: float = 1.0,
    ) -> None:
        self.speed = number("speed", speed, 1e-6, 1e6, "must be between 1e-6 and 1e6")
        super().__init__(source, width=width, height=height, on_bad=on_bad)
        self._door = _core.Validator(width=self.width or 0, height=self.height or 0, on_bad=on_bad)
        self._begin_us: int | None = None

    def __iter__(self) -> Iterator[Events]:
        for chunk in super().__iter__():
            good = self._door.check(chunk)
            if good.size:
                yield good if self.speed == 1.0 else self._compressed(good)

    @property
    def rejected(self) -> dict[str, int]:
        """Events that the reader of the file and the door have rejected, by reason."""
        rejected = super().rejected
        for reason, count in self._door.rejected.items():
            rejected[reason] = rejected.get(reason, 0) + count
        return rejected

    @property
    def clock_resets(self) -> int:
        """How often the reader of the file and the door saw the sensor's clock jump back."""
        return super().clock_resets + self._door.clock_resets

    def _compressed(self, events: Events) -> Events:
        if self._begin_us is None:
            self._begin_us = int(events["t"][0])
        compressed: Events = events.copy()
        elapsed_us = np.floor((events["t"] - self._begin_us) / self.speed)
        compressed["t"] = self._begin_us + elapsed_us.astype(np.int64)
        return compressed


def side_by_side(
    stream: CheckedStream,
    contenders: Sequence[Contender],
    *,
    cost: _core.LinearCost,
    latency_ms: float,
    seed: int = 0,
    capacity: int | None = None,
    threads: int | None = None,
    on_progress: Progress | None = None,
) -> SideBySide:
    """Run every contender and both oracles over one reading of a stream, in virtual time.

    Every run has its own copy of the cost, with the same draws. The result does not depend on the
    number of threads that feed the runs; there are as many as cores unless given.
    """
    configs = [
        make_config(
            stream,
            latency_ms=latency_ms,
            seed=seed,
            capacity=capacity,
            anytime=not contender.opaque,
            flush=contender.flush,
        )
        for contender in contenders
    ]
    schemes = [contender.make(latency_ms, cost) for contender in contenders]
    simulators = [
        _core.Simulator(scheme, cost, config)
        for scheme, config in zip(schemes, configs, strict=True)
    ]
    oracles = [_core.Oracle(cost, latency_ms * 1e3, opaque=opaque) for opaque in (False, True)]
    feeds = [simulator.feed for simulator in simulators] + [oracle.feed for oracle in oracles]
    threads = threads if threads is not None else os.cpu_count() or 1
    held: list[Events] = []
    room = _MOST_HELD
    with ThreadPoolExecutor(threads) as pool:  # feeding releases the GIL
        for events in stream:
            room -= events.size
            if room >= 0:
                held.append(events.copy())
            else:
                held.clear()
            for begin in range(0, events.size, _CHUNK):
                chunk = events[begin : begin + _CHUNK]
                _wait_for([pool.submit(feed, chunk) for feed in feeds])
            if on_progress is not None:
                on_progress(stream.events, stream.total_hint, {})
        _wait_for([pool.submit(simulator.finish) for simulator in simulators])
    runs = [
        remember(simulator, stream, config, scheme, cost, mode="virtual")
        for simulator, config, scheme in zip(simulators, configs, schemes, strict=True)
    ]
    exact = _exact(joined(held), cost, latency_ms) if room >= 0 else None
    return SideBySide(runs, oracles[0].bound, oracles[1].bound, exact)


def _exact(events: Events, cost: _core.LinearCost, latency_ms: float) -> int | None:
    try:
        return _core.exact_clairvoyant(events, cost, latency_ms * 1e3, _MOST_EXACT_STEPS)
    except ValueError:  # too many for an exact answer, or no one cost for all
        return None


def _wait_for(tasks: Iterable[Future[None]]) -> None:
    for task in tasks:
        task.result()
