"""A comparison as text."""

from dataclasses import replace

import numpy as np
import pytest

import asap
import streams
from asap.results import text as text_of

COST = asap.LinearCost(alpha_us=100, beta_ns=300)
EVENTS = streams.poisson(6e6, 0.05)


@pytest.fixture(scope="module")
def comparison():
    return asap.compare(EVENTS, cost=COST, latency_ms=5)


def row(label="A", score=0.5, p99_us=4000.0, max_us=4500.0, **others):
    values = {"in_time": 0.3, "kept": 0.4, "p50_us": 900.0, "gap_us": 0, "overflow": 0.0}
    values |= {"packages_per_s": 1234.5, "cpu": 0.987, "scheme": label.lower(), **others}
    return asap.experiment.Row(label=label, score=score, p99_us=p99_us, max_us=max_us, **values)


def verdict(comparison, *rows, **others):
    return text_of.comparison_verdict(replace(comparison, rows=list(rows), **others))


def test_a_line_for_each_scheme_between_head_and_oracle(comparison):
    lines = str(comparison).splitlines()
    assert lines[0] == "array: 8 schemes beside the oracle"
    head = next(i for i, line in enumerate(lines) if line.startswith("scheme"))
    assert lines[head].split() == list(text_of.COLUMNS)
    names = [line.split("  ")[0] for line in lines[head + 2 : head + 10]]
    assert names == [row.label for row in comparison.rows]
    assert set(lines[head + 1]) == set(lines[head + 10]) == {"-"}
    assert lines[head + 11].split()[:2] == ["oracle", "1.000"]
    assert lines[head + 12] == ""
    assert max(map(len, lines)) <= 100


def test_cells_are_numbers_with_units():
    cells = dict(zip(text_of.COLUMNS, text_of.comparison_cells(row(), 5.0), strict=True))
    assert cells == {
        "scheme": "A",
        "score": "0.500",
        "kept": "40.0 %",
        "p50": "900 us",
        "p99": "4 ms",
        "p99/L": "0.80",
        "max": "4.5 ms",
        "gap": "-",
        "overflow": "-",
        "pkg/s": "1,234",
        "busy": "99 %",
    }
    bad = row(gap_us=12_000, overflow=0.25, p99_us=62_500.0)
    cells = dict(zip(text_of.COLUMNS, text_of.comparison_cells(bad, 5.0), strict=True))
    assert (cells["gap"], cells["overflow"], cells["p99/L"]) == ("12 ms", "25.0 %", "12.5")


def test_the_oracle_shows_what_can_be_kept(comparison):
    share = f"{100 * comparison.oracle / EVENTS.size:.1f} %"
    assert [line[:3] for line in text_of.oracle_rows(comparison)] == [("oracle", "1.000", share)]
    assert text_of.oracle_rows(replace(comparison, opaque=True))[0][0] == "oracle (opaque)"


def test_the_exact_clairvoyant_stands_below_the_oracle_and_in_the_verdict(comparison):
    exact = round(0.8 * comparison.oracle)
    known = replace(comparison, exact=exact)
    share = f"{100 * exact / EVENTS.size:.1f} %"
    assert text_of.oracle_rows(known)[1][:3] == ("exact clairvoyant", "0.800", share)
    lines = str(known).splitlines()
    below = next(i for i, line in enumerate(lines) if line.startswith("oracle"))
    assert lines[below + 1].split()[:3] == ["exact", "clairvoyant", "0.800"]
    words = "that knows all arrivals reaches 80.0 % of it (exact clairvoyant)"
    assert words in verdict(known, row())
    assert "exact" not in verdict(replace(known, exact=round(comparison.oracle)), row())
    assert "exact" not in verdict(comparison, row())


def test_the_subtitle_says_what_was_compared(comparison):
    assert text_of.comparison_subtitle(comparison) == (
        f"sensor unknown, addresses not checked, {EVENTS.size:,} events in 0.05 s; "
        "an algorithm of 100 us per package + 300 ns per event; "
        "latency bound L = 5 ms; virtual time"
    )
    drifting = asap.LinearCost(1, 2, noise=0.1, drift=[1.0, 2.0], outages_ms=[(1.0, 2.0)])
    words = text_of.comparison_subtitle(replace(comparison, cost=drifting, opaque=True, speed=10.0))
    assert "(10 times as fast as recorded)" in words
    assert "per event, noise 0.1, drifting, with outages, package by package as a whole" in words


def test_the_verdict_names_the_best_of_those_that_keep_the_bound(comparison):
    late = row("Late", score=0.9, p99_us=6000.0, max_us=7000.0)
    nearly = row("Nearly", score=0.8, p99_us=4600.0, max_us=6000.0)
    words = verdict(comparison, late, nearly, row("A"))
    assert words.startswith(
        "Nearly processes the most events within 5 ms of all schemes that keep the bound: 80.0 % "
        "of the oracle's, p99 0.92 L. No event is late with A. At most 1 % of the events are late "
        "with Nearly. Read score and p99/L together"
    )
    assert "Late" not in words
    idle = row("Idle", score=0.0, kept=0.0, p99_us=0.0, max_us=0.0)
    assert "Idle" not in verdict(comparison, row("A"), idle)
    assert verdict(comparison, late).startswith("No scheme keeps the bound of 5 ms for 99 %")


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


def test_what_is_shown_as_the_bound_keeps_it(comparison):
    assert "late with A." in verdict(comparison, row(p99_us=5020.0, max_us=5020.0))
    assert "No scheme" in verdict(comparison, row(p99_us=5030.0, max_us=5030.0))


def test_the_verdict_of_a_load_that_is_no_problem(comparison):
    one, two = row("A", score=1.0, p99_us=500.0), row("B", score=0.9996)
    words = verdict(comparison, one, two)
    assert words.startswith(
        "2 schemes process as many events within 5 ms as the oracle; A has the lowest p99, 0.10 L. "
        "No event is late with A and B."
    )
    light = replace(comparison, oracle=float(comparison.received))
    assert "do not overload this algorithm; a larger speed does." in verdict(light, one, two)
    assert "do not overload" not in verdict(replace(light, oracle=0.9 * light.oracle), one, two)
    assert "keep the bound: as many as the oracle, p99 0.10 L." in verdict(comparison, one)
    all_but = (row("A", score=0.9994), row("B", score=0.9994))
    assert "> 99.9 % of the oracle's" in verdict(comparison, *all_but)


def test_long_lists_are_cut(comparison):
    words = verdict(comparison, *(row(label) for label in "ABCDE"))
    assert "late with A, B, C, D and E." in words
    words = verdict(comparison, *(row(label) for label in "ABCDEFG"))
    assert "late with A, B, C and 4 others." in words


def test_a_short_recording_is_told(comparison):
    short = {**comparison.source, "duration_s": 0.0075}
    words = "last for only 1.5 L"
    assert words in verdict(comparison, row(), source=short)
    assert words not in verdict(comparison, row())


def test_the_verdict_where_nothing_can_be_had(comparison):
    assert "one package takes longer" in verdict(comparison, row(), oracle=0.0)
    empty = asap.compare(EVENTS[:0], cost=COST, schemes=[asap.Greedy()])
    assert [(one.score, one.kept) for one in empty.rows] == [(1.0, 1.0)]
    assert "No event was received" in str(empty)
    impossible = asap.compare(
        streams.make(np.arange(10)), cost=asap.LinearCost(1000, 0), latency_ms=0.5
    )
    assert "one package takes longer" in str(impossible)
    assert impossible.oracle == 0
