import dataclasses
import re

import numpy as np
import pytest

import asap
from asap.results import Ledger
from asap.results.diagnosis import verdict as verdict_of
from asap.results.run import format_ledger
from fake_run import empty_run, fake_run


def steady(rate, **parameters):
    return fake_run(rates=(rate, rate), duration_s=1.0, **parameters)


RUNS = {
    "abrupt": fake_run(),
    "losses": steady(4e6, rate_bound=1e6, rejected=7, stale=3000, overflow=5, pending=77),
    "bound": steady(4e6, rate_bound=3.5e6, bound_us=450.0),
    "fixed cost": steady(2e6, rate_bound=None, bound_us=150.0),
    "long name": steady(1e6, source="/a/" + "x" * 90 + ".aedat4", mode="real"),
    "empty": empty_run(),
}


def test_every_loss_stands_in_its_own_line_with_its_cause():
    lines = format_ledger(RUNS["losses"].ledger).splitlines()
    counts = {line.split()[0]: int(line.split()[1].replace(",", "")) for line in lines}
    assert counts == RUNS["losses"].ledger


@pytest.mark.parametrize("missing", [12, -12])
def test_an_unbalanced_ledger_is_not_hidden(missing):
    received = RUNS["losses"].ledger.received + missing
    ledger = Ledger(**dict(RUNS["losses"].ledger, received=received))
    assert format_ledger(ledger).splitlines()[-1] == (
        f"  NOT BALANCED: {missing} events are unaccounted for"
    )


@pytest.mark.parametrize(
    ("run", "words"),
    [
        (steady(1e6), ["Bottleneck: the camera. 100 % processed in time.", "No event was lost."]),
        (steady(12e6), ["the algorithm.", "A longer bound does not help", "times as fast"]),
        (RUNS["bound"], ["Bottleneck: the latency bound.", "use a bound of 4", "% discarded"]),
        (RUNS["losses"], ["the scheme (asap2020).", "asap.compare", "< 0.1 % overflow"]),
        (RUNS["empty"], ["No event was received."]),
    ],
)
def test_the_verdict_says_what_limits_and_what_was_lost(run, words):
    verdict = verdict_of(run)
    assert all(word in verdict for word in words), verdict


@pytest.mark.parametrize(("thinned", "late"), [(1.02, 20), (2.0, 300)])
def test_a_machine_that_cannot_keep_pace_is_neither_the_cameras_nor_the_schemes_fault(
    thinned, late
):
    """However little was lost: each late push stands for 1 ms."""
    lateness_us = np.repeat([60.0, 8000.0], [1000, late])
    run = steady(1e6, mode="real", rate_bound=1e6 / thinned, lateness_us=lateness_us)
    verdict = verdict_of(run)
    assert "Bottleneck: this machine." in verdict
    share = re.search(r"late, by 8 ms at most .* half the bound for ([\d.]+) % of", verdict)[1]
    assert float(share) == pytest.approx(late / 10, abs=0.2)
    quiet = steady(1e6, mode="real", rate_bound=1e6 / thinned)
    assert "Bottleneck: this machine." not in verdict_of(quiet)


@pytest.mark.parametrize(("held_s", "is_blamed"), [(0.1, True), (0.0, False), (None, False)])
def test_a_thread_that_had_no_processor_is_not_the_schemes_fault(held_s, is_blamed):
    run = steady(1e6, rate_bound=None, stale=80_000, mode="real", held_s=held_s)
    verdict = verdict_of(dataclasses.replace(run, lateness=None))
    assert ("Bottleneck: this machine." in verdict) == is_blamed
    assert ("waited for a processor for 100 ms" in verdict) == is_blamed


@pytest.mark.parametrize(
    ("cost", "words"),
    [
        ((100, 300), "at least 250 us .* from 10 ms on .* its speed allows"),
        ((0.05, 3), "at least 10 us .* from 10 us"),
    ],
)
def test_the_bounds_that_a_cost_allows_are_told(cost, words):
    scene = asap.synthetic.FlightOverChairs(duration_s=0.1)
    run = asap.simulate(scene, cost=asap.LinearCost(*cost))
    assert re.search(f"bounds +{words}", str(run))
