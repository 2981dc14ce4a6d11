"""LadderRow: what all seeds have shown of one consumer."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, fields
from typing import Any, NamedTuple

import numpy as np

from asap.results.data import without_nan
from asap_laboratory.ladder.cases import LadderCase, Loaded, Outcomes, ToldCase
from asap_laboratory.ladder.cost import Costs
from asap_laboratory.ladder.rungs import RUNGS, SLOWDOWN
from asap_laboratory.ladder.settings import Setting
from asap_laboratory.results import Results

FIGURES = tuple(field.name for field in fields(Loaded))


class Mean(NamedTuple):
    """Over the seeds; NaN where the figure does not exist, the spread also with one seed."""

    mean: float
    spread: float

    @classmethod
    def of(cls, values: Iterable[float | None]) -> Mean:
        """Put the seeds together."""
        known = np.array([value for value in values if value is not None and value == value])
        if known.size == 0:
            return cls(math.nan, math.nan)
        return cls(float(known.mean()), float(known.std(ddof=1)) if known.size > 1 else math.nan)


Figures = dict[str, dict[str, Mean]]


@dataclass(frozen=True)
class LadderRow:
    """One consumer under every scheme.

    Attributes
    ----------
    load : float
        Event rate times beta: of all that has to be done, how often the computer would have to be
        there.
    alone : Mean
        Accuracy with all events and no latency.
    virtual, real : dict
        By scheme, the figures of `Loaded`.
    settings : dict
        By scheme.
    late_us : float
        Largest p99 of the producer in real time.
    """

    rung: str
    score: str | None
    stated: bool
    alpha_us: float
    beta_ns: float
    load: float
    seeds: int
    alone: Mean
    virtual: Figures
    real: Figures
    settings: dict[str, Setting]
    late_us: float

    @property
    def possible(self) -> float:
        """Share of the events that the computer can do at most."""
        return min(1.0, 1 / self.load)

    def to_dict(self) -> dict[str, Any]:
        """Return one JSON object; what does not exist (NaN) is None."""
        found: dict[str, Any] = without_nan(asdict(self))
        return found


class OverLatency(NamedTuple):
    """A tracker under our scheme with another bound."""

    rung: str
    latency_ms: float
    kept: Mean
    delivered: Mean
    in_use: Mean


class Told(NamedTuple):
    """A tracker that was not told what its scheme says, but nothing, or the mean of the run."""

    rung: str
    told: str
    in_use: dict[str, Mean]  #: by scheme


def row(
    rung: str,
    costs: Costs,
    settings: dict[str, Setting],
    virtual: Sequence[Outcomes],
    real: Sequence[Outcomes],
) -> LadderRow:
    """Put the seeds of a consumer together."""
    return LadderRow(
        rung,
        RUNGS[rung].score,
        RUNGS[rung].stated is not None,
        costs.alpha_us,
        costs.beta_ns,
        float(np.mean([one.rate_hz for one in virtual])) * costs.beta_ns * 1e-9 * SLOWDOWN,
        len(virtual),
        Mean.of(one.alone for one in virtual),
        _figures(virtual),
        _figures(real),
        settings,
        max((one.late_p99_us or 0.0 for one in real), default=math.nan),
    )


def _figures(seeds: Sequence[Outcomes]) -> Figures:
    return {
        label: {
            name: Mean.of(getattr(one.schemes[label], name) for one in seeds) for name in FIGURES
        }
        for label in (seeds[0].schemes if seeds else ())
    }


def over_latency(results: Results) -> list[OverLatency]:
    """Put the seeds of the cases with other bounds together."""
    found: dict[tuple[str, float], list[Loaded]] = {}
    for case, outcome in results.pairs:
        if isinstance(case, LadderCase) and isinstance(outcome, Outcomes):
            some = found.setdefault((case.rung, case.latency_ms), [])
            some += outcome.schemes.values()
    return [
        OverLatency(
            *key,
            *(Mean.of(getattr(one, name) for one in some) for name in OverLatency._fields[2:]),
        )
        for key, some in found.items()
    ]


def told_rows(results: Results) -> list[Told]:
    """Put the seeds of the cases that were told otherwise together."""
    found: dict[tuple[str, str], list[Outcomes]] = {}
    for case, outcome in results.pairs:
        if isinstance(case, ToldCase) and isinstance(outcome, Outcomes):
            found.setdefault((case.rung, case.told), []).append(outcome)
    return [
        Told(*key, {label: one["in_use"] for label, one in _figures(some).items()})
        for key, some in found.items()
    ]
