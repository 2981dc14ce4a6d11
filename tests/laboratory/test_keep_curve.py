"""keep_curve: one score after the other, their mean and spread, table and figure."""

import math

import numpy as np
import pytest

import asap
from asap_laboratory import keep_curve
from asap_laboratory.scoring import curve as module
from fake_scene import FakeScene, perfect

SCENE = FakeScene([(50, 50, 0, 0), (150, 100, 0, 0)], end_us=120_001)


@pytest.fixture
def calls(monkeypatch):
    """Every call of score as (gamma, told, seed, has a filter); the score is made up."""
    seen = []

    def score(tracker, scene, *, before, gamma, told, seed):
        seen.append((gamma, told, seed, before is not None))
        return {"mota": gamma - seed, "idf1": math.nan}

    monkeypatch.setattr(module, "score", score)
    return seen


def made(width, height):
    assert (width, height) == (346, 260)
    return perfect(SCENE)


class Silent:
    """A detector that cannot be told."""

    def __init__(self, width, height):
        pass

    def process(self, events):
        return np.zeros(events.size, bool)


def test_every_gamma_is_scored_with_every_seed_told_and_not(calls):
    curve = keep_curve(made, lambda seed: SCENE, gammas=(1, 0.5, 0.1), seeds=(3, 4))
    assert calls == [
        (gamma, told, seed, False)
        for seed in (3, 4)
        for gamma, told in ((1, False), (0.5, True), (0.5, False), (0.1, True), (0.1, False))
    ]
    rows = [(row["gamma"], row["told"], row["seeds"]) for row in curve.rows]
    assert rows == [(1, None, 2), (0.5, True, 2), (0.5, False, 2), (0.1, True, 2), (0.1, False, 2)]
    assert [row["mota"] for row in curve.rows] == pytest.approx([-2.5, -3, -3, -3.4, -3.4])
    assert [row["mota_sd"] for row in curve.rows] == pytest.approx([0.5**0.5] * 5)


def test_what_cannot_be_told_is_not(calls):
    keep_curve(Silent, SCENE, gammas=(1, 0.5), seeds=(0,))
    assert [call[:2] for call in calls] == [(1, False), (0.5, False)]


def test_every_run_gets_a_fresh_algorithm_and_filter_and_every_seed_its_scene():
    seeds, trackers, filters = [], [], []

    def scene(seed):
        seeds.append(seed)
        return SCENE

    def tracker(width, height):
        trackers.append(perfect(SCENE))
        return trackers[-1]

    def before(width, height):
        filters.append(asap.BackgroundActivityFilter(width, height))
        return filters[-1]

    keep_curve(tracker, scene, gammas=(1, 0.5), seeds=(5, 6), before=before)
    assert seeds == [5, 6]
    used = [one for one in trackers if one.packages]
    assert len(used) == 6 and all(len(one.packages) == 6 for one in used)
    assert len(filters) >= 6
    assert [one.gammas for one in used] == [[], [0.5], []] * 2
