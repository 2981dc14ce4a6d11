"""The ladder: costs, settings, what is left of the accuracy, and the study as a whole."""

import dataclasses
import math

import numpy as np
import pytest

import asap
import streams
from asap import _core
from asap_laboratory import STUDIES, conduct, ladder, scenes, score
from asap_laboratory.ladder.accuracy import (
    Delivery,
    Recorder,
    corner_accuracy,
    samples_without_clusters,
    tracker_accuracy,
)
from asap_laboratory.ladder.cases import LadderCase
from asap_laboratory.ladder.cost import fit
from asap_laboratory.ladder.rungs import RUNGS, LadderRung
from asap_laboratory.ladder.settings import (
    BASELINES,
    OURS,
    Setting,
    best,
    best_for_all,
    ours,
    tried,
)
from asap_laboratory.page import only
from asap_laboratory.scoring.trace import follow
from asap_laboratory.study import key_of
from fake_scene import FakeScene, perfect

SCENE = FakeScene([(50, 50, 0, 0), (150, 100, 400, 0)], end_us=130_001)
LABELS = (OURS, *BASELINES, *(f"{name}, one for all" for name in BASELINES))


def whole(scene, done_after_us=0.0):
    """Every event a package of its own millisecond, done so much later than its last event."""
    return [
        one._replace(done_us=one.done_us + done_after_us)
        for one in ladder.accuracy.everything(scene)
    ]


# ---- costs ----------------------------------------------------------------------------------


def test_fit_finds_alpha_and_beta_of_very_different_packages():
    sizes = (1, 10, 100, 1000, 10_000)
    alpha_us, beta_ns = fit(sizes, [2.5 + 0.04 * n for n in sizes])
    assert alpha_us == pytest.approx(2.5) and beta_ns == pytest.approx(40)


def test_fit_is_never_below_zero():
    alpha_us, beta_ns = fit((1, 10, 100), [0.5, 9, 100])
    assert alpha_us == 0 and beta_ns == pytest.approx(659.4, rel=1e-3)
    assert fit((1, 10, 100), [5.0, 5.0, 4.0])[1] == 0


# ---- settings -------------------------------------------------------------------------------


def one(in_time, p99_ms, scheme="FixedSize", size=10, for_all=True):
    setting = Setting(scheme, {"size": size}, 64, for_all)
    return {**dataclasses.asdict(setting), "in_time": in_time, "p99_ms": p99_ms}


def test_best_keeps_the_bound_before_it_keeps_events():
    found = [one(0.2, 2.0, size=1), one(0.3, 3.0, size=2), one(0.9, 3.1, size=3)]
    assert best(found, "FixedSize").parameters == {"size": 2}
    assert best([*found[2:], one(0.95, 50.0, size=4)], "FixedSize").parameters == {"size": 3}


def test_best_for_all_is_judged_by_share_of_the_best_and_by_the_bound():
    cheap = [one(1.0, 1.0, size=1), one(0.9, 1.0, size=2), one(1.0, 1.0, size=3, for_all=False)]
    dear = [one(0.5, 9.0, size=1), one(0.01, 1.0, size=2), one(0.02, 1.0, size=3, for_all=False)]
    assert best_for_all([cheap, dear], "FixedSize").parameters == {"size": 2}


def test_a_setting_of_a_faster_stream_is_alike():
    setting = Setting("FixedTime", {"period_ms": 0.5}, 100).scaled(rate=8, time=2)
    assert setting.parameters == {"period_ms": 1.0} and setting.capacity == 1600
    assert Setting("FixedSize", {"size": 10}).scaled(rate=8, time=2).parameters == {"size": 160}
    assert Setting("Asap2020", {"rate_bound": 1e5}).scaled(rate=8, time=2).make().parameters[
        "rate_bound"
    ] == pytest.approx(8e5)
    assert ours().scaled(rate=8, time=2).make().parameters["latency_ms"] == 6


def test_tuned_baselines_keep_the_bound_where_the_ring_of_all_does_not():
    events = streams.make(np.arange(20_000), 1, 1, 1)  # 1 Mev/s, of which a tenth can be done
    found = tried(events, 1.0, 10_000.0)
    for name in BASELINES:
        chosen = dataclasses.asdict(best(found, name))
        (merit,) = only(found, **chosen)
        assert merit["p99_ms"] <= 3.0 and merit["in_time"] > 0.05
    whole = only(found, scheme="FixedSize", capacity=1 << 20)
    assert whole and all(one["p99_ms"] > 30 and one["in_time"] < 0.05 for one in whole)


def test_samples_are_those_of_score():
    trace = follow(perfect(SCENE), SCENE)
    for mine, its in zip(samples_without_clusters(SCENE), trace.samples, strict=True):
        assert mine.t_us == its.t_us
        np.testing.assert_array_equal(mine.active, its.active)
        np.testing.assert_array_equal(mine.centres, its.centres)


# ---- accuracy -------------------------------------------------------------------------------


def test_delivered_at_once_is_the_score_and_both_are_one():
    scene = scenes.timing(5, 200, 150, 150.0, seed=3, duration_s=0.15)

    def make():
        return _core.PublishedClusterTracker(200, 150, window=2000, probes=0, weight=0.05)

    used = tracker_accuracy(make, scene, whole(scene))
    assert used.delivered == used.in_use == score(make(), scene)["mota"] > 0.1


class Last:
    """Two clusters: at the last event of each object."""

    def __init__(self):
        self.rows = {}
        self.gammas = []

    def set_gamma(self, gamma):
        self.gammas.append(gamma)

    def process(self, events):
        for event in events:
            self.rows[int(event["y"])] = (int(event["y"]), event["x"], event["y"])

    @property
    def clusters(self):
        return np.array(list(self.rows.values()), [("id", int), ("x", float), ("y", float)])


def test_latency_costs_accuracy_in_use_only():
    """The second object moves 0.4 px a millisecond: 12 px, the gate of a match, in 30 ms."""
    assert tracker_accuracy(Last, SCENE, whole(SCENE, 20e3)) == (1.0, 1.0)
    late = tracker_accuracy(Last, SCENE, whole(SCENE, 40e3))
    assert late.delivered == 1
    assert late.in_use == pytest.approx(0.0)  # half is missed, and found where nothing is


def test_an_event_at_a_sample_time_is_not_in_that_sample():
    events = streams.make([100, 200])
    before, at = ladder.accuracy._split_at([Delivery(events, 1.0, 900.0)], [200])
    assert before.events["t"].tolist() == [100] and at.events["t"].tolist() == [200]
    assert before.done_us <= 200 < at.done_us


class Corners(FakeScene):
    """Of the first object every event is a corner, of the second none."""

    def vertices(self, t_us):
        return np.array([(0, 50.0, 50.0)], [("id", int), ("x", float), ("y", float)])


class Detector:
    """Right about everything."""

    def process(self, events):
        return events["y"] == 50


def test_corners_that_are_late_or_discarded_are_not_found_in_use():
    scene = Corners(SCENE.objects, end_us=130_001)
    packages = whole(scene)
    assert corner_accuracy(Detector(), scene, packages, 3e3) == (1, 1)
    assert corner_accuracy(Detector(), scene, whole(scene, 4e3), 3e3) == (1, 0)
    half = corner_accuracy(Detector(), scene, packages[: len(packages) // 2], 3e3)
    assert half.delivered == 1 and half.in_use == pytest.approx(2 / 3, abs=0.02)
    nothing = corner_accuracy(Detector(), scene, [], 3e3)
    assert math.isnan(nothing.delivered) and nothing.in_use == 0


def test_recorder_has_the_packages_of_the_run_with_their_times():
    recorder = Recorder()
    run = asap.simulate(
        SCENE.events, cost=asap.LinearCost(100, 1e6), latency_ms=10, algorithm=recorder
    )
    packages = recorder.deliveries(run)
    assert sum(one.events.size for one in packages) == run.ledger.delivered
    latencies_us = np.concatenate([one.done_us - one.events["t"] for one in packages])
    assert latencies_us.max() == pytest.approx(run.latency.max, rel=0.01)
    assert min(one.gamma for one in packages) < 1


# ---- the whole ------------------------------------------------------------------------------


def test_quick_form_is_measured_and_written(tmp_path, monkeypatch):
    monkeypatch.setattr(ladder, "_QUICK", ("BAF", "EFast", "published, 2 us"))
    found = conduct(STUDIES["ladder"], tmp_path, form="quick", workers=1)
    rows = found.tables["ladder"]
    for clock in ("virtual", "real"):
        for rung in ("BAF", "EFast", "published, 2 us"):
            some = only(rows, clock=clock, rung=rung)
            assert tuple(row["scheme"] for row in some) == LABELS
    virtual = {row["rung"]: row for row in only(rows, clock="virtual", scheme=OURS)}
    baf, efast, published = virtual.values()
    assert baf["load"] < 1 < efast["load"] < published["load"]
    assert published["alpha_us"] is None and baf["alpha_us"] > 0
    for row in virtual.values():
        assert row["in_time"] == pytest.approx(row["possible"], rel=0.15) and row["overflow"] == 0
    assert baf["delivered"] is None  # no score
    assert 0 < efast["in_use"] < efast["alone"] < 1 and published["in_use"] < published["alone"]
    text = found.paths[0].read_text()
    for words in (
        "`asap-study --ladder --quick`",
        "; 1 seed.",
        "| published, 2 us | MOTA | ",
        ": size ",
    ):
        assert words in text
    assert "In use over L" not in text  # of consumers that are not there
    again = conduct(STUDIES["ladder"], tmp_path, form="quick", workers=1)
    assert again.taken_from_file == 3 * 3 and again.tables["ladder"] == rows


def test_told_otherwise_is_the_same_run_with_another_word(monkeypatch):
    monkeypatch.setattr(ladder.cases, "stream", lambda size, seed: SCENE)
    told = []

    class Listens(Last):
        def set_gamma(self, gamma):
            told.append(gamma)

    monkeypatch.setitem(RUNGS, "listens", LadderRung(lambda w, h: Listens(), "tracker"))
    case = LadderCase("listens", 0, 10.0, 5e5, {OURS: ours(), "other": ours()})
    first, _ = case.measure()
    assert first["kind"] == "run" and first["alone"] == 1
    assert min(told[:-1]) < first["kept"] < 1  # the scheme says what it keeps, package by package
    for way, word in (("nothing", 1.0), ("mean", first["kept"])):
        told.clear()
        otherwise = dataclasses.replace(case, told=way)
        found, _ = otherwise.measure()
        assert (found["kind"], found["told"], found["kept"]) == ("told", way, first["kept"])
        assert word in told and set(told) <= {word, 1.0}  # all events, for comparison: gamma = 1
        assert key_of(otherwise) != key_of(case)
