from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import asap
from asap import analysis
from asap._core import PACKAGE_DTYPE
from asap.results import diagnosis
from fake_run import fake_run

EVENT_DTYPE = np.dtype(
    {
        "names": ["x", "y", "p", "t"],
        "formats": ["<u2", "<u2", "<i2", "<i8"],
        "offsets": [0, 2, 4, 8],
        "itemsize": 16,
    }
)


def events_at(t, p=1):
    events = np.zeros(len(t), EVENT_DTYPE)
    events["t"], events["p"] = t, p
    return events


def packages(**columns):
    rows = np.zeros(len(next(iter(columns.values()))), PACKAGE_DTYPE)
    for name, values in columns.items():
        rows[name] = values
    return rows


def test_rate_counts_half_open_windows_from_the_first_event():
    time_s, rate_hz = analysis.rate(events_at([1000, 1000, 1999, 2000, 4500]), 1000)
    assert time_s.tolist() == [0, 0.001, 0.002, 0.003]
    assert rate_hz.tolist() == [3000, 1000, 0, 1000]


@given(st.lists(st.integers(0, 100_000), max_size=200), st.lists(st.integers(0, 200), max_size=5))
def test_description_does_not_depend_on_the_cuts(t, cuts):
    events = events_at(np.sort(np.array(t, np.int64)) + 10**15, p=np.arange(len(t)) % 2)
    whole = analysis.describe([events])
    assert analysis.describe(np.split(events, sorted(cuts))) == whole
    if t:
        elapsed = events["t"] - events["t"][0]
        assert whole.events == len(t)
        if elapsed[-1] >= 10_000:
            assert whole.rate_peak_1ms_hz == np.bincount(elapsed // 1000).max() * 1e3
            assert whole.rate_peak_10ms_hz == np.bincount(elapsed // 10_000).max() * 1e2
        assert whole.duration_s == pytest.approx(elapsed[-1] / 1e6)
        assert whole.on_share == (len(t) // 2) / len(t)


@given(
    arrays(np.float64, st.integers(1, 400), elements=st.floats(-1e6, 1e6)),
    st.integers(4, 60),
    st.booleans(),
)
def test_decimation_keeps_ends_and_extremes_in_order(y, points, uneven):
    x = np.cumsum(np.arange(y.size) % 7 if uneven else np.ones(y.size))
    kept_x, kept_y = analysis.decimate(x, y, points)
    assert kept_x.size <= max(points, 4)
    assert np.all(np.diff(kept_x) >= 0)
    assert kept_y.min() == y.min() and kept_y.max() == y.max()
    assert (kept_x[0], kept_y[0]) == (x[0], y[0])
    assert (kept_x[-1], kept_y[-1]) == (x[-1], y[-1])
    assert set(zip(kept_x, kept_y, strict=True)) <= set(zip(x, y, strict=True))


def test_median_in_windows_skips_windows_without_a_package():
    rows = packages(
        start_us=[100, 200, 900, 3000, 3999], t_first=[100] * 5, margin_us=[1, 9, 5, 7, 8]
    )
    run = replace(fake_run(duration_s=0.0), packages=rows)
    time_s, median = analysis.median_in_windows(run, "margin_us", 1.0)
    assert time_s.tolist() == [0, 0.002, 0.003]
    assert median.tolist() == [5, 7, 8]


def run_with(size, processing_us):
    rows = packages(size=size, processing_us=processing_us)
    return replace(fake_run(duration_s=0.0), packages=rows)


@given(st.floats(0, 1e4), st.floats(0, 1e4))
def test_cost_line_is_found_again(alpha_us, beta_ns):
    size = np.array([1, 10, 500, 20_000])
    cost = analysis.fit_cost(run_with(size, alpha_us + beta_ns * size / 1e3))
    assert cost.alpha_us == pytest.approx(alpha_us, rel=1e-6, abs=1e-6 * beta_ns + 0.02)
    assert cost.beta_ns == pytest.approx(beta_ns, rel=1e-6, abs=1e-6 * alpha_us + 2e-3)


@pytest.mark.parametrize(
    ("size", "processing_us", "cost"),
    [
        ([100, 100, 100], [40, 50, 40], (0, 400)),  # one size: no line, all of it per event
        ([10, 20, 30], [50, 40, 30], (40, 0)),  # falling: all of it per package
        ([10, 20, 40], [10, 22, 48], (0, 1100)),  # the line begins below zero
        ([0, 0], [10, 10], (0, 0)),
        ([3, 5], [0, 0], (0, 0)),
    ],
)
def test_cost_is_never_negative(size, processing_us, cost):
    fitted = analysis.fit_cost(run_with(size, processing_us))
    assert (fitted.alpha_us, fitted.beta_ns) == pytest.approx(cost, rel=0.1)


def noisy(size, alpha_us, beta_ns, noise, rng):
    """Draw the processing times of packages as `LinearCost` does."""
    factor = rng.lognormal(-(noise**2) / 2, noise, len(size))
    return (alpha_us + beta_ns * size / 1e3) * factor


@given(
    st.integers(0, 2**32),
    st.integers(200, 20_000),
    st.floats(0, 1),
    st.floats(0, 0.3),
    st.floats(1, 1000),
    st.floats(0, 0.1),
)
def test_the_fit_explains_the_packages(seed, count, fixed, noise, ratio, interrupted):
    """Within 20 noise / sqrt(packages), and what interrupted packages move a median by.

    The line at the sizes that were seen; and where these vary by a factor of 4, alpha in costs of
    the smallest package, beta in costs per event of the largest.
    """
    rng = np.random.default_rng(seed)
    smallest = 10 ** rng.uniform(0, 3)
    size = np.ceil(smallest * ratio ** rng.random(count))
    alpha_us, beta_ns = 5000 * fixed, 5e6 * (1 - fixed) / size.mean()
    cost_us = noisy(size, alpha_us, beta_ns, noise, rng)
    cost_us[rng.random(count) < interrupted] *= rng.uniform(2, 30)
    found = analysis.fit_cost(run_with(size, cost_us))
    within = noise * (20 / min(count, 8192) ** 0.5 + 3 * interrupted) + 1e-6

    def line_us(alpha_us, beta_ns, size):
        return alpha_us + beta_ns * size / 1e3

    centre = np.exp(np.log(size).mean())
    seen = (size.min(), centre, size.max()) if ratio >= 4 else (centre,)
    for one in seen:
        expected_us = line_us(alpha_us, beta_ns, one)
        assert line_us(found.alpha_us, found.beta_ns, one) == pytest.approx(expected_us, rel=within)
    if ratio >= 4:
        least_us = line_us(alpha_us, beta_ns, size.min())
        largest_ns = line_us(alpha_us, beta_ns, size.max()) / size.max() * 1e3
        assert found.alpha_us == pytest.approx(alpha_us, abs=2 * within * least_us)
        assert found.beta_ns == pytest.approx(beta_ns, abs=2 * within * largest_ns)
        assert found.noise == pytest.approx(noise, rel=0.5, abs=1e-6)


def test_throughput_at_a_bound():
    cost = analysis.Cost(100, 200)
    assert cost.throughput_hz(10_000) == pytest.approx(0.98 * 5e6)
    assert cost.throughput_hz(200) == 0
    assert analysis.Cost(100, 0).throughput_hz(10_000) == np.inf
    assert analysis.Cost(0, 0).throughput_hz(0) == 0


def steady(rate, **parameters):
    return fake_run(rates=(rate, rate), duration_s=1.0, **{"rate_bound": None, **parameters})


def test_bad_events_are_not_the_algorithms_fault():
    assert analysis.diagnose(steady(1e6, rejected=10_000_000)).limit == "data"


def test_what_the_filter_in_front_takes_out_is_not_the_algorithms_fault():
    run = steady(1e6, filtered=1_000_000)
    assert run.in_time < 0.6
    assert analysis.diagnose(run).limit == "camera"
    said = diagnosis.verdict(run)
    assert "No event was lost" in said
    assert "filter" in said


def test_the_least_bound_is_two_and_a_half_fixed_costs_or_two_events():
    assert analysis.Cost(100, 300).least_bound_us == 250
    assert analysis.Cost(100, 1e6).least_bound_us == 2200
    assert analysis.Cost(100, 300, one_size=50).least_bound_us == pytest.approx(4.6)


@pytest.mark.parametrize(
    ("thinned", "execution", "expected"),
    [
        (True, "whole", (100, 150)),
        (False, "anytime", (100, 150)),
        (True, "anytime", (0, 200)),
    ],
)
def test_what_a_scheme_learned_counts_where_the_clock_ends_packages(thinned, execution, expected):
    """Elsewhere the packages tell it better, and what was learned may be far off."""
    rates = (12e6, 12e6) if thinned else (0.1e6, 5e6)
    run = fake_run(rates=rates, duration_s=1.0, learned=analysis.Cost(0, 1e6), execution=execution)
    assert (np.mean(run.packages["size"] < run.packages["offered"]) > 0.5) == thinned
    found = analysis.fit_cost(run)
    assert (found.alpha_us, found.beta_ns) == pytest.approx(expected, rel=0.02)


def test_windows_say_where_the_events_of_their_time_went():
    rows = packages(
        t_first=[0, 10_000, 90_000],
        t_last=[4_999, 19_999, 99_999],
        offered=[100, 200, 50],
        size=[100, 90, 50],
        gamma=[1, 0.5, 1],
        stale=[0, 0, 700],
        overflow=[0, 10, 0],
    )
    run = steady(1e6)
    ledger = replace(run.ledger, stale=730, overflow=10)
    run = replace(run, packages=rows, ledger=ledger, source=run.source | {"duration_s": 0.13})
    found = diagnosis.windows(run, 10_000)
    assert found.edges_s == pytest.approx(np.arange(14) / 100)
    assert found.delivered.tolist() == [100, 90, 0, 0, 0, 0, 0, 0, 0, 50, 0, 0, 0]
    assert found.filtered.tolist() == [0, 20, *[0] * 11]
    assert found.discarded.tolist() == [0, 90, *[0] * 11]
    assert found.overflow.tolist() == [10, *[0] * 12]  # between the packages
    assert found.stale.tolist() == [0, 0, *[100] * 7, 0, 10, 10, 10]  # and after the last
    total = found.delivered + found.filtered + found.discarded + found.overflow + found.stale
    assert found.received.tolist() == total.tolist()
    assert found.rate_hz(found.received, 2.0)[1] == pytest.approx(200 / 0.01 * 2)


@given(st.integers(0, 2**32), st.sampled_from([5_000, 20_000, 2_000_000]))
@settings(max_examples=20)
def test_rates_of_windows_are_counts_at_any_load(seed, rate_hz):
    """A package of one event has a rate of 1 Mev/s by itself; a window has the true one."""
    t = np.sort(np.random.default_rng(seed).integers(0, 10**6, rate_hz))
    run = asap.simulate(events_at(t), cost=asap.LinearCost(50, 200), latency_ms=10)
    found = diagnosis.windows(run)
    counts, _ = np.histogram((t - t[0]) / 1e6, found.edges_s)
    assert np.abs(found.received - counts).sum() < 0.05 * rate_hz
    assert np.median(found.rate_hz(found.received)) == pytest.approx(rate_hz, rel=0.2)


def test_a_faster_replay_offers_more_events_per_second():
    once, twice = steady(1e6), steady(1e6, speed=2.0)
    offered_hz = analysis.diagnose(once).offered_hz
    assert offered_hz == pytest.approx(1e6, rel=0.05)
    assert analysis.diagnose(twice).offered_hz == pytest.approx(2 * offered_hz, rel=1e-6)
