"""LadderCase: one consumer on the stream of one seed, under every scheme, in virtual time.

`LadderReplay` is the same load in real time, on this machine: the algorithm itself at its own cost,
the stream `SLOWDOWN` times as fast and four times over, everything else scaled alike. No accuracy.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, Literal

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
from asap_laboratory.scoring import Scene

REAL_LATENCY_MS = 10.0  #: longer than in virtual time: a system without real time cannot do 3 ms
_REPEATS = 4
_EVENTS = 2_800_000  # of the whole stream


@dataclass(frozen=True)
class Loaded:
    """A consumer under one scheme."""

    kept: float
    in_time: float
    p99_of_bound: float
    max_of_bound: float
    overflow: float  #: of the input
    stale: float
    delivered: float | None = None  #: accuracy of what was delivered
    in_use: float | None = None  #: accuracy at the moment of use


@dataclass(frozen=True)
class Outcomes:
    """What a `LadderCase` or a `LadderReplay` has found."""

    schemes: dict[str, Loaded]  #: by label
    rate_hz: float  #: events per second of the stream, on the clock of the run
    alone: float | None = None  #: accuracy with all events, at once
    late_p99_us: float | None = None  #: of the producer in real time: the machine's own jitter

    @classmethod
    def restored(cls, fields: dict[str, Any]) -> Outcomes:
        """Make it again of what the state file holds."""
        loaded = {label: Loaded(**one) for label, one in fields.pop("schemes").items()}
        return cls(schemes=loaded, **fields)


@dataclass(frozen=True)
class LadderCase:
    """One consumer, one seed, virtual time: alpha and beta are those of a computer so slow."""

    rung: str
    seed: int
    alpha_us: float
    beta_ns: float
    settings: dict[str, Setting]
    size: str = "whole"
    latency_ms: float = LATENCY_MS

    @property
    def name(self) -> str:
        """How it is called on the screen."""
        return f"{self.rung}, seed {self.seed}"

    def weight(self) -> float:
        """Events to be processed, about; the tasks of a seed shall follow each other."""
        return _EVENTS * len(self.settings) - self.seed

    def measure(self) -> Outcomes:
        """Run it."""
        rung, scene = RUNGS[self.rung], stream(self.size, self.seed)
        found = {label: self._under(one, rung, scene) for label, one in self.settings.items()}
        alone = None
        if rung.score:
            alone = self._accuracy(rung, scene, everything(scene), twin=True).delivered
        return Outcomes(found, _rate_hz(scene), alone)

    def _under(self, setting: Setting, rung: LadderRung, scene: Scene) -> Loaded:
        recorder = Recorder() if rung.score else None
        found = simulate(
            scene.events,
            cost=_core.LinearCost(self.alpha_us, self.beta_ns),
            scheme=setting.make(),
            latency_ms=self.latency_ms,
            capacity=setting.capacity,
            algorithm=recorder,
            opaque=rung.opaque,
            seed=self.seed,
        )
        loaded = _loaded(found)
        if recorder is None:
            return loaded
        deliveries = self._as_told(recorder.deliveries(found), found.kept)
        accuracy = self._accuracy(rung, scene, deliveries)
        return dataclasses.replace(loaded, **accuracy._asdict())

    def _as_told(self, deliveries: list[Delivery], kept: float) -> list[Delivery]:
        """Let the scheme say what fraction it keeps."""
        return deliveries

    def _accuracy(
        self, rung: LadderRung, scene: Scene, deliveries: list[Delivery], *, twin: bool = False
    ) -> Used:
        make = rung.twin if twin and rung.twin else rung.make
        if rung.score == "corners":
            detector = make(scene.width, scene.height)
            return corner_accuracy(detector, scene, deliveries, self.latency_ms * 1e3)
        return tracker_accuracy(lambda: make(scene.width, scene.height), scene, deliveries)


@dataclass(frozen=True)
class ToldCase(LadderCase):
    """The same, but the algorithm is told nothing, or the true mean for the whole run."""

    told: Literal["nothing", "mean"] = "nothing"

    @property
    def name(self) -> str:
        """How it is called on the screen."""
        return f"{self.rung}, seed {self.seed}, told {self.told}"

    def _as_told(self, deliveries: list[Delivery], kept: float) -> list[Delivery]:
        return [one._replace(keep=kept if self.told == "mean" else 1.0) for one in deliveries]


@dataclass(frozen=True)
class LadderReplay:
    """One consumer, one seed, real time: the stream is replayed the faster for it."""

    rung: str
    seed: int
    settings: dict[str, Setting]
    size: str = "whole"

    @property
    def name(self) -> str:
        """How it is called on the screen."""
        return f"{self.rung}, seed {self.seed}, real time"

    def weight(self) -> float:
        """Events to be processed, about; the tasks of a seed shall follow each other."""
        return _EVENTS * len(self.settings) - self.seed

    def measure(self) -> Outcomes:
        """Run it."""
        rung, scene = RUNGS[self.rung], stream(self.size, self.seed)
        events = _repeated(scene.events)
        found, late_us = {}, 0.0
        for label, setting in self.settings.items():
            alike = setting.scaled(rate=SLOWDOWN, time=REAL_LATENCY_MS / LATENCY_MS)
            ran = run(
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
            found[label] = _loaded(ran)
            assert ran.lateness is not None  # real time
            late_us = max(late_us, ran.lateness.quantile(0.99))
        return Outcomes(found, SLOWDOWN * _rate_hz(scene), late_p99_us=late_us)


def _repeated(events: NDArray[np.void]) -> NDArray[np.void]:
    """Return the stream several times over, one after the other."""
    found = np.tile(events, _REPEATS)
    found["t"] += np.repeat(np.arange(_REPEATS) * (events["t"][-1] + 1), events.size)
    return found


def _loaded(found: Run) -> Loaded:
    received = max(found.ledger.received, 1)
    return Loaded(
        kept=found.kept,
        in_time=found.in_time,
        p99_of_bound=found.latency.quantile(0.99) / found.latency_bound_us,
        max_of_bound=found.latency.max / found.latency_bound_us,
        overflow=found.ledger.overflow / received,
        stale=found.ledger.stale / received,
    )


def _rate_hz(scene: Scene) -> float:
    stamps = scene.events["t"]
    return float(stamps.size / max(1, stamps[-1] - stamps[0]) * 1e6)
