"""The gamma filter from Python beside a NumPy random mask; the result is allocated in both.

pytest tests/bench --benchmark-only
"""

import numpy as np
import pytest

import asap

EVENTS = np.zeros(1_000_000, asap.EVENT_DTYPE)
EVENTS["t"] = np.arange(EVENTS.size)
GAMMAS = (0.05, 0.3, 0.9)


@pytest.mark.parametrize("gamma", GAMMAS)
def test_gamma_filter(benchmark, gamma):
    gamma_filter = asap.GammaFilter()
    kept = benchmark(gamma_filter.apply, EVENTS, gamma)
    assert kept.size == pytest.approx(gamma * EVENTS.size, rel=0.02)


@pytest.mark.parametrize("gamma", GAMMAS)
def test_rival_numpy_mask(benchmark, gamma):
    random = np.random.default_rng(0)
    kept = benchmark(lambda: EVENTS[random.random(EVENTS.size) < gamma])
    assert kept.size == pytest.approx(gamma * EVENTS.size, rel=0.02)
