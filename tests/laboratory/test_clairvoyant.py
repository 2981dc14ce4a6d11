"""exact_oracle: the entry to the exact clairvoyant, which tests/cpp/study proves."""

from __future__ import annotations

import numpy as np
import pytest

import asap
from asap_laboratory import exact_oracle


def events_at(t: np.ndarray) -> np.ndarray:
    events = np.zeros(t.size, asap.EVENT_DTYPE)
    events["t"] = t
    return events


def test_whole_packages_reach_a_little_less_than_the_fluid() -> None:
    events = events_at(np.sort(np.random.default_rng(1).integers(0, 200_000, 12_000)))
    cost = asap.LinearCost(1000, 20_000, noise=0.1)
    found = exact_oracle(events, cost=cost, latency_ms=5)
    assert type(found) is int
    assert 0.7 < found / asap.oracle(events, cost=cost, latency_ms=5) < 1


def test_more_events_than_can_be_solved_are_refused_with_the_number_that_fits() -> None:
    with pytest.raises(ValueError, match=r"^events = 200000: too many .* the first \d+ or fewer$"):
        exact_oracle(events_at(np.full(200_000, 5)), cost=asap.LinearCost(1, 0.01), latency_ms=10)
