"""What `Deadline` keeps within its bound: over L / alpha, and where calls are disturbed.

The first table is a share of the exact clairvoyant; the second stands beside `Greedy`, which drops
nothing: where events are not what costs, nothing can be gained by dropping them.
"""

from __future__ import annotations

import itertools
import statistics
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from asap import _core
from asap.experiment import compare, simulate
from asap_laboratory import _native
from asap_laboratory.page import Row, Rows, Tables, Writer, figure, only, over_seeds
from asap_laboratory.profiles import Profile
from asap_laboratory.profiles.rates import Floats
from asap_laboratory.rivals.recordings import data_folder
from asap_laboratory.schemes.contenders import baselines
from asap_laboratory.study import Batch, Study

PREFERENCES = ("balanced", "events", "continuity")
EXECUTIONS = ("anytime", "whole")
LATENCY_MS = 10.0
_SEEDS = {"quick": range(2000, 2002), "default": range(2000, 2020), "full": range(2000, 2020)}

# ---- L over the fixed cost ----------------------------------------------------------------------

RATIOS = (100, 50, 30, 20, 10, 5, 3)
_EVENTS_PER_BOUND = 150  # at load 1
_BOUNDS = 100  # a run's length


def _by_turns(first: float, bounds: float, then: float) -> Callable[[Floats], Floats]:
    """Return a load of `first` for so many bounds of every ten, then of `then`."""
    return lambda t: np.where(t * 1e3 / LATENCY_MS % 10 < bounds, first, then)


LOADS: dict[str, Callable[[Floats], Floats]] = {
    "load 1.1": lambda t: np.full_like(t, 1.1),
    "load 1.5": lambda t: np.full_like(t, 1.5),
    "load 3": lambda t: np.full_like(t, 3.0),
    "bursts": _by_turns(4.0, 2, 0.5),
    "on and off": _by_turns(2.5, 5, 0.02),  # an event lost in the off time makes a long gap alone
}


@dataclass(frozen=True)
class BoundCase:
    """One stream and cost, under every preference, taken in parts and whole."""

    ratio: int
    load: str
    seed: int

    def weight(self) -> float:
        """Events, about; most of the time is the clairvoyant's."""
        return 1.5 * _EVENTS_PER_BOUND * _BOUNDS

    def measure(self) -> Rows:
        """Run it."""
        per_s = _EVENTS_PER_BOUND / (1e-3 * LATENCY_MS)
        duration_s = 1e-3 * LATENCY_MS * _BOUNDS
        rate = LOADS[self.load]
        events = Profile(
            lambda t: per_s * rate(t), duration_s=duration_s, seed=self.seed, noise=0
        ).events()
        alpha_us = 1e3 * LATENCY_MS / self.ratio
        cost = _core.LinearCost(alpha_us, (1e6 * LATENCY_MS - 1e3 * alpha_us) / _EVENTS_PER_BOUND)
        possible = _native.exact_clairvoyant(events, cost, 1e3 * LATENCY_MS)
        rows = []
        for prefer, execution in itertools.product(PREFERENCES, EXECUTIONS):
            scheme = _core.Deadline(latency_ms=LATENCY_MS, prefer=prefer)
            run = simulate(events, cost=cost, scheme=scheme, execution=execution)
            rows.append(
                {
                    "kind": "bound",
                    "ratio": self.ratio,
                    "load": self.load,
                    "prefer": prefer,
                    "execution": execution,
                    "share": run.in_time * events.size / possible,
                    "gap": (run.gap_us or 0) / (1e3 * LATENCY_MS),
                }
            )
        return rows


# ---- disturbed calls ----------------------------------------------------------------------------


@dataclass(frozen=True)
class Disturbed:
    """One case: a cost, what disturbs it, and the stream that it meets. Whole packages."""

    kind: str
    alpha_us: float
    beta_ns: float
    rate_hz: float = 5e5
    burst: float = 1  # factor on the rate in every other quarter of a second
    noise: float = 0.1
    every_ms: float = 0  # from interruption to interruption
    length_ms: float = 0
    at_random: bool = False  # exponential, and not regular
    tripled: float = 0  # share of the calls that take three times as long
    duration_s: float = 2


def _disturbed() -> Iterator[Disturbed]:
    regular: list[dict[str, Any]] = [
        {"every_ms": every, "length_ms": length}
        for every, length in ((30, 8), (50, 8), (100, 8), (15, 5))
    ]
    at_random: list[dict[str, Any]] = [
        {"every_ms": every, "length_ms": length, "at_random": True}
        for every, length in ((40, 4), (20, 2), (100, 10))
    ]
    some = [regular[0], *at_random]
    for alpha, outage in itertools.product((300, 1000, 2500), regular + at_random):
        yield Disturbed("flat, interrupted", alpha, 0, burst=2, **outage)
    for alpha, noise in itertools.product((600, 1000, 3000), (0.3, 0.5)):
        yield Disturbed("flat, noise .3 and .5", alpha, 15, burst=2, noise=noise)
    for ratio, noise in itertools.product((2.6, 3.3, 5, 10), (0.1, 0.2, 0.3, 0.5)):
        yield Disturbed("noise .1 to .5, .2 Mev/s", 1e4 / ratio, 15, rate_hz=2e5, noise=noise)
    for ratio, beta in itertools.product((2.6, 3.3, 5, 10, 20, 100), (0, 300)):
        yield Disturbed(
            "collector: 15 ms of every 200", 1e4 / ratio, beta, burst=2, every_ms=200, length_ms=15
        )
    for ratio, share, beta in itertools.product((2.6, 3.3, 5, 10, 20, 100), (0.1, 0.3), (0, 300)):
        yield Disturbed(
            "1 and 3 in 10 calls three times as long",
            *(1e4 / ratio, beta),
            burst=1.5,
            noise=0.05,
            tripled=share,
            duration_s=1.2,
        )
    for beta, outage in itertools.product((100, 500, 1000), some):
        yield Disturbed("light load, interrupted", 100, beta, duration_s=1.2, **outage)
    for ratio in (3, 5, 10, 30):
        yield Disturbed("flat, steady", 1e4 / ratio, 1, burst=2, duration_s=1.2)
    for load, ratio, noise in itertools.product((0.5, 0.9, 1.2, 2), (3.3, 5, 20), (0.3, 0.5)):
        yield Disturbed(
            "load .5 to 2, noise .3 and .5", 1e4 / ratio, 2e3 * load, noise=noise, duration_s=1.2
        )
    for beta, outage in itertools.product((2500, 6000), some):
        yield Disturbed("overload, interrupted", 200, beta, duration_s=1.2, **outage)


DISTURBED = tuple(_disturbed())


@dataclass(frozen=True)
class DisturbedCase:
    """One of `DISTURBED` under Greedy and under Deadline."""

    number: int
    seed: int

    def weight(self) -> float:
        """Events, about."""
        case = DISTURBED[self.number]
        return case.rate_hz * case.duration_s

    def measure(self) -> Rows:
        """Run it."""
        case = DISTURBED[self.number]
        chance = np.random.default_rng([self.seed, self.number])
        events = Profile(
            lambda t: case.rate_hz * np.where(t % 0.5 > 0.25, case.burst, 1),
            duration_s=case.duration_s,
            seed=self.seed,
            noise=0,
        ).events()
        outages = list(_outages(case, chance))
        linear = _core.LinearCost(
            *(case.alpha_us, case.beta_ns),
            noise=case.noise,
            seed=self.seed,
            outages_ms=np.array(outages) if outages else None,
        )
        rows = []
        for scheme in (_core.Greedy(), _core.Deadline(latency_ms=LATENCY_MS)):
            cost: Any = _tripled(case, self.seed) if case.tripled else linear
            options: dict[str, Any] = {"latency_ms": LATENCY_MS, "execution": "whole"}
            run = simulate(events, cost=cost, scheme=scheme, **options)
            rows.append(
                {
                    "kind": "disturbed",
                    "case": case.kind,
                    "number": self.number,
                    "scheme": scheme.name,
                    "in_time": run.in_time,
                    "late": run.kept - run.in_time,
                    "p99": run.latency.quantile(0.99) / (1e3 * LATENCY_MS),
                }
            )
        return rows


def _tripled(case: Disturbed, seed: int) -> Callable[[int, float], float]:
    """Return the cost of calls of which some take three times as long."""
    chance = np.random.default_rng(seed)

    def cost(n: int, t_us: float) -> float:
        noise = chance.lognormal(-(case.noise**2) / 2, case.noise)
        usual = case.alpha_us + 1e-3 * case.beta_ns * n
        return float(noise * usual * (3 if chance.random() < case.tripled else 1))

    return cost


def _outages(case: Disturbed, chance: np.random.Generator) -> Iterator[tuple[float, float]]:
    """Begin and end of each interruption, ms."""
    if not case.every_ms:
        return
    begin = case.every_ms * (0.5 + chance.random())
    while begin < 1e3 * case.duration_s:
        length = case.length_ms
        rest = case.every_ms - length
        if case.at_random:
            length = min(max(chance.exponential(length), 0.01), 6 * length)
            rest = chance.exponential(case.every_ms)
        yield begin, begin + length
        begin += length + max(rest, 0.02)


# ---- recordings ---------------------------------------------------------------------------------

_OFFICE, _SLIDER, _CARS = (
    "aedat/office_davis346.aedat4",
    "text/slider_davis240.txt",
    "aedat/cars_davis346.aedat4",
)


@dataclass(frozen=True)
class RecordingCase:
    """A recording under Deadline, DeadBeat and every baseline; anytime."""

    path: str  # below ASAP_TEST_DATA
    speed: float
    alpha_us: float
    beta_ns: float
    latency_ms: float

    def weight(self) -> float:
        """Events, about."""
        return 1e5

    def measure(self) -> Rows:
        """Run it."""
        cost = _core.LinearCost(self.alpha_us, self.beta_ns)
        ours: dict[str, _core.Scheme] = {
            "Deadline": _core.Deadline(latency_ms=self.latency_ms),
            "DeadBeat": _core.DeadBeat(latency_ms=self.latency_ms),
        }
        found = compare(
            data_folder() / self.path,
            cost=cost,
            schemes=ours | baselines(self.latency_ms, cost),
            latency_ms=self.latency_ms,
            speed=self.speed,
        )
        return [
            {
                "kind": "recording",
                "recording": f"{Path(self.path).stem} x{self.speed:g}",
                "cost": f"{self.alpha_us:g} us + {1e-3 * self.beta_ns:g} us",
                "latency_ms": self.latency_ms,
                "scheme": row.label,
                "score": row.score,
                "p99": row.p99_us / (1e3 * self.latency_ms),
                "gap_ms": 1e-3 * row.gap_us,
            }
            for row in found.rows
        ]


RECORDINGS = (
    *(RecordingCase(_OFFICE, speed, 100, 300, 10) for speed in (5, 10)),
    *(RecordingCase(_OFFICE, 1, 100, 2000, latency) for latency in (10, 4)),
    RecordingCase(_OFFICE, 1, 20, 2000, 4),
    *(RecordingCase(_SLIDER, speed, 100, 300, 2) for speed in (10, 15)),
    RecordingCase(_SLIDER, 30, 100, 300, 10),
    RecordingCase(_SLIDER, 1, 100, 4000, 10),
    RecordingCase(_SLIDER, 1, 20, 4000, 4),
    RecordingCase(_CARS, 1, 100, 40_000, 10),
)


# ---- the study ----------------------------------------------------------------------------------


def _batches(form: str) -> Generator[Batch, Rows, None]:
    seeds = _SEEDS[form]
    yield Batch([BoundCase(*one) for one in itertools.product(RATIOS, LOADS, seeds)])
    yield Batch([DisturbedCase(*one) for one in itertools.product(range(len(DISTURBED)), seeds)])
    yield Batch([one for one in RECORDINGS if (data_folder() / one.path).exists()])


def _summary(rows: Rows) -> Tables:
    bounds = []
    for ratio, prefer, execution in itertools.product(RATIOS, PREFERENCES, EXECUTIONS):
        cell = only(rows, kind="bound", ratio=ratio, prefer=prefer, execution=execution)
        gaps = [row["gap"] for row in cell if row["load"] != "on and off"]
        bounds.append(
            {
                "ratio": ratio,
                "prefer": prefer,
                "execution": execution,
                "share": statistics.fmean(row["share"] for row in cell),
                "gap": statistics.median(gaps),
                "longest": max(gaps),
                "runs": len(cell),
            }
        )
    figures = ("in_time", "late", "p99")
    cases = over_seeds(only(rows, kind="disturbed"), ("case", "number", "scheme"), figures)
    disturbed = []
    for kind in dict.fromkeys(case.kind for case in DISTURBED):
        greedy, ours = (only(cases, case=kind, scheme=one) for one in ("greedy", "deadline"))
        ratios = [
            our["in_time"] / max(its["in_time"], 1e-9)
            for its, our in zip(greedy, ours, strict=True)
        ]
        disturbed.append(
            {
                "case": kind,
                "cases": len(ours),
                "greedy": statistics.fmean(row["in_time"] for row in greedy),
                "deadline": statistics.fmean(row["in_time"] for row in ours),
                "least": min(ratios),
                "late": statistics.fmean(row["late"] for row in ours),
                "p99": statistics.fmean(row["p99"] for row in ours),
                "greedy_p99": statistics.fmean(row["p99"] for row in greedy),
            }
        )
    return {"bounds": bounds, "disturbed": disturbed, "recordings": _recordings(rows)}


def _recordings(rows: Rows) -> Rows:
    """Put the schemes of a recording into one row, of the baselines only the best."""
    found = []
    for case in over_seeds(
        only(rows, kind="recording"), ("recording", "cost", "latency_ms"), ("score",)
    ):
        key = {name: case[name] for name in ("recording", "cost", "latency_ms")}
        runs = {row["scheme"]: row for row in only(rows, kind="recording", **key)}
        ours = {name: runs.pop(name) for name in ("Deadline", "DeadBeat", "jAER timer")}
        others = [row for row in runs.values() if row["p99"] <= 1]
        best = max(others, key=lambda row: float(row["score"]), default=None)
        cells = {name: _cell(row) for name, row in ours.items()}
        found.append(
            key | cells | {"other": "-" if best is None else f"{best['scheme']} {_cell(best)}"}
        )
    return found


def _cell(run: Row) -> str:
    return f"{run['score']:.3f}, {run['p99']:.2f}, {run['gap_ms']:.1f}"


def _facts(tables: Tables) -> dict[str, Any]:
    runs = int(tables["bounds"][0]["runs"])
    return {"runs": runs, "seeds": runs // len(LOADS)}


def _shown(tables: Tables, writer: Writer) -> str:
    whole = only(tables["bounds"], execution="whole")
    ours = {"case": "", "greedy": "Greedy", "deadline": "Deadline", "least": "least"}
    parts = [
        "in time of what is possible, whole packages",
        writer.pivot(whole, {"ratio": "L / alpha"}, "prefer", "share"),
        "in time where calls are disturbed",
        writer.listing(tables["disturbed"], ours),
    ]
    return "\n\n".join(parts)


def _latencies(row: Row) -> str:
    ours = f"{row['p99']:.2f}"
    return f"{row['greedy_p99']:.2f}, {f'**{ours}**' if row['p99'] > 1 else ours}"


BOUNDS = Study(
    name="bounds",
    command="asap-study --bounds",
    template=Path(__file__).with_name("bounds.md"),
    batches=_batches,
    summary=_summary,
    tables=("bounds", "disturbed", "recordings"),
    cells={
        "share": figure("share"),
        "gaps": lambda row: f"{row['gap']:.2f} / {row['longest']:.2f}".replace("0.", "."),
        "greedy": figure("greedy"),
        "deadline": figure("deadline"),
        "least": lambda row: "-" if row["least"] > 2 else f"{row['least']:.3f}".lstrip("0"),
        "late": figure("late"),
        "p99": _latencies,
    },
    facts=_facts,
    shown=_shown,
)
