from __future__ import annotations

import inspect
import itertools
import tracemalloc
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import asap
from asap import EVENT_DTYPE
from asap_laboratory import _native, profiles
from asap_laboratory.profiles import COSTS, FURTHER, PROFILES, Profile
from test_synthetic import fingerprint, same

STEP_US = 100

# The comparison's table: mean and greatest rate over 5 s, Mev/s.
MEAN_AND_MOST = {
    "quiet": (0.002, 0.002),
    "low": (0.1, 0.1),
    "uav": (1.55, 2.8),
    "flicker": (3.025, 6.0),
    "steps": (3.15, 6.0),
    "bursts": (3.45, 30.0),
    "high": (10.0, 10.0),
    "ramp": (10.0, 20.0),
    "steps60": (31.5, 60.0),
}


def rates_of(profile: Profile) -> np.ndarray:
    return np.concatenate(list(profile.rates()))


def counts_of(events: np.ndarray, steps: int) -> np.ndarray:
    return np.bincount(events["t"] // STEP_US, minlength=steps)


# ---- the named rates ------------------------------------------------------------------------


def test_there_are_nine_profiles_and_eight_further_ones() -> None:
    assert tuple(PROFILES) == (*MEAN_AND_MOST, *FURTHER)
    assert len(FURTHER) == 8


@pytest.mark.parametrize("name", MEAN_AND_MOST)
def test_rates_are_those_of_the_table(name: str) -> None:
    rates = rates_of(Profile(name)) / 1e6
    mean, most = MEAN_AND_MOST[name]
    assert len(rates) == 50_000
    assert rates.mean() == pytest.approx(mean, rel=1e-4)
    assert rates.max() == pytest.approx(most, rel=1e-4)


@pytest.mark.parametrize(
    ("name", "t", "rate"),
    [
        ("flicker", [0.0, 0.00499, 0.00501, 0.00999, 0.01001], [6, 6, 0.05, 0.05, 6]),
        ("steps", [0.0, 0.4999, 0.5001, 0.9999, 1.0001], [0.3, 0.3, 6, 6, 0.3]),
        ("steps60", [0.4999, 0.5001], [3, 60]),
        ("bursts", [0.0, 0.0099, 0.0101, 0.0999, 0.1001], [30, 30, 0.5, 0.5, 30]),
        ("uav", [0.0, 2.5, 4.999999], [0.3, 1.55, 2.8]),
        ("ramp", [0.0, 2.5, 4.999999], [0.0, 10.0, 20.0]),
        ("sawtooth", [0.0, 0.5 / 3.7, 0.999999 / 3.7, 1.000001 / 3.7], [0.2, 4.7, 9.2, 0.2]),
        ("spikes", [0.0029, 0.0031, 0.0529, 0.0531], [40, 0.8, 0.8, 40]),
        ("breath", [0.0, 0.25 / 1.3, 0.5 / 1.3, 0.75 / 1.3], [4, 8, 4, 0]),
        (
            "twostep",
            [0.0, 0.39, 0.41, 0.79, 0.81, 1.19, 1.21, 1.59],
            [0.05, 0.05, 8, 8, 0.5, 0.5, 25, 25],
        ),
        (
            "train",
            [0.001, 0.0012, 0.0044, 0.1170, 0.1212, 0.3099, 0.3101],
            [16, 0.6, 16, 16, 0.6, 0.6, 16],
        ),
    ],
)
def test_rate_at(name: str, t: list[float], rate: list[float]) -> None:
    assert PROFILES[name](np.array(t)) / 1e6 == pytest.approx(rate, abs=1e-4)


def log_levels(name: str, piece_s: float, *, duration_s: float = 60.0) -> np.ndarray:
    """Logarithm of the rate in the middle of each piece, Mev/s."""
    rate = PROFILES[name].seeded(3)
    return np.log(rate((np.arange(int(duration_s / piece_s)) + 0.5) * piece_s) / 1e6)


def test_walk_steps_in_its_logarithm_and_starts_anew_every_2_s() -> None:
    walks = log_levels("walk", 0.005).reshape(-1, 400)
    low, high = np.log(0.01), np.log(30.0)
    assert walks.min() == pytest.approx(low) and walks.max() == pytest.approx(high)
    steps = np.diff(walks, axis=1)
    free = (walks[:, 1:] > low) & (walks[:, 1:] < high) & (walks[:, :-1] > low)
    free &= walks[:, :-1] < high
    assert steps[free].std() == pytest.approx(0.35, rel=0.05)
    assert walks[:, 0] == pytest.approx(np.log(3.0), abs=4 * 0.35)
    assert np.median(walks[:, :50]) == pytest.approx(np.log(3.0), abs=1.0)


def test_ou4ms_has_its_spread_and_forgets_in_4_ms() -> None:
    y = (log_levels("ou4ms", 0.001) - np.log(3.0)) / 0.8
    assert y.mean() == pytest.approx(0.0, abs=0.05)
    assert y.std() == pytest.approx(1.0, rel=0.03)
    correlation = [np.mean(y[lag:] * y[:-lag]) / y.var() for lag in (1, 4)]
    assert correlation == pytest.approx([np.exp(-0.25), np.exp(-1.0)], abs=0.03)


def test_telegraph_dwells_12_ms_at_levels_around_9_and_1() -> None:
    rates = rates_of(Profile("telegraph", duration_s=120.0)) / 1e6
    switch = np.flatnonzero(np.diff(rates)) + 1
    dwells_ms = np.diff(switch) * 0.1
    assert dwells_ms.mean() == pytest.approx(12.0, rel=0.05)
    assert dwells_ms.std() == pytest.approx(12.0, rel=0.05)
    rate = PROFILES["telegraph"]._pieces(profiles.rates.Draws(5))
    levels = np.log(np.concatenate([next(rate)[1] for _ in range(50)]).reshape(-1, 2) / 1e6)
    assert levels.mean(axis=0) == pytest.approx(np.log([9.0, 1.0]), abs=0.05)
    assert levels.std(axis=0) == pytest.approx([0.7, 0.6], abs=0.03)


@pytest.mark.parametrize("name", ["walk", "telegraph", "ou4ms"])
def test_random_rates_are_functions_of_time_and_seed(name: str) -> None:
    rate = PROFILES[name].seeded(7)
    t = np.arange(0.0, 3.0, 0.0007)
    whole = rate(t)
    assert np.unique(whole).size > 50 and whole.min() >= 1e4
    assert np.array_equal(rate(t), whole)  # back to the start
    again = PROFILES[name].seeded(7)
    assert np.array_equal(
        np.concatenate([again(part) for part in np.split(t, [10, 11, 2000])]), whole
    )
    assert np.array_equal(again(t[1000:]), whole[1000:])
    assert not np.array_equal(PROFILES[name].seeded(8)(t), whole)
    seeded = [rates_of(Profile(name, duration_s=0.5, seed=seed)) for seed in (1, 1, 2)]
    assert np.array_equal(seeded[0], seeded[1])
    assert not np.array_equal(seeded[0], seeded[2])


def test_random_rates_forget_what_is_past() -> None:
    rate = PROFILES["walk"].seeded(1)
    rate(np.array([0.5]))
    tracemalloc.start()
    for second in range(1000):
        rate(np.array([second + 0.5]))
    assert tracemalloc.get_traced_memory()[0] < 100e3  # 200 000 pieces have passed
    tracemalloc.stop()


def test_fifteen_times_a_random_rate_is_still_a_rate() -> None:
    telegraph = PROFILES["telegraph"]._pieces(profiles.rates.Draws(5))
    assert max(next(telegraph)[1].max() for _ in range(400)) == 100e6
    assert log_levels("ou4ms", 0.001, duration_s=600.0).max() == pytest.approx(np.log(100.0))


@pytest.mark.parametrize("name", ["breath", "ramp", "ou4ms"])
def test_rates_are_rounded_to_what_every_machine_agrees_on(name: str) -> None:
    rates = rates_of(Profile(name, duration_s=1.0, scale=1.1))
    assert np.array_equal(rates, rates.astype(np.float32))


# ---- events of a profile --------------------------------------------------------------------


@pytest.mark.parametrize("name", PROFILES)
def test_events_follow_the_rates(name: str) -> None:
    profile = Profile(name, duration_s=0.7, noise=0.0, seed=4)
    expected = rates_of(profile) * 1e-4
    counts = np.zeros(len(expected))
    for events in profile:
        counts += counts_of(events, len(expected))
    assert abs(counts.sum() - expected.sum()) < 5 * np.sqrt(expected.sum())
    squares = (counts - expected) ** 2
    spread = np.sqrt((expected + 2 * expected**2).sum())
    assert abs((squares - expected).sum()) < 5 * spread


def test_noise_scatters_the_rate_by_its_sigma() -> None:
    expected = 200.0
    counts = counts_of(Profile("high", duration_s=2.0, scale=0.2).events(), 20_000)
    assert counts.mean() == pytest.approx(expected, rel=0.03)
    assert np.sqrt(counts.var() - expected) / expected == pytest.approx(0.2, rel=0.1)


def test_your_own_profile_is_one_line() -> None:
    profile = Profile(lambda t: 1e6 + 9e6 * (t % 0.1 < 0.01), duration_s=1.0, noise=0.0)
    counts = counts_of(profile.events(), 10_000).reshape(10, 10, 100).sum(axis=(0, 2))
    assert counts == pytest.approx([1e6] + 9 * [1e5], rel=0.02)
    assert profile.name == "profile"


def test_a_rate_may_be_one_number() -> None:
    assert Profile(lambda t: 3e6, duration_s=0.5, noise=0.0).events().size == pytest.approx(
        1.5e6, rel=0.005
    )
    assert Profile(lambda t: 0, duration_s=0.5).events().size == 0


def test_a_rate_is_asked_for_the_middles_of_its_steps() -> None:
    asked: list[np.ndarray] = []

    def rate(t: np.ndarray) -> float:
        asked.append(t)
        return 1e3

    assert Profile(rate, duration_s=2.00005).events().size > 0
    t = np.concatenate(asked[-3:])
    assert [len(part) for part in asked[-3:]] == [10_000, 10_000, 1]
    assert t == pytest.approx((np.arange(20_001) + 0.5) * 1e-4, abs=1e-12)


def test_scale_multiplies() -> None:
    plain, scaled = Profile("walk", duration_s=0.2), Profile("walk", duration_s=0.2, scale=15.0)
    assert rates_of(scaled) == pytest.approx(15.0 * rates_of(plain), rel=1e-6)


def test_streaming_yields_what_events_returns() -> None:
    profile = Profile("bursts", duration_s=1.3, seed=3)
    arrays = list(profile)
    assert all(2**16 <= len(events) < 2**16 + 4096 for events in arrays[:-1])
    for earlier, later in itertools.pairwise(arrays):
        assert earlier["t"][-1] <= later["t"][0]
    events = profile.events()
    assert events.dtype == EVENT_DTYPE and events.flags.writeable
    assert same(events, np.concatenate(arrays))
    assert same(events, Profile("bursts", duration_s=1.3, seed=3).events())
    assert not np.array_equal(
        events["t"][:1000], Profile("bursts", duration_s=1.3, seed=4).events()["t"][:1000]
    )


def test_a_longer_profile_begins_like_a_shorter_one() -> None:
    for name in ("walk", "uav"):
        short, long = (
            Profile(name, duration_s=duration_s, seed=2, scale=0.05).events()
            for duration_s in (1.05, 1.5)
        )
        assert same(long[: len(short)], short)
        assert long[len(short)]["t"] >= 1_050_000


def test_a_quiet_profile_yields_full_arrays() -> None:
    arrays = list(Profile("quiet", duration_s=50.0))
    assert len(arrays) == 2
    assert len(arrays[0]) >= 2**16
    assert arrays[1]["t"][-1] > 49_900_000


@pytest.mark.parametrize(
    ("name", "golden"),
    [
        ("ramp", 15510953297892930856),
        ("walk", 7300987839487799788),
        ("telegraph", 7380091170264868719),
        ("ou4ms", 10553709080845198573),
        ("breath", 1143171745985130212),
    ],
)
def test_events_are_golden(name: str, golden: int) -> None:
    """A change of the stream changes published figures: say so in the changelog."""
    assert fingerprint(Profile(name, duration_s=0.1).events()) == golden


def test_memory_stays_flat() -> None:
    peaks = []
    for duration_s in (2.0, 20.0):
        profile = Profile("walk", duration_s=duration_s)
        tracemalloc.start()
        events = sum(len(events) for events in profile)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
        assert events > 0.1e6 * duration_s
    assert peaks[1] < 1.2 * peaks[0]
    assert peaks[1] < 4e6


def test_says_what_it_is() -> None:
    profile = Profile("high", duration_s=0.5, width=640, height=480, seed=9)
    assert (profile.width, profile.height, profile.duration_s) == (640, 480, 0.5)
    assert profile.name == "high"
    assert list(profile.parameters) == list(inspect.signature(Profile).parameters)
    assert Profile(**profile.parameters).parameters == profile.parameters
    assert eval(repr(profile)).parameters == profile.parameters
    assert Profile("high", name="mine").name == "mine"

    def storm(t: np.ndarray) -> np.ndarray:
        return 1e6 * t

    assert Profile(storm).name == "storm"
    events = profile.events()
    assert events["x"].max() == 639 and events["y"].max() == 479


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 2**64 - 1),
    width=st.integers(16, 400),
    height=st.integers(16, 400),
    duration_s=st.floats(0.01, 0.05),
    rate=st.floats(0.0, 2e7),
    noise=st.floats(0.0, 1.0),
)
def test_events_are_ordered_and_inside(
    seed: int, width: int, height: int, duration_s: float, rate: float, noise: float
) -> None:
    events = Profile(
        lambda t: rate, seed=seed, width=width, height=height, duration_s=duration_s, noise=noise
    ).events()
    assert np.all(np.diff(events["t"]) >= 0)
    assert np.all((events["x"] < width) & (events["y"] < height))
    assert np.all((events["p"] == 0) | (events["p"] == 1))
    assert np.all((events["t"] >= 0) & (events["t"] < round(duration_s * 1e6)))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"rate": "loud"}, "rate = 'loud': give .* one of quiet, low"),
        ({"rate": 3e6}, "rate = 3000000.0: give a function"),
        ({"rate": lambda t: -1.0}, "rate = -1 at t = 5e-05 s: give"),
        ({"rate": lambda t: np.where(t > 0.5, np.nan, 1.0)}, "rate = nan at t = 0.50005 s: give"),
        ({"rate": lambda t: np.where(t > 0.5, np.inf, 1.0)}, "rate = inf at t = 0.50005 s: give"),
        ({"rate": lambda t: 2.1e9}, "rate = 2.1e[+]09 at t = 5e-05 s: give"),
        ({"rate": "high", "scale": 300.0}, "rate = 3e[+]09 at t = 5e-05 s: give"),
        ({"rate": lambda t: t[:5]}, r"rate: of shape \(5,\) at times of shape \(10000,\)"),
        ({"rate": "high", "scale": -1.0}, "scale = -1.0: give"),
        ({"rate": "high", "scale": float("nan")}, "scale = nan: give"),
        ({"rate": "high", "noise": 1.5}, "noise = 1.5.*: give"),
        ({"rate": "high", "width": 0}, "width = 0: give"),
        ({"rate": "high", "seed": -1}, "seed = -1: give"),
        ({"rate": "high", "duration_s": 0.0}, "duration_s = 0.0: give"),
    ],
)
def test_bad_parameters_are_named(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=f"^{message}"):
        Profile(**arguments)


def test_a_bad_rate_later_on_raises_when_it_is_reached() -> None:
    profile = Profile(lambda t: np.where(t < 1.5, 1e3, -1.0), duration_s=3.0)
    with pytest.raises(ValueError, match=r"^rate = -1 at t = 1.50005 s"):
        profile.events()


def test_the_error_of_a_rate_comes_out_unchanged() -> None:
    with pytest.raises(ZeroDivisionError):
        Profile(lambda t: 1 // 0)


@pytest.mark.parametrize("rates", [np.ones(5, np.float32), np.ones((2, 5)), np.ones(10)[::2]])
def test_the_core_takes_plain_arrays_of_rates_only(rates: np.ndarray) -> None:
    arrivals = _native.PoissonArrivals(
        width=16, height=16, duration_us=10_000, t0_us=0, noise=0.0, seed=0
    )
    with pytest.raises(TypeError, match=r"^rates_hz: give"):
        arrivals.feed(rates)


# ---- cost models ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("fast", (20.0, 20.0, 0.05, 2.0)),
        ("slow", (100.0, 300.0, 0.05, 10.0)),
        ("slow_tv", (100.0, 300.0, 0.10, 10.0)),
        ("slow_ht", (100.0, 300.0, 0.50, 10.0)),
    ],
)
def test_cost_models_are_those_of_the_table(name: str, expected: tuple[float, ...]) -> None:
    parameters = profiles.cost(name, seed=2).parameters
    found = (parameters["alpha_us"], parameters["beta_ns"], parameters["noise"])
    assert (*found, profiles.LATENCY_MS[name]) == expected
    assert parameters["seed"] == 102


def test_costs_drift_and_fail_where_the_table_says_so() -> None:
    drifts, outages = {}, {}
    for name in COSTS:
        parameters = profiles.cost(name, seed=2, duration_s=3.0).parameters
        drifts[name] = parameters.get("drift")
        outages[name] = parameters.get("outages_ms")
    assert np.array_equal(drifts.pop("slow_tv"), profiles.drift(3.0))
    expected = profiles.outages_ms(3.0, seed=102)
    assert np.array(outages.pop("slow_ht")) == pytest.approx(expected, abs=1e-6)  # whole ns
    assert not any(drifts.values()) and not any(outages.values())


def test_drift() -> None:
    factors = profiles.drift(5.0)
    assert factors.shape == (5000,)
    assert factors[[0, 250, 500, 750]] == pytest.approx([1.0, 1.5, 1.0, 0.5], abs=1e-6)
    assert factors[[2750, 2751, 3250]] == pytest.approx([0.5, 0.75, 2.25], abs=1e-4)
    assert factors[:2000].mean() == pytest.approx(1.0, abs=1e-6)
    assert factors[3000:].mean() == pytest.approx(1.5, abs=1e-6)


def test_outages() -> None:
    seeds = range(200)
    per_seed = [profiles.outages_ms(5.0, seed=seed) for seed in seeds]
    counts = np.array([len(outages) for outages in per_seed])
    assert counts.mean() == pytest.approx(50.0, abs=4 * np.sqrt(50 / len(seeds)))
    assert counts.var() == pytest.approx(50.0, rel=0.4)
    for outages in per_seed:
        assert np.all(np.diff(outages.ravel()) >= 0)
        assert outages[0, 0] >= 0.0
    durations = np.concatenate([np.diff(outages, axis=1)[:, 0] for outages in per_seed])
    assert 1.0 - 1e-6 < durations.min() < 1.01
    assert durations.max() == pytest.approx(30.0)
    # Pareto of shape 1.5, cut: median 2^(2/3), P(> 30) = 30^-1.5, mean 3 - 2/sqrt(30).
    assert np.median(durations) == pytest.approx(2 ** (2 / 3), rel=0.03)
    assert durations.mean() == pytest.approx(3 - 2 / np.sqrt(30), rel=0.05)
    begins = np.concatenate([outages[:, 0] for outages in per_seed])
    assert np.histogram(begins, 5, (0, 5000))[0] / len(seeds) == pytest.approx(10.0, rel=0.1)
    assert np.array_equal(per_seed[3], profiles.outages_ms(5.0, seed=3))
    assert profiles.outages_ms(1e-3, seed=0).shape == (0, 2)


def test_an_unknown_cost_model_is_named() -> None:
    with pytest.raises(ValueError, match=r"^name = 'cheap': give one of fast, slow, slow_tv"):
        profiles.cost("cheap")


# ---- scenarios ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("profile", "cost_model", "duration_s", "scale", "latency_ms"),
    [
        ("bursts", "fast", 5.0, 1.0, 2.0),
        ("bursts", "slow_ht", 5.0, 1.0, 10.0),
        ("walk", "fast", 2.0, 15.0, 2.0),
        ("walk", "slow_tv", 2.0, 1.0, 10.0),
    ],
)
def test_scenario(
    profile: str, cost_model: str, duration_s: float, scale: float, latency_ms: float
) -> None:
    scenario = profiles.scenario(profile, cost_model, seed=3)
    parameters = scenario.source.parameters
    assert (parameters["rate"], parameters["duration_s"]) == (profile, duration_s)
    assert (parameters["scale"], parameters["seed"]) == (scale, 3)
    assert (
        scenario.cost.parameters
        == profiles.cost(cost_model, seed=3, duration_s=duration_s).parameters
    )
    assert scenario.latency_ms == latency_ms


def test_a_scenario_runs() -> None:
    source, cost, latency_ms = profiles.scenario("steps", "slow", duration_s=0.6, noise=0.0)
    run = asap.simulate(source, cost=cost, latency_ms=latency_ms, scheme=asap.Greedy())
    assert run.ledger.balanced
    assert run.ledger.received == source.events().size


@pytest.mark.benchmark(group="synthetic")
def test_bench_profile(benchmark: Any) -> None:
    def read() -> int:
        return sum(len(events) for events in Profile("high", duration_s=1.0))

    benchmark.extra_info["events"] = benchmark(read)


@pytest.mark.parametrize("duration_s", [float("nan"), float("inf"), -1.0, 1e12])
def test_duration_of_a_cost_without_end_is_refused(duration_s):
    for call in (profiles.drift, lambda seconds: profiles.outages_ms(seconds, seed=1)):
        with pytest.raises(ValueError, match=r"^duration_s = "):
            call(duration_s)


def test_a_profile_is_a_source_of_a_comparison():
    profile = profiles.Profile("high", duration_s=0.05)
    found = asap.compare(profile, cost=asap.LinearCost(100, 300), schemes=[asap.Greedy()])
    assert found.name == "high"
    assert found.received == profile.events().size
    assert str(found).startswith("high: one scheme beside the oracle\n346 x 260 px, ")
