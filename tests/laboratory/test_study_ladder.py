"""asap-study --ladder: costs, settings, accuracy under a scheme, and the quick form as a whole."""

import json
import math

import numpy as np
import pytest

import asap
import streams
from asap import _core
from asap_laboratory import ladder, ladder_study, scenes
from asap_laboratory.cli import main
from asap_laboratory.ladder.accuracy import (
    Delivery,
    Recorder,
    corner_accuracy,
    samples_without_clusters,
    tracker_accuracy,
)
from asap_laboratory.ladder.cases import LadderCase, Loaded, Outcomes, ToldCase
from asap_laboratory.ladder.cost import Costs, fit, measured
from asap_laboratory.ladder.naive import NaiveClusterer
from asap_laboratory.ladder.results import Mean, row
from asap_laboratory.ladder.rungs import RUNGS, LadderRung
from asap_laboratory.ladder.settings import (
    BASELINES,
    OURS,
    Setting,
    Tried,
    best,
    best_for_all,
    ours,
    tried,
)
from asap_laboratory.run import key_of
from asap_laboratory.scoring import score
from asap_laboratory.scoring.trace import follow
from at_once import AtOnce
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


class Warmed:
    """Says of every package whether half of the stream came before it, since the last reset."""

    def __init__(self, width, height):
        self.seen = 0
        self.was_warm = []

    def process(self, package):
        if self.seen:
            self.was_warm.append(self.seen >= 15_000)
        self.seen += package.size

    def reset(self):
        self.seen = 0


def test_costs_are_those_of_a_stream_that_has_gone_on_for_a_while():
    """On an empty surface corner detectors cost a third."""
    algorithm = Warmed(8, 8)
    measured(LadderRung(Warmed), algorithm, streams.make(range(30_000)))
    assert len(algorithm.was_warm) > 300 and all(algorithm.was_warm)


# ---- settings -------------------------------------------------------------------------------


def one(in_time, p99_ms, scheme="FixedSize", size=10, for_all=True):
    return Tried(Setting(scheme, {"size": size}, 64, for_all), in_time, p99_ms)


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
    found = tried(events, 1.0, 10_000.0, opaque=False)
    for name in BASELINES:
        chosen = best(found, name)
        merit = next(one for one in found if one.setting == chosen)
        assert merit.p99_ms <= 3.0 and merit.in_time > 0.05
    with_whole_ring = [
        one
        for one in found
        if one.setting.capacity >= 1 << 20 and one.setting.scheme == "FixedSize"
    ]
    assert all(one.p99_ms > 30 and one.in_time < 0.05 for one in with_whole_ring)


# ---- accuracy -------------------------------------------------------------------------------


def test_samples_are_those_of_score():
    trace = follow(perfect(SCENE), SCENE)
    for mine, its in zip(samples_without_clusters(SCENE), trace.samples, strict=True):
        assert mine.t_us == its.t_us
        np.testing.assert_array_equal(mine.active, its.active)
        np.testing.assert_array_equal(mine.centres, its.centres)


def test_delivered_at_once_is_the_score_and_both_are_one():
    scene = scenes.timing(5, 200, 150, 150.0, seed=3, duration_s=0.15)

    def make():
        return _core.ClusterTracker(200, 150, engine="compat", window=2000, probes=0, weight=0.05)

    used = tracker_accuracy(make, scene, whole(scene))
    assert used.delivered == used.in_use == score(make(), scene)["mota"] > 0.1


class Last:
    """Two clusters: at the last event of each object."""

    def __init__(self):
        self.rows = {}
        self.keeps = []

    def set_keep(self, gamma):
        self.keeps.append(gamma)

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


def test_what_is_never_delivered_is_missed():
    assert tracker_accuracy(Last, SCENE, []) == (0, 0)
    first = whole(SCENE)[:1]
    assert tracker_accuracy(Last, SCENE, first).in_use == pytest.approx(0.0)


def test_a_package_with_a_long_gap_is_cut_at_each_sample_once():
    events = SCENE.events[[0, 1, -2, -1]]
    parts = ladder.accuracy._split_at([Delivery(events, 0.5, 1e6)], [105_000, 110_000, 115_000])
    assert [part.events.size for part in parts] == [2, 2]
    assert [part.keep for part in parts] == [0.5, 0.5]


def test_an_event_at_a_sample_time_is_not_in_that_sample():
    events = streams.make([100, 200])
    before, at = ladder.accuracy._split_at([Delivery(events, 1.0, 900.0)], [200])
    assert before.events["t"].tolist() == [100] and at.events["t"].tolist() == [200]
    assert before.done_us <= 200 < at.done_us


def test_the_tracker_is_told_what_the_scheme_told():
    tracker = Last()
    tracker_accuracy(lambda: tracker, SCENE, [one._replace(keep=0.25) for one in whole(SCENE)])
    assert set(tracker.keeps) == {0.25}


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
    assert min(one.keep for one in packages) < 1


# ---- rungs ----------------------------------------------------------------------------------


def test_naive_clusterer_is_the_rule_of_compat():
    scene = scenes.timing(5, 200, 150, 300.0, seed=1, duration_s=0.03)
    events = scene.events[np.unique(scene.events["t"], return_index=True)[1]]
    naive = NaiveClusterer(window=300)
    compat = _core.ClusterTracker(
        200, 150, engine="compat", window=300, probes=0, weight=0.05, min_size=15
    )
    for begin in range(0, events.size, 97):
        naive.process(events[begin : begin + 97])
        compat.process(events[begin : begin + 97])
        mine, its = (np.sort(one.clusters[["x", "y"]], order="x") for one in (naive, compat))
        assert mine.size == its.size
        for axis in "xy":
            np.testing.assert_allclose(mine[axis], its[axis], atol=1e-6)
    assert events.size > 3 * 300 and mine.size > 1


def test_every_consumer_of_this_build_is_on_the_ladder():
    assert set(ladder.rungs.missing_rungs()) <= {"fast", "fast, 300 ns"}
    stream = ladder.rungs.stream("small", 0)
    for label, rung in RUNGS.items():
        if label not in ladder.rungs.missing_rungs():
            made = rung.make(stream.width, stream.height)
            made.process(stream.events[:100])
            assert (rung.score == "tracker") is hasattr(made, "clusters")
            assert rung.opaque is not _core.is_native(made)


# ---- the whole ------------------------------------------------------------------------------


@pytest.fixture
def missing(monkeypatch):
    """A consumer that this build does not have."""

    def not_there(width, height):
        raise ValueError("engine = next: not in this build")

    monkeypatch.setitem(RUNGS, "next", LadderRung(not_there))
    monkeypatch.setattr(ladder.conduct, "_QUICK", ("BAF", "EFast", "compat, 2 us", "next"))


def test_quick_form_writes_what_it_says_and_goes_on_where_it_stopped(missing, tmp_path):
    found = ladder_study(tmp_path, form="quick", executor=AtOnce(), figures=False, command="typed")
    assert "next" in found.missing
    assert [one.rung for one in found.rows] == ["BAF", "EFast", "compat, 2 us"]
    baf, efast, compat = found.rows
    assert baf.load < 1 < efast.load < compat.load and compat.stated and not baf.stated
    for one in found.rows:
        assert tuple(one.virtual) == tuple(one.real) == tuple(one.settings) == LABELS
        assert one.virtual[OURS]["in_time"].mean == pytest.approx(one.possible, rel=0.15)
        assert one.virtual[OURS]["overflow"].mean == 0
        assert 0 <= one.real[OURS]["in_time"].mean <= 1  # no claim: the machine may be busy
    assert baf.virtual[OURS]["delivered"].mean != baf.virtual[OURS]["delivered"].mean  # no score
    assert 0 < efast.virtual[OURS]["in_use"].mean < efast.alone.mean < 1
    assert compat.virtual[OURS]["in_use"].mean < compat.alone.mean
    text = (tmp_path / "ladder.md").read_text()
    assert found.paths == [tmp_path / "ladder.md", tmp_path / "ladder.csv"]
    rows = found.paths[1].read_text().splitlines()
    schemes = 2 * sum(len(one.virtual) for one in found.rows)
    assert len(rows) == 1 + schemes + len(found.bounds) + sum(len(one.in_use) for one in found.told)
    for words in ("`typed`", "1 seed.", "Not in this build: ", "| compat, 2 us |", "In real time"):
        assert words in text
    again = ladder_study(tmp_path, form="quick", executor=AtOnce(), figures=False)
    assert again.taken_from_file == 3 * 3
    assert [one.to_dict() for one in again.rows] == [one.to_dict() for one in found.rows]


def test_told_otherwise_is_the_same_run_with_another_word(monkeypatch):
    monkeypatch.setattr(ladder.cases, "stream", lambda size, seed: SCENE)
    told = []

    class Listens(Last):
        def set_keep(self, gamma):
            told.append(gamma)

    monkeypatch.setitem(RUNGS, "listens", LadderRung(lambda w, h: Listens(), "tracker"))
    case = ("listens", 0, 10.0, 5e5, {OURS: ours()}, "whole", 3.0)
    whole_case = LadderCase(*case).measure()
    kept = whole_case.schemes[OURS].kept
    assert min(told[:-1]) < kept < 1  # the scheme says what it keeps, package by package
    for way, word in (("nothing", 1.0), ("mean", kept)):
        told.clear()
        found = ToldCase(*case, way).measure()
        assert found.schemes[OURS].kept == kept and word in told
        assert set(told) <= {word, 1.0}  # all events, for comparison, are gamma = 1
        assert key_of(ToldCase(*case, way)) != key_of(LadderCase(*case))


def test_forms_and_workers_are_checked(tmp_path):
    with pytest.raises(ValueError, match="form = 'slow'"):
        ladder_study(tmp_path, form="slow")
    with pytest.raises(ValueError, match="workers = 0"):
        ladder_study(tmp_path, workers=0)


# ---- results, tables, figure, command -------------------------------------------------------


def outcome(in_use):
    values = Loaded(0.5, 0.4, 0.9, 1.0, 0.5, 0.0, 0.7, in_use)
    return Outcomes(dict.fromkeys(LABELS, values), 1e6, alone=0.8, late_p99_us=500.0)


def made_row(rung="compat", beta_ns=500.0, in_use=(0.5, 0.7)):
    seeds = [outcome(one) for one in in_use]
    settings = dict.fromkeys(LABELS, ours())
    return row(rung, Costs(1.0, beta_ns, []), settings, seeds, seeds)


def test_rows_hold_mean_and_spread_over_the_seeds():
    found = made_row()
    assert found.load == pytest.approx(4) and found.possible == pytest.approx(0.25)
    assert found.virtual[OURS]["in_use"] == pytest.approx((0.6, math.sqrt(0.02)))
    assert Mean.of([None, math.nan]).mean != Mean.of([None]).mean  # NaN, both
    assert json.loads(json.dumps(found.to_dict(), allow_nan=False))["rung"] == "compat"


def test_tables_show_what_does_not_exist_as_a_dash():
    lines = ladder.document.accuracy_table([made_row(in_use=(None,))], "in_use").splitlines()
    assert lines[2].startswith("| compat | MOTA | .800 | - |")
    assert "| 500 | 4 | .250 | .400 |" in ladder.document.in_time_table([made_row()])


def test_figure_has_a_line_for_each_scheme_and_a_name_for_each_rung():
    pytest.importorskip("matplotlib")
    from asap_laboratory.ladder import figures

    rows = [made_row("BAF", 5.0), made_row("EFast", 60.0), made_row("compat", 500.0, (-1.0,))]
    page = figures.figure(rows)
    whole, trackers, corners = page.axes
    assert {text.get_text() for text in whole.texts} == {"BAF", "EFast", "compat"}
    assert {text.get_text() for text in corners.texts} == {"EFast"}
    assert len(whole.get_legend_handles_labels()[1]) == len(LABELS)
    assert trackers.containers[0].lines[0].get_ydata().tolist() == [0.0]  # worse than nothing


def test_crowded_names_move_apart():
    pytest.importorskip("matplotlib")
    from asap_laboratory.ladder.figures import _apart

    places = _apart(np.array([1.0, 1.01, 1.02, 3.0]), 0.2, 0.5)
    assert np.diff(places).min() == pytest.approx(0.2, rel=1e-3)
    assert places[3] == 3 and places[:3].mean() == pytest.approx(1.01)
    assert _apart(np.array([1.0, 1.01]), 0.2, 0.95) == pytest.approx([0.95, 1.15], abs=1e-3)


def test_command_prints_tables_or_json(monkeypatch, tmp_path, capsys):
    seen = []

    def study(out, **options):
        seen.append(options)
        return ladder.conduct.LadderStudy(
            [made_row()], [], [], ["fast"], [tmp_path / "ladder.md"], 3, 2.0
        )

    monkeypatch.setattr("asap_laboratory.ladder_study", study)
    assert main(["--ladder", "--quick", "--out", str(tmp_path)]) == 0
    out, err = capsys.readouterr()
    assert "finished within L" in out and "| compat | MOTA |" in out and "ladder.md" in out
    assert "fast: not in this build" in err
    assert seen[0]["form"] == "quick" and seen[0]["command"] == "asap-study --ladder --quick"
    assert main(["--ladder", "--json", "--out", str(tmp_path)]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["form"] == "default" and document["ladder"][0]["rung"] == "compat"
    assert main(["--ladder", "--accuracy", "--out", str(tmp_path)]) == 2
    assert "give one of them" in capsys.readouterr().err


def test_a_case_is_known_by_its_bound():
    case = LadderCase("BAF", 0, 1.0, 10.0, {OURS: ours()})
    assert key_of(case) != key_of(LadderCase("BAF", 0, 1.0, 10.0, {OURS: ours(1.0)}))
