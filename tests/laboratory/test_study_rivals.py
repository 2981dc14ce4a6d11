"""The accuracy study and that of the rivals: who is compared on what, the tables, the figures."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

import asap
from asap import _core
from asap_laboratory import STUDIES, _native, accuracy, conduct, rivals
from asap_laboratory.accuracy import RUNGS, AccuracyCase, Rung
from asap_laboratory.page import Writer, only
from asap_laboratory.rivals import RivalsCase, trackers
from asap_laboratory.rivals.recordings import RecordingCase
from asap_laboratory.rivals.trackers import OURS, RIVALS
from fake_scene import FakeScene, perfect
from labelled_folders import folder

BAF = asap.BackgroundActivityFilter
SCENE = FakeScene([(50, 50, 0, 0), (150, 100, 0, 0)], end_us=120_001)


class Blind:
    """Never sees anything."""

    def __init__(self, width, height):
        self.clusters = _core.ClusterTracker(width, height).clusters

    def process(self, events, labels=True):
        pass


class Corners(FakeScene):
    def vertices(self, t_us):
        return np.array([(0, 50, 50)], [("id", int), ("x", float), ("y", float)])


# ---- accuracy -------------------------------------------------------------------------------


def tasks(study, form):
    return next(study.batches(form)).tasks


def test_forms_take_the_scenes_seeds_and_gammas_that_they_say():
    found = tasks(STUDIES["accuracy"], "default")
    assert {case.rung for case in found} == set(RUNGS) and {case.seed for case in found} == {
        0,
        1,
        2,
    }
    for case in found:
        corners = RUNGS[case.rung].corners
        assert case.scene in (("corners_slow", "corners_noisy") if corners else "ABCDE")
        assert case.gammas == (1.0, 0.5, 0.2, 0.1, 0.05)
    assert {case.scene for case in tasks(STUDIES["accuracy"], "quick")} == {*"AE", "corners_slow"}
    assert {case.seed for case in tasks(STUDIES["accuracy"], "full")} == set(range(10))


def test_the_scene_of_a_name_is_the_scene_of_that_name():
    for name in ("A", "H_bars", "corners_slow"):
        assert accuracy.scene_of(name, 3).name == name and accuracy.scene_of(name, 3).seed == 3


def test_accuracy_is_measured_tabled_and_drawn(monkeypatch, tmp_path):
    scene = Corners(SCENE.objects, end_us=120_001)
    monkeypatch.setattr(accuracy, "scene_of", lambda name, seed: scene)
    monkeypatch.setitem(RUNGS, "fast", Rung(lambda width, height: perfect(scene)))
    cases = [
        AccuracyCase(rung, where, seed, (1.0, 0.5))
        for rung, where in (("fast", "A"), ("BAF + fast", "A"), ("EFast", "corners_slow"))
        for seed in (0, 1)
    ]

    def batches(form):
        yield accuracy.Batch(cases)

    study = dataclasses.replace(STUDIES["accuracy"], batches=batches)
    found = conduct(study, tmp_path, workers=1)
    rows = found.tables["accuracy"]
    assert [row["told"] for row in only(rows, algorithm="fast")] == [None, True, False]
    assert {row["mota"] for row in only(rows, algorithm="fast")} == {1}
    names = ["accuracy.md", "accuracy.csv", "accuracy_A.svg", "accuracy_corners_slow.svg"]
    assert [path.name for path in found.paths] == names
    text = found.paths[0].read_text()
    assert "| fast | 0.5 | not told | 1.000±.000 |" in text and "2 seeds of scene" in text
    assert text.index("## MOTA") < text.index("## precision") < text.index("## Cost")
    shown = study.shown(found.tables, Writer(study.cells))
    assert shown.startswith("MOTA\n\n") and "\nF\n\n" in shown


# ---- rivals: cases --------------------------------------------------------------------------


def test_rivals_meet_on_the_scenes_and_seeds_that_the_forms_say(monkeypatch, tmp_path):
    monkeypatch.setenv("ASAP_TEST_DATA", str(tmp_path))

    def seeds(form):
        found = {}
        for case in tasks(STUDIES["rivals"], form):
            found.setdefault(getattr(case, "scene", "clip"), []).append(getattr(case, "seed", None))
        return found

    scenes = [*"ABCDEFG", "H_bars", "H_angles", "H_rings", *"IJK"]
    assert seeds("default") == {scene: list(range(1000, 1020)) for scene in scenes}
    (tmp_path / "labelled" / "clip").mkdir(parents=True)
    folder(tmp_path / "labelled" / "clip")
    assert seeds("quick") == {"A": [1000], "E": [1000]}
    assert seeds("full") == {scene: list(range(1000, 1040)) for scene in scenes} | {"clip": [None]}


def test_the_rivals_are_those_that_their_labels_name():
    assert RIVALS[OURS].before is None and RIVALS[OURS].make(64, 48).engine == "fast"
    for label, rung in RIVALS.items():
        assert rung.before is (BAF if label.startswith("BAF + ") else None)
    assert isinstance(RIVALS["jAER-type core"].make(64, 48), _native.JaerClusterTracker)
    for label, window, probes in (("BAF + compat steady", 2000, 0), ("compat", 800, 1)):
        found = RIVALS[label].make(64, 48).parameters
        assert (found["engine"], found["window"], found["probes"]) == ("compat", window, probes)


def test_they_take_turns_and_the_median_counts(monkeypatch):
    turns = []
    costs = {OURS: [9, 1, 3], "other": [50, 60, 40]}
    rungs = {name: Rung(Blind) for name in costs}

    def turn_ns(rung, scene, packages):
        name = next(one for one, known in rungs.items() if known is rung)
        turns.append(name)
        assert sum(package.size for package in packages) == scene.events.size
        return costs[name][(len(turns) - 1) // 2] * scene.events.size

    rungs["other"] = Rung(Blind, BAF)
    monkeypatch.setattr(trackers, "_turn_ns", turn_ns)
    assert trackers.costs_ns(rungs, SCENE) == {OURS: 3, "other": 50}
    assert turns == [OURS, "other"] * 3


def test_the_filter_stands_in_front_when_scored_and_when_timed():
    seen = []

    class Counting(Blind):
        def process(self, events, labels=True):
            seen.append(events.size)

    noise = FakeScene([], end_us=120_001)
    noise.events = SCENE.events[::50].copy()  # far apart in time: no company
    noise.labels = SCENE.labels[::50]
    for before in (None, BAF):
        rung = Rung(Counting, before)
        rivals._scored(rung, noise)
        trackers.costs_ns({"counting": rung}, noise)
    assert seen.count(0) >= 3 and sum(seen) >= 4 * noise.events.size


def test_a_recording_is_scored_by_its_boxes(tmp_path, monkeypatch):
    class Sure(Blind):
        """Says that id 7 is at (20, 20), where the box is."""

        def __init__(self, width, height):
            self.clusters = np.zeros(1, _core.ClusterTracker(width, height).clusters.dtype)
            self.clusters["id"], self.clusters["x"], self.clusters["y"] = 7, 20, 20

        def clusters_at(self, t_us):
            return self.clusters

    class Blinder(Sure):
        def clusters_at(self, t_us):
            return self.clusters[:0]

    monkeypatch.setitem(RIVALS, "sure", Rung(Sure))
    monkeypatch.setitem(RIVALS, "blind", Rung(Blinder))
    sure, blind = RecordingCase(str(folder(tmp_path)), ("sure", "blind")).measure()
    assert (sure["set"], sure["tracker"], sure["hit"], sure["mota"]) == (
        *(tmp_path.name, "sure", 1, 1),
    )
    assert sure["ns_per_event"] > 0 and blind["hit"] == 0 and math.isnan(blind["precision"])


# ---- rivals: tables and figure --------------------------------------------------------------

BOXES = {"hit": 0.5, "precision": 0.25, "switches": 2, "longest": 0.4, "error": 1.5, "mota": -1.2}


def scored(scene, tracker, *motas):
    rest = {"id_switches": 2, "position_rms": 1, "velocity_rms": 0.25, "ns_per_event": 12.4}
    what = {"kind": "scene", "scene": scene, "tracker": tracker, **rest}
    return [{**what, "seed": seed, "mota": mota} for seed, mota in enumerate(motas, 1000)]


ROWS = [
    *(*scored("A", OURS, 1.0, 0.9), *scored("A", "BAF + old", 0.5, 0.9)),
    *(*scored("H_bars", OURS, 0.5, 0.5), *scored("H_bars", "BAF + old", 0.4, 0.75)),
    {"kind": "recording", "set": "clip_1", "tracker": OURS, **BOXES, "ns_per_event": 30.0},
    {
        **{"kind": "recording", "set": "clip_1", "tracker": "old", **BOXES, "ns_per_event": 30.0},
        **{"precision": None, "mota": None},
    },
]


@pytest.fixture
def made(tmp_path):
    """The study of these rows: tables and page."""

    class Made:
        pass

    def batches(form):
        yield rivals.Batch([])

    study = dataclasses.replace(
        STUDIES["rivals"], batches=batches, summary=lambda rows: rivals._summary(ROWS)
    )
    return study, conduct(study, tmp_path, workers=1)


def test_the_page_has_every_table(made):
    study, found = made
    text = found.paths[0].read_text()
    for line in (
        "Higher mean MOTA than `fast`, the best on each scene: BAF + old on H bars (by .07).",
        "| A | **.950** | .700 |",
        "| H bars | .500 | **.575** |",
        "| A | 12 | 12 |",
        f"| {OURS} | clip_1 | .500 | .250 | 2 | .400 | 1.5 | -1.200 | 30 |",
        "| old | clip_1 | .500 | not judged | 2 | .400 | 1.5 | not judged | 30 |",
        f"| {OURS} | A | 2 | .950±.071 |  | 2.0±0.0 | 1.00±0.00 | 25±0 % | 12 |",
        "| BAF + old | A | 2 | .700±.283 | 1 / 1 / 0 | 2.0±0.0 | 1.00±0.00 | 25±0 % | 12 |",
        "| BAF + old | H_bars | 2 | .575±.247 | 1 / 0 / 1 | 2.0±0.0 | 1.00±0.00 | 25±0 % | 12 |",
    ):
        assert line in text.splitlines()
    assert "; seeds 1000 to 1001 of every scene." in text
    shown = study.shown(found.tables, Writer(study.cells))
    assert shown.startswith("Higher mean MOTA") and "| old | clip_1 |" in shown


def test_all_trackers_of_a_scene_are_one_task(monkeypatch):
    monkeypatch.setattr(rivals, "scene_of", lambda name, seed: SCENE)
    labels = (OURS, "BAF + jAER-type core")
    found = RivalsCase("A", 1000, labels).measure()
    assert [row["tracker"] for row in found] == list(labels)
    assert all(row["ns_per_event"] > 0 for row in found)
