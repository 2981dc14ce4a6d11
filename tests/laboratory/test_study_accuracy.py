"""asap-study --accuracy: what it runs, what it keeps, what it writes."""

import csv
import json
import math
import sys
import types

import numpy as np
import pytest

import asap
from asap_laboratory import AccuracyStudy, accuracy, accuracy_study
from asap_laboratory.accuracy.cases import RUNGS, AccuracyCase, Rung
from asap_laboratory.cli import main
from asap_laboratory.run import key_of
from asap_laboratory.scoring.curve import GAMMAS
from asap_laboratory.scoring.result import KeepCurve, Scored
from at_once import AtOnce
from fake_scene import FakeScene, perfect

SCENE = FakeScene([(50, 50, 0, 0), (150, 100, 0, 0)], end_us=120_001)


class Corners(FakeScene):
    def vertices(self, t_us):
        return np.array([(0, 50.0, 50.0)], [("id", int), ("x", float), ("y", float)])


class Detector:
    """Calls every event a corner; cannot be told."""

    def __init__(self, width, height):
        pass

    def process(self, events):
        return np.ones(events.size, bool)


def not_there(width, height):
    raise ValueError("engine = fast: not in this build")


@pytest.fixture
def small(monkeypatch):
    """Four algorithms, two scenes; the seeds whose scenes were made."""
    made = []

    def scene_of(name, seed):
        made.append((name, seed))
        return Corners(SCENE.objects, end_us=120_001) if "corners" in name else SCENE

    def tracker(width, height):
        return perfect(SCENE)

    rungs = {
        "best": Rung("best", tracker),
        "BAF + best": Rung("best", tracker, asap.BackgroundActivityFilter),
        "next": Rung("next", not_there),
        "all": Rung("all", Detector, corners=True),
    }
    monkeypatch.setattr(accuracy.cases, "RUNGS", rungs)
    monkeypatch.setattr("asap_laboratory.accuracy.conduct.RUNGS", rungs)
    monkeypatch.setattr(accuracy.cases, "scene_of", scene_of)
    return made


# ---- cases ----------------------------------------------------------------------------------


def test_forms_take_the_scenes_seeds_and_gammas_that_they_say(small):
    quick, default, full = (
        list(accuracy.cases.accuracy_cases(form)) for form in ("quick", "default", "full")
    )
    trackers = [case for case in default if case.rung == "best"]
    assert [(case.scene, case.seed) for case in trackers] == [
        (scene, seed) for seed in (0, 1, 2) for scene in "ABCDE"
    ]
    assert {case.gammas for case in default} == {GAMMAS} == {(1.0, 0.5, 0.2, 0.1, 0.05)}
    assert {case.rung for case in default} == {"best", "BAF + best", "all"}
    assert all("corners" in case.scene for case in default if case.rung == "all")
    assert {(case.scene, case.seed) for case in quick if case.rung == "best"} == {
        ("A", 0),
        ("E", 0),
    }
    assert {case.seed for case in full} == set(range(10))
    assert {case.scene for case in full} >= set("ABCDEFG")
    assert accuracy.cases.missing_rungs() == ["next"]


def test_every_algorithm_of_this_build_is_scored():
    missing = accuracy.cases.missing_rungs()
    assert set(missing) <= {"fast", "BAF + fast"}
    for label, rung in RUNGS.items():
        assert label == (f"BAF + {rung.algorithm}" if rung.before else rung.algorithm)
        if label not in missing:
            assert hasattr(rung.make(64, 64), "clusters") is not rung.corners


def test_scenes_are_those_of_asap_scenes(monkeypatch):
    scenes = types.ModuleType("asap_laboratory.scenes")
    scenes.A = lambda seed: ("A", seed)
    scenes.corners = lambda kind, seed: ("corners", kind, seed)
    monkeypatch.setitem(sys.modules, "asap_laboratory.scenes", scenes)
    assert accuracy.cases.scene_of("A", 3) == ("A", 3)
    assert accuracy.cases.scene_of("corners_noisy", 4) == ("corners", "noisy", 4)


def test_a_case_is_scored_at_every_gamma(small):
    found = AccuracyCase("BAF + best", "A", 7, (1.0, 0.5)).measure()
    assert [(one.gamma, one.told, one.seed) for one in found.scored] == [
        (1.0, None, 7),
        (0.5, True, 7),
        (0.5, False, 7),
    ]
    assert small == [("A", 7)]
    assert found.scored[0].figures["processed"] < found.scored[0].figures["events"]
    keys = {key_of(case) for case in accuracy.cases.accuracy_cases("quick")}
    assert len(keys) == 5


def test_heavier_cases_weigh_more():
    assert AccuracyCase("fast", "D").weight() > 2 * AccuracyCase("fast", "A").weight()
    whole = AccuracyCase("fast", "A", gammas=(1.0,)).weight()
    assert AccuracyCase("fast", "A", gammas=(1.0, 0.5)).weight() == 2 * whole == 2 * 442_961


# ---- the whole ------------------------------------------------------------------------------


def test_the_study_writes_and_goes_on_where_it_stopped(small, tmp_path):
    found = accuracy_study(tmp_path, form="quick", executor=AtOnce(), figures=False)
    named = [(curve.before, curve.algorithm, curve.scene) for curve in found.curves]
    assert named == [
        (None, "best", "A"),
        (None, "best", "E"),
        ("BAF", "best", "A"),
        ("BAF", "best", "E"),
        (None, "all", "corners_slow"),
    ]
    assert found.missing == ["next"]
    assert found.curves[0].rows[0].mean["mota"] == 1
    assert [row.told for row in found.curves[-1]] == [None, False]
    assert found.paths == [tmp_path / "accuracy.md", tmp_path / "accuracy.csv"]
    with found.paths[1].open() as file:
        rows = list(csv.DictReader(file))
    assert float(rows[0]["mota"]) == 1
    assert len(rows) == sum(len(curve.scored) for curve in found.curves)
    small.clear()
    again = accuracy_study(tmp_path, form="quick", executor=AtOnce(), figures=False)
    assert small == [] and again.taken_from_file == 5
    as_text = [json.dumps([curve.summary() for curve in one.curves]) for one in (found, again)]
    assert as_text[0] == as_text[1]
    accuracy_study(tmp_path, form="quick", executor=AtOnce(), figures=False, fresh=True)
    assert len(small) == 5


def test_the_document_names_command_seeds_and_what_is_missing(small, tmp_path):
    accuracy_study(tmp_path, form="quick", executor=AtOnce(), figures=False, command="as typed")
    text = (tmp_path / "accuracy.md").read_text()
    assert "`as typed`" in text and "1 seed of scene" in text
    assert "Not in this build: next." in text
    for heading in ("MOTA", "switches", "IDF1", "HOTA", "precision", "recall", "Cost"):
        assert f"\n## {heading}\n" in text


def test_every_scene_has_its_figure(small, tmp_path):
    pytest.importorskip("matplotlib")
    found = accuracy_study(tmp_path, form="quick", executor=AtOnce())
    names = [path.name for path in found.paths[2:]]
    assert names == ["accuracy_A.svg", "accuracy_E.svg", "accuracy_corners_slow.svg"]
    assert "![accuracy A](accuracy_A.svg)" in found.paths[0].read_text()
    text = found.paths[2].read_text()
    assert "scene A" in text and "BAF + best, not told" in text


def test_cells_are_mean_and_spread_by_scene():
    def curve(scene, *motas, before=None):
        scored = [
            Scored(1.0, None, s, {"mota": mota, "ns_per_event_p50": 12.4}) for s, mota in motas
        ]
        return KeepCurve("fast", scene, before, scored)

    curves = [
        curve("A", (0, 0.9), (1, 1.0)),
        curve("B", (0, math.nan)),
        curve("A", (0, 0.5), before="BAF"),
    ]
    lines = accuracy.document.by_scene(curves, "mota").splitlines()
    assert [
        [cell.strip() for cell in line.split("|")[1:-1]] for line in lines if "-:" not in line
    ] == [
        ["", "gamma", "", "A", "B"],
        ["fast", "1", "", ".950±.071", "-"],
        ["BAF + fast", "1", "", ".500", ""],
    ]
    assert "| 12 |" in accuracy.document.by_scene(curves, "ns_per_event_p50")


def test_unknown_forms_and_no_workers_are_refused(tmp_path):
    with pytest.raises(ValueError, match="form = 'slow': give one of quick, default, full"):
        accuracy_study(tmp_path, form="slow")
    with pytest.raises(ValueError, match="workers = 0"):
        accuracy_study(tmp_path, workers=0)


# ---- the command ----------------------------------------------------------------------------


@pytest.fixture
def asked(monkeypatch, tmp_path):
    """What the command asks the study for; the study is made up."""
    seen = []
    figures = dict.fromkeys(("mota", "id_switches", "idf1", "hota", "position_rms"), 0.5)
    curves = [
        KeepCurve("fast", "A", None, [Scored(1.0, None, 0, {**figures, "velocity_rms": math.nan})]),
        KeepCurve("EFast", "corners_slow", None, [Scored(1.0, None, 0, {"f_measure": 0.25})]),
    ]

    def study(out, **options):
        seen.append((out, options))
        return AccuracyStudy(curves, ["next"], [tmp_path / "accuracy.md"], 3, 2.0)

    monkeypatch.setattr("asap_laboratory.accuracy_study", study)
    return seen


def test_command_prints_the_tables(asked, tmp_path, capsys):
    assert main(["--accuracy", "--out", str(tmp_path), "--workers", "2"]) == 0
    out, err = capsys.readouterr()
    assert out.startswith("MOTA\n\n|  | gamma |  | A |\n") and "| fast | 1 |  | .500 |" in out
    assert "corners, F\n\n|  | gamma |  | corners_slow |\n" in out and "| .250 |" in out
    assert out.endswith("accuracy.md\n")
    assert err == "asap: next: not in this build\n"
    out, options = asked[0]
    assert (out, options["form"], options["workers"]) == (tmp_path, "default", 2)
    assert options["command"] == "asap-study --accuracy"


def test_command_with_json(asked, tmp_path, capsys):
    assert main(["--accuracy", "--full", "--fresh", "--json", "--out", str(tmp_path)]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["form"] == "full" and document["taken_from_file"] == 3
    assert [one["algorithm"] for one in document["accuracy"]] == ["fast", "EFast"]
    assert document["accuracy"][0]["rows"][0]["mean"]["velocity_rms"] is None
    assert asked[0][1]["command"] == "asap-study --accuracy --full" and asked[0][1]["fresh"]


def test_command_is_for_one_study_at_a_time(asked, tmp_path, capsys):
    assert main(["--accuracy", "--realtime", "--out", str(tmp_path)]) == 2
    assert "--accuracy and --realtime: give one of them" in capsys.readouterr().err
    assert asked == []
