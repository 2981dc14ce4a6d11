"""LadderCase: one consumer on the stream of one seed, under every scheme, in virtual time.

`LadderReplay` is the same load in real time, on this machine: the algorithm itself at its own cost,
the stream `SLOWDOWN` times as fast and four times over, everything else scaled alike. No accuracy.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from asap import _core
from asap.experiment import Run, run, simulate
from asap_laboratory import _native
from asap_laboratory.ladder.accuracy import (
    Delivery,
    Recorder,
    Used,
    corner_accuracy,
    everything,
    tracker_accuracy,
)
from asap_laboratory.ladder.rungs import LATENCY_MS, RUNGS, SLOWDOWN, LadderRung, stream
from asap_laboratory.ladder.settings import Setting
from asap_laboratory.page import Row, Rows
from asap_laboratory.scoring import Scene

REAL_LATENCY_MS = 10.0  #: longer than in virtual time: a system without real time cannot do 3 ms
_REPEATS = 4
_EVENTS = 2_800_000  # of the whole stream


@dataclass(frozen=True)
class LadderCase:
    """One consumer, one seed, virtual time: alpha and beta are those of a computer so slow.

    The algorithm is told the fraction that it gets by the scheme, or nothing, or the true mean of
    the whole run.
    """

    rung: str
    seed: int
    alpha_us: float
    beta_ns: float
    settings: dict[str, Setting]
    size: str = "whole"
    latency_ms: float = LATENCY_MS
    told: Literal["by the scheme", "nothing", "mean"] = "by the scheme"

    def weight(self) -> float:
        """Events to be processed, about; the tasks of a seed shall follow each other."""
        return _EVENTS * len(self.settings) - self.seed

    def measure(self) -> Rows:
        """Run it."""
        rung, scene = RUNGS[self.rung], stream(self.size, self.seed)
        alone = None
        if rung.score:
            alone = self._accuracy(rung, scene, everything(scene)).delivered
        what = {**self._what(), "rung": self.rung, "seed": self.seed, "rate_hz": _rate_hz(scene)}
        return [
            {**what, "scheme": label, "alone": alone, **self._under(setting, rung, scene)}
            for label, setting in self.settings.items()
        ]

    def _what(self) -> Row:
        if self.told != "by the scheme":
            return {"kind": "told", "told": self.told}
        if self.latency_ms != LATENCY_MS or len(self.settings) == 1:
            return {"kind": "bound", "latency_ms": self.latency_ms}
        return {"kind": "run", "clock": "virtual"}

    def _under(self, setting: Setting, rung: LadderRung, scene: Scene) -> Row:
        recorder = Recorder() if rung.score else None
        found = simulate(
            scene.events,
            cost=_core.LinearCost(self.alpha_us, self.beta_ns),
            scheme=setting.make(),
            latency_ms=self.latency_ms,
            capacity=setting.capacity,
            algorithm=recorder,
            seed=self.seed,
        )
        if recorder is None:
            return _loaded(found)
        deliveries = self._as_told(recorder.deliveries(found), found.kept)
        return {**_loaded(found), **self._accuracy(rung, scene, deliveries)._asdict()}

    def _as_told(self, deliveries: list[Delivery], kept: float) -> list[Delivery]:
        """Let the scheme say what fraction it keeps, or replace what it says."""
        if self.told == "by the scheme":
            return deliveries
        return [one._replace(gamma=kept if self.told == "mean" else 1.0) for one in deliveries]

    def _accuracy(self, rung: LadderRung, scene: Scene, deliveries: list[Delivery]) -> Used:
        make = partial(rung.make, scene.width, scene.height)
        if rung.score == "corners":
            return corner_accuracy(make(), scene, deliveries, self.latency_ms * 1e3)
        return tracker_accuracy(make, scene, deliveries)


@dataclass(frozen=True)
class LadderReplay:
    """One consumer, one seed, real time: the stream is replayed the faster for it."""

    rung: str
    seed: int
    settings: dict[str, Setting]
    size: str = "whole"

    def weight(self) -> float:
        """Events to be processed, about; the tasks of a seed shall follow each other."""
        return _EVENTS * len(self.settings) - self.seed

    def measure(self) -> Rows:
        """Run it."""
        rung, scene = RUNGS[self.rung], stream(self.size, self.seed)
        events = _repeated(scene.events)
        what = {"kind": "run", "clock": "real", "rung": self.rung, "seed": self.seed}
        rows = []
        for label, setting in self.settings.items():
            alike = setting.scaled(rate=SLOWDOWN, time=REAL_LATENCY_MS / LATENCY_MS)
            found = run(
                events,
                algorithm=_native.BusyWait(*rung.stated)
                if rung.stated
                else rung.make(scene.width, scene.height),
                scheme=alike.make(),
                latency_ms=REAL_LATENCY_MS,
                speed=SLOWDOWN,
                capacity=alike.capacity,
                seed=self.seed,
            )
            assert found.lateness is not None  # real time
            late_us = found.lateness.quantile(0.99)  # of the producer: the machine's own jitter
            rows.append({**what, "scheme": label, **_loaded(found), "late_us": late_us})
        return rows


def _repeated(events: NDArray[np.void]) -> NDArray[np.void]:
    """Return the stream several times over, one after the other."""
    found = np.tile(events, _REPEATS)
    found["t"] += np.repeat(np.arange(_REPEATS) * (events["t"][-1] + 1), events.size)
    return found


def _loaded(found: Run) -> Row:
    """Return what a scheme made of the stream: shares of the input, latencies in L."""
    received = max(found.ledger.received, 1)
    return {
        "kept": found.kept,
        "in_time": found.in_time,
        "p99_of_bound": found.latency.quantile(0.99) / found.latency_bound_us,
        "max_of_bound": found.latency.max / found.latency_bound_us,
        "overflow": found.ledger.overflow / received,
        "stale": found.ledger.stale / received,
    }


def _rate_hz(scene: Scene) -> float:
    stamps = scene.events["t"]
    return float(stamps.size / max(1, stamps[-1] - stamps[0]) * 1e6)
