"""A comparison as text."""

from dataclasses import replace

import numpy as np
import pytest

import asap
import streams
from asap.results import comparison as results

COST = asap.LinearCost(alpha_us=100, beta_ns=300)
EVENTS = streams.poisson(6e6, 0.05)


@pytest.fixture(scope="module")
def comparison():
    return asap.compare(EVENTS, cost=COST, latency_ms=5)


def row(label="A", score=0.5, p99_us=4000.0, max_us=4500.0, **others):
    values = {"in_time": 0.3, "kept": 0.4, "p50_us": 900.0, "gap_us": 0, "overflow": 0.0}
    values |= {"packages_per_s": 1234.5, "cpu": 0.987, "scheme": label.lower(), "late": 0, **others}
    return asap.experiment.Row(label=label, score=score, p99_us=p99_us, max_us=max_us, **values)


def verdict(comparison, *rows, **others):
    return results.verdict(replace(comparison, rows=list(rows), **others))


def test_a_line_for_each_scheme_between_head_and_oracle(comparison):
    lines = str(comparison).splitlines()
    assert lines[0] == "array: 8 schemes beside the oracle"
    head = next(i for i, line in enumerate(lines) if line.startswith("scheme"))
    assert lines[head].split() == list(results.COLUMNS)
    names = [line.split("  ")[0] for line in lines[head + 2 : head + 10]]
    assert names == [row.label for row in comparison.rows]
    assert set(lines[head + 1]) == set(lines[head + 10]) == {"-"}
    assert lines[head + 11].split()[:2] == ["oracle", "1.000"]
    assert lines[head + 12] == ""
    assert max(map(len, lines)) <= 100


def test_the_verdict_names_the_best_of_those_that_keep_the_bound(comparison):
    late = row("Late", score=0.9, p99_us=6000.0, max_us=7000.0)
    nearly = row("Nearly", score=0.8, p99_us=4600.0, max_us=6000.0, late=7)
    words = verdict(comparison, late, nearly, row("A"))
    assert words.startswith(
        "Nearly processes the most events within 5 ms of all schemes that keep the bound: 80.0 % "
        "of the oracle's, p99 0.92 L. No event is late with A. Up to 0.1 % of the events are late "
        "with Nearly. Read score and p99/L together"
    )
    assert "Late" not in words
    idle = row("Idle", score=0.0, kept=0.0, p99_us=0.0, max_us=0.0)
    assert "Idle" not in verdict(comparison, row("A"), idle)
    assert verdict(comparison, late).startswith("No scheme keeps the bound of 5 ms for 99 %")


@pytest.mark.parametrize("late", [0, 1])
def test_the_number_of_late_events_decides_whether_any_is_late(comparison, late):
    """Not the largest latency, which may exceed the bound by one part of a package."""
    words = verdict(comparison, row("A", max_us=5040.0, late=late))
    assert ("No event is late with A." in words) == (late == 0)
    assert ("Up to 0.1 % of the events are late with A." in words) == (late > 0)


def test_more_than_one_in_a_hundred_may_be_late_where_p99_is_just_above_the_bound(comparison):
    late = round(0.0123 * 0.4 * comparison.received)
    words = verdict(comparison, row("A", p99_us=5010.0, max_us=5040.0, late=late))
    assert "Up to 1.3 % of the events are late with A." in words


def test_the_verdict_names_the_scheme_that_processes_more_than_the_default(comparison):
    default = row("Default", score=0.4, scheme="deadline")
    more, less = row("More", score=0.8), row("Less", score=0.39)
    words = "More processes more in time than Default: 0.800 of the oracle's events "
    words += "instead of 0.400"
    assert f"{words}. " in verdict(comparison, more, default, less)
    late, lost = replace(more, p99_us=7500.0), replace(default, kept=0)
    assert f"{words}, but its p99 is 1.50 L. " in verdict(comparison, late, default, less)
    assert f"{words}, but its p99 is 1.50 L. " in verdict(comparison, late, lost)
    best, same = replace(default, label="Best", score=0.9), replace(more, score=0.4001)
    for rows in ((same, default), (best, more, default), (late, more, less)):
        assert "processes more in time" not in verdict(comparison, *rows)


def test_the_verdict_where_nothing_can_be_had(comparison):
    assert "one package takes longer" in verdict(comparison, row(), oracle=0.0)
    impossible = asap.compare(
        streams.make(np.arange(10)), cost=asap.LinearCost(1000, 0), latency_ms=0.5
    )
    assert "one package takes longer" in str(impossible)
    assert impossible.oracle == 0
