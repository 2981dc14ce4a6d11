"""The figure of README: what it shows is what the runs say."""

from __future__ import annotations

import pytest

from asap.experiment import Comparison

pytest.importorskip("matplotlib")

from asap_laboratory import scheme_figure


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    return scheme_figure.simulated()


def test_the_default_scheme_keeps_the_bound_and_finishes_most(comparison: Comparison) -> None:
    ours, *others = (
        comparison.runs["Deadline"],
        *(run for label, run in comparison.runs.items() if label != "Deadline"),
    )
    assert len(others) == 4
    assert ours.latency.max <= 1.01e3 * scheme_figure.LATENCY_MS
    assert ours.in_time > 0.95 * comparison.oracle / comparison.received
    assert all(ours.in_time > 1.2 * run.in_time for run in others)


def test_figure_shows_rate_latency_and_share_of_every_scheme(comparison: Comparison) -> None:
    rate, latency, in_time = scheme_figure.draw(comparison).axes
    assert len(latency.lines) == len(comparison.runs) + 1  # and the bound
    largest = max(float(max(line.get_ydata())) for line in latency.lines)
    assert largest == pytest.approx(max(run.latency.max for run in comparison.runs.values()) / 1e3)
    assert [bar.get_width() for bar in in_time.patches] == [
        pytest.approx(comparison.runs[label].in_time)
        for label in ("Deadline", "Asap2020", "FixedTime", "Greedy", "FixedSize")
    ]
    assert rate.collections
