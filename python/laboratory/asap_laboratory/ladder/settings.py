"""The schemes of the ladder: ours with one setting, the baselines with the best that was found.

A baseline has no bound. What keeps its latency down in overload is a small ring, which drops the
newest; so each setting is a scheme and a ring. Two of each baseline are compared at equal latency:
the setting that finished most events within L for this very consumer (hindsight), and the one
setting that did best over the whole ladder. Both have to keep p99 <= L, if any does.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from asap import _core
from asap.experiment import simulate
from asap_laboratory.ladder.rungs import LATENCY_MS
from asap_laboratory.page import Row, Rows, only

OURS = "Deadline"
BASELINES = ("FixedSize", "FixedTime", "Asap2020")

_WHOLE_RING = 1 << 20
_LARGEST_RING = 1 << 22  # of a stream that is faster; 64 MB
_RINGS = tuple(1 << bits for bits in (7, 9, 11, 13, 15, 20))
_RINGS_IN_L = (0.25, 0.45, 0.7, 1.0)  # times the events that cost L


@dataclass(frozen=True)
class Setting:
    """A scheme of `asap` and the ring in front of it, for the stream as it is.

    `for_all`: it can be given without knowing the consumer.
    """

    scheme: str
    parameters: dict[str, float]
    capacity: int = _WHOLE_RING
    for_all: bool = True

    def make(self) -> _core.Scheme:
        """Make the scheme."""
        parameters: dict[str, Any] = self.parameters
        found: _core.Scheme = getattr(_core, self.scheme)(**parameters)
        return found

    def scaled(self, *, rate: float, time: float) -> Setting:
        """Return what is alike for a stream with so much more rate and a bound so much longer."""
        scale = {"size": rate * time, "rate_bound": rate, "latency_ms": time, "period_ms": time}
        return Setting(
            self.scheme,
            {
                name: type(value)(value * scale.get(name, 1))
                for name, value in self.parameters.items()
            },
            min(round(self.capacity * rate * time), _LARGEST_RING),
        )

    def __str__(self) -> str:
        """Write it as a cell of a table."""
        values = ", ".join(f"{name} {value:.4g}" for name, value in self.parameters.items())
        return f"{values}, ring {self.capacity:,}"


def ours(latency_ms: float = LATENCY_MS) -> Setting:
    """Return the one that knows nothing but the bound."""
    return Setting(OURS, {"latency_ms": latency_ms})


def tried(events: NDArray[np.void], alpha_us: float, beta_ns: float) -> Rows:
    """Put every setting of the baselines to a consumer of that cost: how each did."""
    found = []
    for setting in _settings(alpha_us, beta_ns):
        run = simulate(
            events,
            cost=_core.LinearCost(alpha_us, beta_ns),
            scheme=setting.make(),
            latency_ms=LATENCY_MS,
            capacity=setting.capacity,
        )
        p99_ms = run.latency.quantile(0.99) / 1e3
        found.append({**asdict(setting), "in_time": run.in_time, "p99_ms": p99_ms})
    return found


def _settings(alpha_us: float, beta_ns: float) -> Iterable[Setting]:
    in_bound = max(1.0, (LATENCY_MS * 1e6 - alpha_us * 1e3) / max(beta_ns, 1e-3))
    fitting = {max(4, min(_WHOLE_RING, round(share * in_bound))) for share in _RINGS_IN_L}
    rings = [(ring, True) for ring in _RINGS] + [(ring, False) for ring in sorted(fitting)]
    for capacity, for_all in rings:
        for size in (10, 100, 1000, 10_000):
            if size <= capacity:
                yield Setting("FixedSize", {"size": size}, capacity, for_all)
        for period_ms in (0.1, 0.5, 1.5):
            yield Setting("FixedTime", {"period_ms": period_ms}, capacity, for_all)
        for rate_bound in (5e4, 5e5, 5e6) if for_all else ():
            yield Setting("Asap2020", {"rate_bound": rate_bound}, capacity)
    for capacity in (_WHOLE_RING, *fitting):
        for share in (0.5, 0.7, 0.8, 0.9, 0.95):
            for epsilon in (0.02, 0.1):
                parameters = {"rate_bound": share * 1e9 / beta_ns, "epsilon": epsilon}
                yield Setting("Asap2020", parameters, capacity, for_all=False)


def best(found: Rows, scheme: str) -> Setting:
    """Choose with hindsight: most in time of those whose p99 is within L, else the least p99."""
    return _setting(max(only(found, scheme=scheme), key=_merit))


def _merit(row: Row) -> tuple[bool, float]:
    kept = row["p99_ms"] <= LATENCY_MS
    return kept, row["in_time"] if kept else -row["p99_ms"]


def _setting(row: Row) -> Setting:
    return Setting(**{field.name: row[field.name] for field in fields(Setting)})


def best_for_all(ladder: Sequence[Rows], scheme: str) -> Setting:
    """Choose the setting that does best over all consumers.

    Its share in time, of the best that this scheme reached for the consumer, is largest in the
    mean; where its p99 is beyond L it counts nothing.
    """
    merit: dict[str, list[float]] = {}
    known: dict[str, Setting] = {}
    for found in ladder:
        some = only(found, scheme=scheme)
        most = max((row["in_time"] for row in some if row["p99_ms"] <= LATENCY_MS), default=1.0)
        for row in only(some, for_all=True):
            share = row["in_time"] / max(most, 1e-9) if row["p99_ms"] <= LATENCY_MS else 0.0
            setting = _setting(row)
            merit.setdefault(str(setting), []).append(share)
            known[str(setting)] = setting
    return known[max(merit, key=lambda words: sum(merit[words]))]
