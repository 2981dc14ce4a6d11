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
