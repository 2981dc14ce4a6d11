"""The simulator is believed only where it is checked: real time beside virtual time.

The same stream goes through the same scheme twice: replayed in real time into an algorithm that
spins for a known cost (`BusyWait`), and simulated with that cost. What differs is the machine.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from asap import _core
from asap.experiment import Run, run, simulate
from asap_laboratory import _native
from asap_laboratory.page import Cell, Row, Rows, Tables, only
from asap_laboratory.profiles import Profile
from asap_laboratory.study import Batch, Study

PROFILES = ("low", "uav", "flicker", "steps", "bursts", "high")
_LATENCY_MS = 10.0


@dataclass(frozen=True)
class ClocksCase:
    """One stream in both clocks; alpha and beta are the algorithm's cost, spun and simulated."""

    profile: str
    alpha_us: float = 100.0
    beta_ns: float = 300.0
    duration_s: float = 2.0
    seed: int = 1

    def weight(self) -> float:
        """Seconds, by the million."""
        return 1e6 * self.duration_s

    def measure(self) -> Rows:
        """Run it."""
        events = Profile(self.profile, duration_s=self.duration_s, seed=self.seed).events()
        options: dict[str, Any] = {"latency_ms": _LATENCY_MS, "seed": self.seed}
        cost = _core.LinearCost(self.alpha_us, self.beta_ns)
        busy_wait = _native.BusyWait(self.alpha_us, self.beta_ns)
        both = {
            "real": run(events, algorithm=busy_wait, **options),
            "virtual": simulate(events, cost=cost, **options),
        }
        return [
            {"profile": self.profile, "clock": clock, **_figures(run)}
            for clock, run in both.items()
        ]


def _figures(found: Run) -> Row:
    late = found.lateness  # of the producer
    return {
        "kept": found.kept,
        "in_time": found.in_time,
        "p50_ms": found.latency.quantile(0.5) / 1e3,
        "p99_ms": found.latency.quantile(0.99) / 1e3,
        "max_ms": found.latency.max / 1e3,
        "late_p99_ms": None if late is None else late.quantile(0.99) / 1e3,
        "late_max_ms": None if late is None else late.max / 1e3,
    }


def _batches(form: str) -> Generator[Batch, Rows, None]:
    yield Batch([ClocksCase(profile) for profile in PROFILES], one_at_a_time=True)


def _summary(rows: Rows) -> Tables:
    return {"realtime": rows}


def _facts(tables: Tables) -> dict[str, Any]:
    virtual = {row["profile"]: row for row in only(tables["realtime"], clock="virtual")}
    pairs = [
        {"real": row, "virtual": virtual[row["profile"]], "profile": row["profile"]}
        for row in only(tables["realtime"], clock="real")
    ]
    return {"pairs": pairs}


def _both(name: str, write: Callable[[float], str]) -> Cell:
    return lambda pair: " / ".join(write(pair[clock][name]) for clock in ("real", "virtual"))


def _ms(value: float) -> str:
    return f"{value:.2f}"


REALTIME = Study(
    name="realtime",
    command="asap-study --realtime",
    template=Path(__file__).with_suffix(".md"),
    batches=_batches,
    summary=_summary,
    tables=("realtime",),
    cells={
        **{name: _both(name, lambda value: f"{value:.3f}") for name in ("kept", "in_time")},
        **{name: _both(name, _ms) for name in ("p50_ms", "p99_ms", "max_ms")},
        "late": lambda pair: " / ".join(
            _ms(pair["real"][name]) for name in ("late_p99_ms", "late_max_ms")
        ),
    },
    facts=_facts,
)
