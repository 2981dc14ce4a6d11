from __future__ import annotations

import itertools

import numpy as np
import pytest

from asap import EVENT_DTYPE
from asap_laboratory import profiles
from asap_laboratory.profiles import COSTS, PROFILES, Profile
from test_synthetic import fingerprint, same

STEP_US = 100


def rates_of(profile: Profile) -> np.ndarray:
    return np.concatenate(list(profile.rates()))


def counts_of(events: np.ndarray, steps: int) -> np.ndarray:
    return np.bincount(events["t"] // STEP_US, minlength=steps)


# ---- the named rates ------------------------------------------------------------------------


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


def test_your_own_profile_is_one_line() -> None:
    profile = Profile(lambda t: 1e6 + 9e6 * (t % 0.1 < 0.01), duration_s=1.0, noise=0.0)
    counts = counts_of(profile.events(), 10_000).reshape(10, 10, 100).sum(axis=(0, 2))
    assert counts == pytest.approx([1e6] + 9 * [1e5], rel=0.02)
    assert profile.name == "profile"


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


# ---- cost models ----------------------------------------------------------------------------


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


# ---- scenarios ------------------------------------------------------------------------------
