"""A comparison as figure and as page."""

import numpy as np
import pytest

import asap
import streams

pytest.importorskip("matplotlib")

from asap import plots

COST = asap.LinearCost(alpha_us=100, beta_ns=300)
EVENTS = streams.poisson(6e6, 0.05)


@pytest.fixture(scope="module")
def comparison():
    schemes = {"greedy & co <b>": asap.Greedy(), "ours": asap.Deadline(latency_ms=5)}
    return asap.compare(EVENTS, cost=COST, schemes=schemes)


def test_the_curves_are_those_of_the_slots(comparison):
    axes = plots.comparison_figure(comparison, points=10).axes
    slots = comparison.runs["ours"].slots
    assert slots.size == 50
    time_s, latency_ms = axes[2].get_lines()[0].get_data()
    np.testing.assert_allclose(time_s, 0.0025 + 0.005 * np.arange(10))
    windows = slots["latency_max_us"].reshape(10, 5)
    np.testing.assert_allclose(latency_ms, windows.max(axis=1) / 1e3)
    bound = axes[2].get_lines()[1]
    assert bound.get_ydata()[0] == 5 and bound.get_label() == "bound L"
    received = slots["received"].reshape(10, 5).sum(axis=1)
    rate = axes[0].collections[0].get_paths()[0].vertices[:, 1]
    assert rate.max() == pytest.approx(received.max() / 0.005 / 1e6)
    kept = axes[3].collections[0].get_paths()[0].vertices[:, 1]
    delivered = slots["delivered"].reshape(10, 5).sum(axis=1)
    assert kept.max() == pytest.approx((delivered / received).max())


def test_a_label_is_no_formula():
    found = asap.compare(EVENTS[:100], cost=COST, schemes={"5 $^$": asap.Greedy()})
    assert plots.svg(found.plot())
