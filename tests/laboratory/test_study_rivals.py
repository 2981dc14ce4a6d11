"""asap-study --rivals: what it runs, what it keeps, what it writes."""

import json
import math

import numpy as np
import pytest

import asap
from asap import _core, plots
from asap_laboratory import RivalsStudy, _native, rivals, rivals_study
from asap_laboratory.accuracy.cases import Rung
from asap_laboratory.cli import main
from asap_laboratory.rivals.cases import COLUMNS, OURS, RIVALS, RecordingCase, RivalsCase
from asap_laboratory.rivals.conduct import recordings_of
from asap_laboratory.run import run
from asap_laboratory.scoring.result import KeepCurve, Scored
from at_once import AtOnce
from fake_scene import FakeScene, perfect
from house import ROOT
from labelled_folders import folder

BAF = asap.BackgroundActivityFilter
SCENE = FakeScene([(50, 50, 0, 0), (150, 100, 0, 0)], end_us=120_001)


class Blind:
    """Never sees anything."""

    def __init__(self, width, height):
        self.clusters = _core.ClusterTracker(width, height).clusters

    def process(self, events, labels=True):
        pass


@pytest.fixture
def small(monkeypatch):
    """Two trackers, one scene; the scenes and seeds that were made."""
    made = []

    def scene_of(name, seed):
        made.append((name, seed))
        return SCENE

    def tracker(width, height):
        return perfect(SCENE)

    both = {OURS: Rung(OURS, tracker), "blind": Rung("blind", Blind)}
    monkeypatch.setattr(rivals.cases, "RIVALS", both)
    monkeypatch.setattr("asap_laboratory.rivals.conduct.RIVALS", both)
    monkeypatch.setattr(rivals.cases, "scene_of", scene_of)
    monkeypatch.setattr(rivals.cases, "costs_ns", lambda rungs, scene: dict.fromkeys(rungs, 7.4))
    monkeypatch.setattr(
        rivals.cases,
        "RivalsCase",
        lambda scene, seed: RivalsCase(scene, seed, tuple(both)),
    )
    return made


# ---- cases ----------------------------------------------------------------------------------


def test_forms_take_the_scenes_and_seeds_that_they_say():
    def seeds(form):
        found = {}
        for case in rivals.cases.rivals_cases(form):
            found.setdefault(case.scene, []).append(case.seed)
        return found

    scenes = [*"ABCDEFG", "H_bars", "H_angles", "H_rings", *"IJK"]
    assert seeds("quick") == {"A": [1000], "E": [1000]}
    assert seeds("default") == {scene: list(range(1000, 1020)) for scene in scenes}
    assert seeds("full") == {scene: list(range(1000, 1040)) for scene in scenes}


def test_the_rivals_are_those_that_their_labels_name():
    assert RIVALS[OURS].before is None and RIVALS[OURS].make(64, 48).engine == "fast"
    for label, rung in RIVALS.items():
        assert label == (f"BAF + {rung.algorithm}" if rung.before else rung.algorithm)
        assert rung.before in (None, BAF)
    assert isinstance(RIVALS["jAER-type core"].make(64, 48), _native.JaerClusterTracker)
    steady = RIVALS["BAF + compat steady"].make(64, 48).parameters
    assert (steady["engine"], steady["window"], steady["probes"]) == ("compat", 2000, 0)
    launched = RIVALS["compat"].make(64, 48).parameters
    assert (launched["engine"], launched["window"], launched["probes"]) == ("compat", 800, 1)


def test_a_case_scores_and_times_everybody(monkeypatch):
    monkeypatch.setattr(rivals.cases, "scene_of", lambda name, seed: SCENE)
    labels = (OURS, "BAF + jAER-type core")
    found = RivalsCase("A", 1000, labels).measure().rivals
    assert tuple(found) == labels
    assert all(tuple(one) == COLUMNS for one in found.values())
    assert all(one["ns_per_event"] > 0 for one in found.values())


def test_they_take_turns_and_the_median_counts(monkeypatch):
    turns = []
    costs = {OURS: [9, 1, 3], "other": [50, 60, 40]}

    def turn_ns(rung, scene, packages):
        turns.append(rung.algorithm)
        assert sum(package.size for package in packages) == scene.events.size
        return costs[rung.algorithm][(len(turns) - 1) // 2] * scene.events.size

    monkeypatch.setattr(rivals.cost, "_turn_ns", turn_ns)
    rungs = {name: Rung(name, Blind) for name in costs}
    assert rivals.cost.costs_ns(rungs, SCENE) == {OURS: 3, "other": 50}
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
        rung = Rung("counting", Counting, before)
        rivals.cases._scored(rung, noise)
        rivals.cost.costs_ns({"counting": rung}, noise)
    assert seen.count(0) >= 3 and sum(seen) >= 4 * noise.events.size


# ---- the whole ------------------------------------------------------------------------------


def test_the_study_writes_and_goes_on_where_it_stopped(small, tmp_path):
    found = rivals_study(tmp_path, form="quick", executor=AtOnce(), command="as typed")
    assert small == [("A", 1000), ("E", 1000)]
    assert [(curve.scene, curve.before, curve.algorithm) for curve in found.curves] == [
        (scene, None, name) for scene in "AE" for name in (OURS, "blind")
    ]
    assert found.curves[0].rows[0].mean["mota"] == 1
    assert found.curves[1].rows[0].mean["mota"] == 0
    text = found.paths[0].read_text()
    assert [path.name for path in found.paths] == ["rivals.md", "rivals.csv", "rivals.svg"]
    assert len(found.paths[1].read_text().splitlines()) == 1 + 4  # a row for each scene and tracker
    assert "`as typed`" in text and "; seed 1000 of every scene." in text
    assert "](rivals.svg)" in text and rivals.document.NO_RECORDINGS in text
    assert "No rival has a higher mean MOTA on any scene." in text
    for part in (rivals.document.accuracy, rivals.document.cost, rivals.document.table):
        assert part(found.curves) in text
    small.clear()
    again = rivals_study(tmp_path, form="quick", executor=AtOnce())
    assert small == [] and again.taken_from_file == 2
    assert [one.summary() for one in again.curves] == [one.summary() for one in found.curves]
    bare = rivals_study(tmp_path, form="quick", executor=AtOnce(), fresh=True, figures=False)
    assert len(small) == 2 and [path.suffix for path in bare.paths] == [".md", ".csv"]
    assert "rivals.svg" not in bare.paths[0].read_text()


def test_the_published_page_was_made_where_recordings_were():
    page = (ROOT / "notebooks" / "rivals.md").read_text()
    assert "## Recordings" in page and rivals.document.NO_RECORDINGS not in page


def test_recordings_are_scored_as_boxes_and_kept(tmp_path, monkeypatch):
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

    both = {OURS: Rung(OURS, Sure), "blind": Rung("blind", Blinder)}
    monkeypatch.setattr(rivals.cases, "RIVALS", both)
    case = RecordingCase(str(folder(tmp_path)), tuple(both))
    for taken in (0, 1):
        ran = run([case], state=tmp_path / "state.jsonl", executor=AtOnce())
        assert ran.taken_from_file == taken
        found = recordings_of(ran.results)[tmp_path.name]
        assert (found[OURS]["hit"], found[OURS]["mota"]) == (1, 1)
        assert found[OURS]["ns_per_event"] > 0
        assert found["blind"]["hit"] == 0 and math.isnan(found["blind"]["precision"])


def test_the_recordings_that_are_here_are_among_the_cases(tmp_path, monkeypatch):
    (tmp_path / "labelled" / "clip").mkdir(parents=True)
    folder(tmp_path / "labelled" / "clip")
    monkeypatch.setenv("ASAP_TEST_DATA", str(tmp_path))
    asked = []

    def ran(tasks, **others):
        asked.append([task.name for task in tasks])
        raise KeyboardInterrupt

    monkeypatch.setattr("asap_laboratory.rivals.conduct.run", ran)
    for form in ("quick", "default"):
        with pytest.raises(KeyboardInterrupt):
            rivals_study(tmp_path, form=form)
    assert asked[0] == ["7 trackers on A", "7 trackers on E"]
    assert len(asked[1]) == 13 * 20 + 1 and asked[1][-1] == "7 trackers on clip"


def curve(name, scene, *motas, before=None):
    rest = {"id_switches": 2, "position_rms": 1, "velocity_rms": 0.25, "ns_per_event": 12.4}
    scored = [
        Scored(1.0, None, seed, {"mota": mota, **rest}) for seed, mota in enumerate(motas, 200)
    ]
    return KeepCurve(name, scene, before, scored)


CURVES = [
    curve(OURS, "A", 1.0, 0.9),
    curve("old", "A", 0.5, 0.9, before="BAF"),
    curve(OURS, "B", 0.5, 0.5),
    curve("old", "B", 0.4, 0.75, before="BAF"),
]


BOXES = {"hit": 0.5, "precision": 0.25, "switches": 2, "longest": 0.4, "error": 1.5, "mota": -1.2}
BOXES["ns_per_event"] = 30.0
RECORDINGS = {"clip": {OURS: BOXES, "old": {**BOXES, "precision": math.nan, "mota": math.nan}}}


def cells_of(table):
    lines = table.splitlines()
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in [lines[0], *lines[2:]]]


def test_accuracy_has_the_best_in_bold_and_cost_stands_beside():
    assert cells_of(rivals.document.accuracy(CURVES)) == [
        ["scene", OURS, "BAF + old"],
        ["A", "**.950**", ".700"],
        ["B", ".500", "**.575**"],
    ]
    assert cells_of(rivals.document.cost(CURVES))[1] == ["A", "12", "12"]
    level = [curve(OURS, "H_bars", 0.9), curve("old", "H_bars", 0.9004)]
    assert cells_of(rivals.document.accuracy(level))[1] == ["H bars", "**.900**", "**.900**"]


def test_recordings_have_a_row_for_each_tracker():
    figures = ["2", ".400", "1.5"]
    assert cells_of(rivals.document.recordings_table(RECORDINGS))[1:] == [
        [OURS, "clip", ".500", ".250", *figures, "-1.200", "30"],
        ["old", "clip", ".500", "not judged", *figures, "not judged", "30"],
    ]


def test_the_figure_has_a_dot_for_each_tracker_in_both_panels(tmp_path):
    from asap_laboratory.rivals import figures

    far = curve(OURS, "C", -7.0)
    accuracy, cost = figures.draw([*CURVES, far], RECORDINGS).axes
    assert [text.get_text() for text in accuracy.get_yticklabels()] == ["A", "B", "C", "clip"]
    (ours,) = (line for line in accuracy.lines if line.get_label() == OURS)
    assert ours.get_xdata() == pytest.approx([0.95, 0.5, -1, -1])  # what is below -1 at the edge
    assert list(ours.get_ydata()) == [0, 1, 2, 3]
    (ours,) = (line for line in cost.lines if line.get_label() == OURS)
    assert ours.get_xdata() == pytest.approx([12.4, 12.4, 12.4, 30])
    drawn = figures.write(tmp_path / "rivals.svg", CURVES, {}).read_text()
    assert plots.BLUE in drawn
    assert set(figures._LOOKS) == set(RIVALS)


def test_the_table_has_a_row_for_each_scene_and_tracker():
    lines = rivals.document.table(CURVES).splitlines()
    cells = [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines[2:]]
    rest = ["2.0±0.0", "1.00±0.00", "25±0 %", "12"]
    assert cells == [
        [OURS, "A", "2", ".950±.071", "", *rest],
        ["BAF + old", "A", "2", ".700±.283", "1 / 1 / 0", *rest],
        [OURS, "B", "2", ".500±.000", "", *rest],
        ["BAF + old", "B", "2", ".575±.247", "1 / 0 / 1", *rest],
    ]


def test_prototypes_stand_beside():
    rival = "BAF + jAER-type core"
    curves = [curve("jAER-type core", scene, 0.5, before="BAF") for scene in "CG"]
    lines = rivals.document.beside_prototypes([*curves, *CURVES]).splitlines()
    assert lines[0] == "|  | C | G | A | B |"
    assert lines[2:] == [
        f"| {rival} | .500 (.824) | .500 |  |  |",
        f"| {OURS} |  |  | .950 (1.000) | .500 (.990) |",
        "| BAF + old |  |  | .700 | .575 |",
    ]
    assert set(rivals.document._MOTA_OF_PROTOTYPES) == set(RIVALS)


def test_the_verdict_names_who_is_better():
    assert rivals.document.verdict(CURVES) == (
        "Higher mean MOTA than `fast`, the best on each scene: BAF + old on B (by .07)."
    )
    better = [*CURVES, curve("new", "B", 0.6, 0.6), curve("far", "A", 3.0, 3.0)]
    assert rivals.document.verdict(better).endswith(": far on A (by 2.05), new on B (by .10).")
    assert rivals.document.verdict(CURVES[:2]) == "No rival has a higher mean MOTA on any scene."


def test_unknown_forms_are_refused(tmp_path):
    with pytest.raises(ValueError, match="form = 'slow': give one of quick, default, full"):
        rivals_study(tmp_path, form="slow")


# ---- the command ----------------------------------------------------------------------------


@pytest.fixture
def asked(monkeypatch, tmp_path):
    """What the command asks the study for; the study is made up."""
    seen = []

    def study(out, **options):
        seen.append((out, options))
        return RivalsStudy(CURVES, RECORDINGS, [tmp_path / "rivals.md"], 3, 2.0)

    monkeypatch.setattr("asap_laboratory.rivals_study", study)
    return seen


def test_command_prints_verdict_and_table(asked, tmp_path, capsys):
    assert main(["--rivals", "--quick", "--out", str(tmp_path)]) == 0
    out, _ = capsys.readouterr()
    assert out.startswith("Higher mean MOTA than `fast`, the best on each scene: BAF + old on B")
    for part in (rivals.document.accuracy(CURVES), rivals.document.cost(CURVES)):
        assert part in out
    assert rivals.document.recordings_table(RECORDINGS) in out and out.endswith("rivals.md\n")
    assert (asked[0][0], asked[0][1]["form"]) == (tmp_path, "quick")
    assert asked[0][1]["command"] == "asap-study --rivals --quick"


def test_command_with_json(asked, tmp_path, capsys):
    assert main(["--rivals", "--json", "--out", str(tmp_path)]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["form"], document["taken_from_file"]) == ("default", 3)
    assert [one["algorithm"] for one in document["rivals"]] == [OURS, "old"] * 2
    assert document["rivals"][0]["rows"][0]["mean"]["ns_per_event"] == 12.4
    assert document["recordings"]["clip"]["old"] == {**BOXES, "precision": None, "mota": None}
