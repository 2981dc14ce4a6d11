import re

import numpy as np
import pytest

import asap
import streams
from asap.analysis import diagnose
from asap.results import text as text_of
from fake_run import FakeLedger, empty_run, fake_run


def steady(rate, **parameters):
    return fake_run(rates=(rate, rate), duration_s=1.0, **parameters)


RUNS = {
    "abrupt": fake_run(),
    "losses": steady(4e6, rate_bound=1e6, rejected=7, stale=3000, overflow=5, pending=77),
    "bound": steady(4e6, rate_bound=None, bound_us=450.0),
    "fixed cost": steady(2e6, rate_bound=None, bound_us=150.0),
    "long name": steady(1e6, source="/a/" + "x" * 90 + ".aedat4", mode="real"),
    "empty": empty_run(),
}


@pytest.mark.parametrize("run", RUNS.values(), ids=RUNS.keys())
def test_a_table_is_plain_text_that_does_not_wrap(run):
    lines = text_of.format_run(run).splitlines()
    assert all(len(line) <= 80 for line in lines if "xxx" not in line)
    assert "\n".join(lines).isascii() and "\x1b" not in "\n".join(lines)
    assert not any(line != line.rstrip() for line in lines)


def test_the_table_shows_what_was_kept_beside_the_latency():
    text = text_of.format_run(fake_run(rates=(12e6, 12e6), duration_s=1.0, bound_us=700.0))
    run = fake_run(rates=(12e6, 12e6), duration_s=1.0, bound_us=700.0)
    assert f"kept       {100 * run.kept:.1f} %" in text
    assert f"in time    {100 * run.in_time:.1f} % within 700 us" in text
    assert re.search(r"latency    p50 \d+ us, p99 \d+ us, max \S+ [um]s\n", text)
    assert f"packages   {run.packages.size:,}, " in text
    assert f"min {run.packages['gamma'].min():.3f}" in text


def test_every_loss_stands_in_its_own_line_with_its_cause():
    lines = text_of.format_ledger(RUNS["losses"].ledger).splitlines()
    counts = {line.split()[0]: int(line.split()[1].replace(",", "")) for line in lines}
    assert counts == RUNS["losses"].ledger
    assert (
        len(
            {
                line.index(f"{count:,}") + len(f"{count:,}")
                for line, count in zip(lines, counts.values(), strict=True)
            }
        )
        == 1
    )
    assert "did not fit into the buffer" in next(line for line in lines if "overflow" in line)


@pytest.mark.parametrize("missing", [12, -12])
def test_an_unbalanced_ledger_is_not_hidden(missing):
    received = RUNS["losses"].ledger.received + missing
    ledger = FakeLedger(dict(RUNS["losses"].ledger, received=received))
    assert text_of.format_ledger(ledger).splitlines()[-1] == (
        f"  NOT BALANCED: {missing} events are unaccounted for"
    )


def test_no_share_is_told_of_nothing_received():
    ledger = FakeLedger(dict(RUNS["losses"].ledger, received=0))
    assert "%" not in text_of.format_ledger(ledger)


def test_the_title_names_recording_and_scheme():
    summary = fake_run(duration_s=0.1, source="/data/flight.aedat4").summary()
    assert text_of.run_title(summary) == "flight.aedat4: asap2020"
    summary["source"].update(path=None, format="array")
    assert text_of.run_title(summary) == "array: asap2020"


@pytest.mark.parametrize(
    ("width", "height", "words"),
    [
        (None, None, "sensor unknown, addresses not checked"),
        (346, 260, "346 x 260 px"),
        (346, None, "346 x ? px, y not checked"),
        (None, 260, "? x 260 px, x not checked"),
    ],
)
def test_what_is_not_checked_is_said_once(width, height, words):
    sensor = {"width": width, "height": height}
    cost = asap.LinearCost(1, 1)
    run = asap.simulate(streams.make([1, 2]), cost=cost, **sensor)
    assert text_of.run_subtitle(run.summary()).startswith(f"{words}, 2 events in ")
    assert text_of.format_run(run).count("not checked") == words.count("not checked")
    comparison = asap.compare(streams.make([1, 2]), cost=cost, **sensor)
    assert text_of.comparison_subtitle(comparison).startswith(f"{words}, 2 events in ")


def test_the_table_ends_with_the_verdict():
    run = RUNS["abrupt"]
    tail = text_of.format_run(run).split("\n\n")[-1]
    assert tail.replace("\n", " ") == text_of.run_verdict(run)


@pytest.mark.parametrize(
    ("run", "words"),
    [
        (steady(1e6), ["Bottleneck: the camera. 100 % processed in time.", "No event was lost."]),
        (steady(12e6), ["the algorithm.", "A longer bound does not help", "times as fast"]),
        (RUNS["bound"], ["Bottleneck: the latency bound.", "use a bound of 4", "% delivered late"]),
        (RUNS["losses"], ["the scheme (asap2020).", "asap.compare", "< 0.1 % overflow"]),
        (RUNS["empty"], ["No event was received."]),
    ],
)
def test_the_verdict_says_what_limits_and_what_was_lost(run, words):
    verdict = text_of.run_verdict(run)
    assert all(word in verdict for word in words), verdict


@pytest.mark.parametrize(
    ("bad", "in_time", "lost"), [(999, "0.1 %", "99.9 %"), (1000, "0.0 %", "100.0 %")]
)
def test_bad_data_are_told_as_what_limits(bad, in_time, lost):
    events = streams.make(np.arange(1000), x=np.where(np.arange(1000) < bad, 400, 5))
    run = asap.simulate(events, cost=asap.LinearCost(1, 1), width=346, height=260)
    assert text_of.run_verdict(run) == (
        f"Bottleneck: bad events in the data. {in_time} processed in time. {bad:,} of 1,000 events "
        f"were rejected ({bad:,} out_of_bounds). asap.check shows where. Lost: {lost} rejected."
    )


def test_some_bad_data_do_not_hide_what_lost_more():
    assert "Bottleneck: the algorithm." in text_of.run_verdict(steady(12e6, rejected=1_000_000))
    assert "Bottleneck: the camera." in text_of.run_verdict(steady(1e6, rejected=40_000))


def test_what_the_verdict_derives_is_called_estimated():
    verdict = text_of.run_verdict(steady(12e6))
    assert "Estimated cost: 100 us per package + 150 ns per event." in verdict


def test_the_noise_of_the_cost_is_told():
    run = fake_run()
    run.packages["processing_us"] *= np.random.default_rng(0).lognormal(0, 0.1, run.packages.size)
    words = r"Estimated cost: \S+ us per package \+ \S+ ns per event, \+- 10 %\."
    assert re.search(words, text_of.run_verdict(run))


def one_event_at_a_time(cost_us):
    run = steady(1e6, stale=10_000_000)
    run.packages["size"], run.packages["processing_us"], run.in_time = 1, cost_us, 0.01
    return run


def test_packages_of_one_size_give_no_advice():
    run = one_event_at_a_time(600.0)
    verdict = text_of.run_verdict(run)
    assert verdict.startswith(
        "Bottleneck: not known. 1.0 % processed in time. Estimated cost: 600 us per package of 1 "
        "event. These packages are too few, or too alike in size, to tell what of it is per event."
    )
    assert "times as fast" not in verdict
    run.in_time = 1.0
    assert "Estimated cost: 600 us per package of 1 event. Lost: " in text_of.run_verdict(run)


def test_no_factor_is_told_that_would_not_do():
    """By 1.03, of which one digit is 1.0."""
    run = steady(7.0e6, rate_bound=None)
    run.in_time = 0.9
    assert 1 < diagnose(run).speedup < 1.05
    assert "make the algorithm 1.1 times as fast" in text_of.run_verdict(run)


def test_a_machine_that_cannot_keep_pace_is_not_the_schemes_fault():
    run = steady(1e6, mode="real", bound_us=450.0, rate_bound=5e5)
    assert run.in_time < 0.95
    verdict = text_of.run_verdict(run)
    assert "Bottleneck: this machine." in verdict and "late, by 228 us (p99) and 230 us" in verdict


def test_a_free_algorithm_has_no_limit():
    run = steady(1e6, beta_ns=0.0)
    assert "keeps up with any event rate" in text_of.run_verdict(run)


def test_no_line_ends_between_a_number_and_its_unit():
    for run in RUNS.values():
        lines = text_of.format_run(run).split("\n\n")[-1].splitlines()
        assert not any(line[-1].isdigit() for line in lines[:-1])


def test_rejected_events_are_told_by_reason():
    lines = text_of.format_ledger(RUNS["losses"].ledger, {"nonmonotonic": 7, "bad_record": 0})
    after = lines.splitlines()[2]
    assert after.strip() == "7 nonmonotonic"
    none = text_of.format_ledger(RUNS["losses"].ledger, {"nonmonotonic": 0})
    assert len(none.splitlines()) == 8


def test_real_time_is_shown_with_the_machines_own_jitter():
    real = text_of.format_run(fake_run(duration_s=0.1, mode="real", speed=2.0))
    assert "real time at 2 times the speed" in real
    slow = fake_run(duration_s=0.1, mode="real", speed=0.5).summary()
    assert "real time at 0.5 times the speed" in text_of.run_subtitle(slow)
    assert "jitter     p99 230 us, max 230 us" in real
    assert "jitter" not in text_of.format_run(fake_run(duration_s=0.1))


def test_verdict_names_a_rate_bound_that_would_be_in_the_way():
    cost = asap.LinearCost(alpha_us=100, beta_ns=300)
    events = streams.poisson(6e6, 0.1)
    low, high = (
        asap.simulate(events, cost=cost, scheme=asap.Asap2020(rate_bound=bound))
        for bound in (2e6, 1e9)
    )
    assert "rate_bound" in text_of.run_verdict(low)
    assert "rate_bound" not in text_of.run_verdict(high)


def test_a_bound_that_cannot_be_kept_is_told_with_what_would_be_needed():
    run = RUNS["fixed cost"]
    p99, most = (f"{us / 150:.3g}" for us in (run.latency.quantile(0.99), run.latency.max))
    assert text_of.run_verdict(run).startswith(
        "Bottleneck: the fixed cost of a package. 0.0 % processed in time. Estimated cost: 100 us "
        "per package + 150 ns per event. No scheme can keep a bound of 150 us at this cost: "
        f"latency was {p99} (p99) and {most} (max) times as long. Use a bound of at least 250 us, "
        "or a fixed cost of 60 us or less. Lost: "
    )


@pytest.mark.parametrize(
    ("beta_ns", "latency_ms", "bound", "event"),
    [(5e6, 5, "10.2 ms", "2.5 ms"), (2e5, 0.5, "600 us", "250 us")],
)
def test_events_that_are_too_dear_one_by_one_are_told_as_that(beta_ns, latency_ms, bound, event):
    cost = asap.LinearCost(100, beta_ns)
    run = asap.simulate(streams.poisson(1e3, 1), cost=cost, latency_ms=latency_ms, opaque=True)
    words = f"a bound of at least {bound}, or an algorithm that processes a single event in {event}"
    assert words in text_of.run_verdict(run)


def test_nothing_is_said_about_a_cost_that_was_never_seen():
    run = fake_run(duration_s=0.0, stale=10)
    words = "No event reached the algorithm. Lost: 100.0 % stale."
    assert text_of.run_verdict(run) == words


def test_a_parameter_that_is_not_set_is_not_shown():
    run = steady(1e6)
    run.scheme.parameters = {"efficiency": None, "rate_bound": 0}
    assert "scheme asap2020 (rate_bound 0)" in text_of.run_subtitle(run.summary())
    run.scheme.parameters = {"efficiency": None}
    assert text_of.run_subtitle(run.summary()).endswith("scheme asap2020")
