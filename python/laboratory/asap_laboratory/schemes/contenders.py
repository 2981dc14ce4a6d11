"""The rows of the study's tables: every scheme and rival under the label that the tables use."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from asap import _core
from asap.experiment.comparing import Contender
from asap_laboratory import _native

Make = Callable[[float, _core.LinearCost], _core.Scheme]


def _dead_beat(**parameters: Any) -> Make:
    return lambda latency_ms, cost: _core.DeadBeat(latency_ms=latency_ms, **parameters)


def _deadline(**parameters: Any) -> Make:
    return lambda latency_ms, cost: _core.Deadline(latency_ms=latency_ms, **parameters)


def _asap2020(share: float, epsilon: float) -> Make:
    """Rate bound a = share / beta, of the true beta: the tuning is part of the rival."""
    return lambda latency_ms, cost: _core.Asap2020(
        rate_bound=share * 1e9 / cost.parameters["beta_ns"], epsilon=epsilon
    )


def _asap2022(max_size: int | None = None, min_gamma: float = 0.1) -> Make:
    def make(latency_ms: float, cost: _core.LinearCost) -> _core.Scheme:
        alpha_ms, beta_ms = cost.parameters["alpha_us"] / 1e3, cost.parameters["beta_ns"] / 1e6
        fitting = round(min(max(0.9 * (latency_ms - alpha_ms) / beta_ms, 2000), 50_000))
        return _core.Asap2022(
            min_processing_ms=2 * alpha_ms,
            max_processing_ms=latency_ms,
            min_size=100 if max_size is None else max(10, max_size // 20),
            max_size=fitting if max_size is None else max_size,
            min_gamma=min_gamma,
        )

    return make


# The study's baselines never flush: that is what it holds against them.
_BASELINES = [
    Contender("FixedSize 1000", lambda *_: _core.FixedSize(size=1000), flush=False),
    Contender("FixedSize 5000", lambda *_: _core.FixedSize(size=5000), flush=False),
    Contender("FixedTime 1 ms", lambda *_: _core.FixedTime(period_ms=1.0), flush=False),
    Contender("FixedTime 20 ms", lambda *_: _core.FixedTime(period_ms=20.0), flush=False),
    Contender("SingleEvent", lambda *_: _core.SingleEvent()),
    Contender("Asap2020", _asap2020(0.9, 0.05), flush=False),
    Contender("Asap2022", _asap2022(), flush=False),
    Contender("Spark PID", lambda latency_ms, cost: _native.SparkPid(latency_ms)),
    Contender("Greedy", lambda *_: _core.Greedy()),
    Contender("greedy+clear", lambda latency_ms, cost: _native.GreedyClear(latency_ms)),
    Contender("jAER timer", lambda latency_ms, cost: _native.JaerTimer(latency_ms, cost)),
]
_OURS = [
    Contender("whole DeadBeat", _dead_beat(knee=0.0, overhead=0.0), execution="whole"),
    Contender("DeadBeat L/2", _dead_beat(knee=0.0, overhead=0.0)),
    Contender("DeadBeat", _dead_beat(knee=33.0, overhead=0.0)),
    Contender("DeadBeat oh.25", _dead_beat(knee=33.0, overhead=0.25)),
    Contender("DeadBeat 1kHz", _dead_beat(knee=33.0, overhead=0.0, min_interval_ms=1.0)),
    Contender("whole Deadline", _deadline(overhead=0.0), execution="whole"),
    Contender("Deadline", _deadline(overhead=0.0)),
    Contender("Deadline oh.25", _deadline(overhead=0.25)),
    Contender("Deadline oh.5", _deadline(overhead=0.5)),
]


def _wrong_priors() -> Iterator[Contender]:
    """Deadline, told that the algorithm costs 100 times too much or too little."""
    for alpha in (100.0, 0.01):
        for beta in (100.0, 0.01):
            priors = {"first_alpha_us": 50.0 * alpha, "first_beta_ns": 100.0 * beta}
            label = f"priors alpha x{alpha:g}, beta x{beta:g}"
            yield Contender(label, _deadline(overhead=0.0, **priors))


def _hindsight(family: str) -> Iterator[Contender]:
    """List the settings of which a best row takes the best one per profile, after the fact."""
    if family == "Asap2020":
        for share in (0.3, 0.5, 0.7, 0.8, 0.9, 0.95):
            for epsilon in (0.02, 0.1, 0.3):
                label = f"Asap2020 a={share:g}/beta eps={epsilon:g}"
                yield Contender(label, _asap2020(share, epsilon), flush=False)
    else:
        for max_size in (500, 2000, 8000, 30_000):
            for min_gamma in (0.03, 0.1, 0.3, 1.0):
                label = f"Asap2022 max_size={max_size} min_gamma={min_gamma:g}"
                yield Contender(label, _asap2022(max_size, min_gamma), flush=False)


_PRIORS = list(_wrong_priors())
_BEST = {f"{family} best": list(_hindsight(family)) for family in ("Asap2020", "Asap2022")}
_BY_LABEL = {
    one.label: one
    for one in (*_BASELINES, *_OURS, *_PRIORS, *(one for best in _BEST.values() for one in best))
}

TABLE = tuple(one.label for one in (*_BASELINES, *_OURS))
"""Labels of the tables' rows, the ones with hindsight left out."""

PRIORS = tuple(one.label for one in _PRIORS)
"""Labels of the contenders with wrong priors."""

HINDSIGHT = {label: tuple(one.label for one in best) for label, best in _BEST.items()}
"""Labels of the settings behind each row with hindsight."""


def contender(label: str) -> Contender:
    """Return the contender of that label.

    Raises
    ------
    KeyError
        There is none.
    """
    return _BY_LABEL[label]


_PUBLISHED = ("SingleEvent", "jAER timer", "greedy+clear", "Spark PID")


def baselines(latency_ms: float, cost: _core.LinearCost) -> dict[str, _core.Scheme]:
    """Make the published schedulers for `asap.compare` to run as its `schemes`, by label."""
    return {label: contender(label).make(latency_ms, cost) for label in _PUBLISHED}
