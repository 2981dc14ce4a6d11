"""What the verdict decides, beside what a simulation with another bound, speed or start shows."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

import asap
import streams
from asap import analysis
from asap.results import diagnosis

Events = Any


def bursts(mean_hz: float, duration_s: float, period_s: float = 0.5) -> Events:
    """Seven tenths of the events come in three tenths of each period."""
    rng = np.random.default_rng(7)
    place = rng.random(round(mean_hz * duration_s))
    within = np.where(place < 0.7, place / 0.7 * 0.3, 0.3 + (place - 0.7) / 0.3 * 0.7)
    period = rng.integers(0, round(duration_s / period_s), place.size)
    return streams.make(np.sort((period + within) * period_s * 1e6))


@dataclass(frozen=True)
class Case:
    """A load on an algorithm of 1 ms per package and 15 us per event, within 50 ms."""

    load: float = 0.3
    alpha_us: float = 1000.0
    beta_ns: float = 15_000.0
    noise: float = 0.1
    latency_ms: float = 50.0
    rate_hz: float | None = None
    in_bursts: bool = False
    outages_ms: tuple[tuple[float, float], ...] = ()
    scheme: Any = None
    execution: str = "whole"

    def run(self, **others: Any) -> asap.Run:
        """Simulate 8 s of it; `others` replace fields."""
        case = replace(self, **others)
        rate_hz = self.rate_hz or self.load / 15e-6
        events = bursts(rate_hz, 8.0) if self.in_bursts else streams.poisson(rate_hz, 8.0)
        cost = asap.LinearCost(
            case.alpha_us,
            case.beta_ns,
            noise=case.noise,
            outages_ms=list(case.outages_ms) or None,
        )
        latency_ms, scheme = case.latency_ms, case.scheme and case.scheme()
        return asap.simulate(
            events, cost=cost, latency_ms=latency_ms, scheme=scheme, execution=case.execution
        )


PAUSES = tuple((at, at + 300.0) for at in np.arange(700.0, 8000.0, 2000.0))
KINDS = [
    ("camera", Case()),
    ("camera", Case(load=0.85)),
    ("camera", Case(outages_ms=PAUSES[:1])),
    ("camera", Case(alpha_us=3000, beta_ns=15, rate_hz=5e4)),
    ("bound", Case(load=0.7, in_bursts=True)),
    ("bound", Case(load=0.85, in_bursts=True, noise=0.0)),
    ("bound", Case(load=0.7, in_bursts=True, execution="anytime")),
    ("algorithm", Case(load=1.3)),
    ("algorithm", Case(load=3.0, in_bursts=True)),
    ("algorithm", Case(load=2.0, outages_ms=PAUSES)),
    ("algorithm", Case(load=2.0, outages_ms=((0.5, 300.0),))),
    ("fixed cost", Case(alpha_us=30_000, beta_ns=15, rate_hz=2e4)),
    ("first call", Case(outages_ms=((0.5, 3000.0),))),
    ("first call", Case(load=0.85, outages_ms=((0.5, 3000.0),), execution="anytime")),
    ("first call", Case(outages_ms=((0.5, 7990.0),))),
    ("pauses", Case(outages_ms=PAUSES)),
    ("pauses", Case(load=0.85, outages_ms=PAUSES, execution="anytime")),
    ("scheme", Case(load=1.1, scheme=asap.Greedy)),
    ("scheme", Case(scheme=lambda: asap.Asap2020(rate_bound=5e3))),
    ("unknown", Case(scheme=asap.SingleEvent)),
    ("unknown", Case(alpha_us=9e6)),  # one package: perhaps only the first takes so long
]


@pytest.mark.parametrize(("limit", "case"), KINDS)
def test_the_verdict_names_what_limits(limit: str, case: Case) -> None:
    run = case.run()
    found = analysis.diagnose(run)
    assert found.limit == limit, str(run)
    assert (run.in_time < 0.95) == (limit != "camera")
    if limit == "bound":
        assert found.bound_us is not None
        assert case.run(latency_ms=found.bound_us / 1e3).in_time > 0.95
    if limit == "algorithm":
        assert found.bound_us is None and np.isinf(found.longest_us)
        faster = 1.1 * found.speedup
        quick = {"alpha_us": case.alpha_us / faster, "beta_ns": case.beta_ns / faster}
        assert case.run(**quick, outages_ms=()).in_time > 0.95
    if limit in ("first call", "pauses"):
        assert case.run(outages_ms=()).in_time > 0.95
        assert found.pauses.first == (limit == "first call")


def test_a_bound_that_the_run_cannot_tell_of_is_not_ruled_out() -> None:
    """Bursts of 2 s: the mean load is below one, and a quarter of the run is 2 s."""
    events = bursts(0.85 / 15e-6, 8.0, period_s=4.0)
    run = asap.simulate(events, cost=asap.LinearCost(1000, 15_000), latency_ms=50)
    found = analysis.diagnose(run)
    assert (found.limit, found.bound_us) == ("algorithm", None)
    assert found.longest_us == pytest.approx(2e6, rel=0.01)


@pytest.mark.parametrize(("held", "limit"), [(None, "pauses"), (0.2, "pauses"), (0.7, "machine")])
def test_pauses_without_a_processor_are_the_machines(held: float | None, limit: str) -> None:
    run = Case(outages_ms=PAUSES).run()
    held_s = held and held * 8 * analysis.diagnose(run).pauses.excess_share
    assert analysis.diagnose(replace(run, held_s=held_s)).limit == limit


def test_what_was_lost_before_the_first_package_came_in_all_that_time() -> None:
    run = Case(outages_ms=((0.0, 3000.0),)).run()
    found = diagnosis.windows(run, 1e5)
    assert found.received[:80] == pytest.approx(2000, rel=0.2)
    assert run.packages["stale"][0] > 50_000
    assert diagnosis.time_s(run)[0] == pytest.approx(3.0, abs=0.01)


def test_a_run_measures_how_long_its_thread_had_no_processor() -> None:
    run = asap.run(streams.poisson(1e4, 0.1), algorithm=lambda events: None, latency_ms=10)
    assert run.held_s is None or 0 <= run.held_s < 60
    assert asap.simulate(streams.make([1]), cost=asap.LinearCost(1, 1)).held_s is None


@pytest.mark.parametrize("noise", [0.1, 0.3, 0.5])
@pytest.mark.parametrize("interrupted", [False, True])
def test_no_slope_is_claimed_that_its_own_error_exceeds(noise: float, interrupted: bool) -> None:
    """A call of 2.5 ms, 15 ns per event: the line of the packages shows up to 700 ns."""
    outages_ms = [(at, at + 5.0) for at in range(3, 2000, 15)] if interrupted else None
    for seed in range(6):
        events = streams.poisson(2e5, 2.0, seed)
        cost = asap.LinearCost(2500, 15, noise=noise, seed=seed, outages_ms=outages_ms)
        run = asap.simulate(events, cost=cost, latency_ms=10, execution="whole")
        found = analysis.fit_cost(run)
        assert found.one_size is not None or abs(found.beta_ns - 15) <= found.beta_error_ns
        assert found.beta_ns == 0 or found.beta_ns > found.beta_error_ns
        assert found.dearest.throughput_hz(10_000) <= 1.1 * 0.5 / 15e-9


@pytest.mark.parametrize("execution", ["whole", "anytime"])
def test_the_error_of_a_slope_holds_that_of_a_few_noisy_packages(execution: str) -> None:
    """A queue that grows gives some twenty packages, each longer than the one before."""
    for seed in range(8):
        events = streams.poisson(2.4e5, 1.0, seed)
        cost = asap.LinearCost(30, 5000, noise=0.2, seed=seed)
        run = asap.simulate(events, cost=cost, scheme=asap.Greedy(), execution=execution)
        found = analysis.fit_cost(run)
        assert abs(found.beta_ns - 5000) <= found.beta_error_ns


def test_packages_that_took_far_longer_are_counted() -> None:
    """The median deviation of 98 % of the packages does not show them."""
    run = Case(outages_ms=PAUSES, noise=0.04).run()
    found = analysis.diagnose(run)
    assert found.cost.noise == pytest.approx(0.04, abs=0.01)
    starts = run.packages["start_us"] / 1000
    ends = starts + run.packages["processing_us"] / 1000
    met = sum(bool(((starts < end) & (ends > begin)).any()) for begin, end in PAUSES)
    assert met >= 3 and (found.pauses.slow, found.pauses.first) == (met, 0)
    assert found.pauses.share == pytest.approx(met * 0.3 / 8, rel=0.1)
    assert f"{met} packages took" in str(run)
