"""What the verdict decides, beside what a simulation with another bound, speed or start shows."""

from __future__ import annotations

import pytest

import asap
import streams
from asap import analysis


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
