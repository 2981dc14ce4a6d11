"""The accuracy study and that of the rivals: who is compared on what, the tables, the figures."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

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


def test_accuracy_is_measured_tabled_and_drawn(monkeypatch, tmp_path):
    scene = Corners(SCENE.objects, end_us=120_001)
    monkeypatch.setattr(accuracy, "scene_of", lambda name, seed: scene)
    monkeypatch.setitem(RUNGS, "ClusterTracker", Rung(lambda width, height: perfect(scene)))
    cases = [
        AccuracyCase(rung, where, seed, (1.0, 0.5))
        for rung, where in (
            ("ClusterTracker", "A"),
            ("BAF + ClusterTracker", "A"),
            ("EFast", "corners_slow"),
        )
        for seed in (0, 1)
    ]

    def batches(form):
        yield accuracy.Batch(cases)

    study = dataclasses.replace(STUDIES["accuracy"], batches=batches)
    found = conduct(study, tmp_path, workers=1)
    rows = found.tables["accuracy"]
    assert [row["told"] for row in only(rows, algorithm="ClusterTracker")] == [None, True, False]
    assert {row["mota"] for row in only(rows, algorithm="ClusterTracker")} == {1}
    names = ["accuracy.md", "accuracy.csv", "accuracy_A.svg", "accuracy_corners_slow.svg"]
    assert [path.name for path in found.paths] == names
    text = found.paths[0].read_text()
    assert "| ClusterTracker | 0.5 | not told | 1.000±.000 |" in text and "2 seeds of scene" in text
    assert text.index("## MOTA") < text.index("## precision") < text.index("## Cost")
    shown = study.shown(found.tables, Writer(study.cells))
    assert shown.startswith("MOTA\n\n") and "\nF\n\n" in shown


# ---- rivals: cases --------------------------------------------------------------------------


def test_the_rivals_are_those_that_their_labels_name():
    assert RIVALS[OURS].before is None and RIVALS[OURS].make is _core.ClusterTracker
    for label, rung in RIVALS.items():
        assert rung.before is (BAF if label.startswith("BAF + ") else None)
    assert isinstance(RIVALS["jAER-type core"].make(64, 48), _native.JaerClusterTracker)
    for label, window, probes in (("BAF + published, steady", 2000, 0), ("published", 800, 1)):
        found = RIVALS[label].make(64, 48)
        assert type(found) is _core.PublishedClusterTracker
        assert (found.parameters["window"], found.parameters["probes"]) == (window, probes)


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


def test_all_trackers_of_a_scene_are_one_task(monkeypatch):
    monkeypatch.setattr(rivals, "scene_of", lambda name, seed: SCENE)
    labels = (OURS, "BAF + jAER-type core")
    found = RivalsCase("A", 1000, labels).measure()
    assert [row["tracker"] for row in found] == list(labels)
    assert all(row["ns_per_event"] > 0 for row in found)
