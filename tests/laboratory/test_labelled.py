"""Recordings with boxes: how a folder is read and refused, and every rule of the score by hand."""

from __future__ import annotations

import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
from asap_laboratory import score
from asap_laboratory.scenes import labelled
from event_files import recording
from fake_scene import FakeTracker
from labelled_folders import T0_US, box, folder


def scored(path: Path, clusters: dict[int, list[tuple[int, float, float]]], **others: Any) -> Any:
    """Score a tracker that says (id, x, y) at each ms after T0_US."""
    scene = labelled(folder(path, **others))
    tracker = FakeTracker(lambda t_us: clusters.get((t_us - T0_US) // 1000, []))
    return score(tracker, scene)


# ---- the folder -----------------------------------------------------------------------------


def test_a_folder_is_a_scene_and_a_source(tmp_path: Path) -> None:
    scene = labelled(folder(tmp_path, zones=f"1,5,2,6,{T0_US},{T0_US + 9}\n"))
    assert (scene.width, scene.height, scene.camera) == (100, 80, "still")
    assert scene.background_labelled and scene.name == tmp_path.name
    assert scene.events.dtype == asap.EVENT_DTYPE and scene.events.size == 100
    assert scene.boxes.tolist() == [
        (T0_US + us, 0, 10.0, 15.0, 20.0, 10.0) for us in (10_000, 20_000, 30_000)
    ]
    assert scene.ignore.tolist() == [(1.0, 5.0, 2.0, 6.0, T0_US, T0_US + 9)]
    assert "100 events, 1 objects in 3 boxes" in repr(scene)
    assert np.array_equal(pickle.loads(pickle.dumps(scene)).boxes, scene.boxes)
    run = asap.simulate(scene, cost=asap.LinearCost(10, 10), latency_ms=10)
    assert run.ledger.received == 100


@pytest.mark.parametrize("name", ["events.npz", "truth.csv", "ignore.csv", "sensor.json"])
def test_a_missing_file_is_named(tmp_path: Path, name: str) -> None:
    (folder(tmp_path) / name).unlink()
    with pytest.raises(FileNotFoundError, match="no such file; a labelled folder has") as caught:
        labelled(tmp_path)
    assert Path(caught.value.filename).name == name


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("#t_us,theta_rad\n", "no column h, id, t_us, w, x, y; give t_us, id, x, y, w, h"),
        (box(10) + box(20)[:-11] + "\n", "row 3: h = None: give a finite number, in px"),
        (box(10) + box(10), "row 3: id = 0: give one box per time"),
        (box(-101), "row 2: t_us = 4899000: give the clock of events.npz, 5000000 to 5099000 us"),
        (box(10, x=100), "row 2: x = 100.0: the box lies off the sensor of 100 x 80 px; correct"),
        (box(10, w=0), "row 2: w = 0.0: give more than 0 px"),
        (box(10, h=math.nan), "row 2: h = 'nan': give a finite number, in px"),
        (box(10).replace(",0,", ",a,", 1), "row 2: id = 'a': give a whole number"),
        (box(10, id=1 << 63), f"row 2: id = '{1 << 63}': give a whole number"),
        ("\n", "no row; give at least one box"),
    ],
)
def test_a_bad_truth_is_refused_by_file_and_row(tmp_path: Path, rows: str, message: str) -> None:
    with pytest.raises(ValueError, match=rf"truth\.csv: {message}"):
        labelled(folder(tmp_path, rows))


def test_a_sensor_that_is_no_json_or_too_small_is_refused(tmp_path: Path) -> None:
    (folder(tmp_path) / "sensor.json").write_text("width 100")
    with pytest.raises(ValueError, match=r"sensor\.json: .*give a JSON object"):
        labelled(tmp_path)
    (folder(tmp_path) / "sensor.json").write_text("[100, 80]")
    with pytest.raises(ValueError, match=r"sensor\.json: give a JSON object with width, height"):
        labelled(tmp_path)
    with pytest.raises(ValueError, match=r"events\.npz"):
        labelled(folder(tmp_path, width=20))


def test_events_that_are_none_or_of_another_clock_are_refused(tmp_path: Path) -> None:
    columns = dict(np.load(folder(tmp_path) / "events.npz"))
    np.savez(tmp_path / "events.npz", **{name: column[:0] for name, column in columns.items()})
    with pytest.raises(
        ValueError, match=r"events\.npz: no event; give the recording of truth\.csv"
    ):
        labelled(tmp_path)
    columns["t"] = columns["t"] - T0_US
    np.savez(tmp_path / "events.npz", **columns)
    message = r"truth\.csv: row 2: t_us = 5010000: give the clock of events\.npz, 0 to 99000 us"
    with pytest.raises(ValueError, match=message):
        labelled(tmp_path)


# ---- the score ------------------------------------------------------------------------------

CENTRE = (20, 20)


def test_a_perfect_tracker_scores_ones(tmp_path: Path) -> None:
    found = scored(tmp_path, {ms: [(7, *CENTRE)] for ms in (10, 20, 30)})
    assert [found[name] for name in ("hit", "precision", "longest", "mota")] == [1, 1, 1, 1]
    assert found["switches"] == found["error"] == 0
    assert found["events"] == found["processed"] == 100


def test_inside_is_up_to_2_px_beyond_the_edge(tmp_path: Path) -> None:
    found = scored(tmp_path, {10: [(7, 32, 20)], 20: [(7, 20, 27)], 30: [(7, 32.1, 20)]})
    assert found["hit"] == found["precision"] == found["longest"] == 2 / 3
    assert found["mota"] == pytest.approx(1 - 2 / 3)  # a miss and a false cluster
    assert found["error"] == (12 + 7) / 2


def test_the_id_before_is_preferred_to_a_nearer_one(tmp_path: Path) -> None:
    found = scored(tmp_path, {10: [(7, 12, 20)], 20: [(7, 12, 20), (8, *CENTRE)], 30: []})
    assert (found["switches"], found["longest"], found["error"]) == (0, 2 / 3, 8)


def test_a_new_id_after_a_miss_is_a_switch(tmp_path: Path) -> None:
    found = scored(tmp_path, {10: [(7, *CENTRE)], 30: [(8, *CENTRE)]})
    assert (found["switches"], found["longest"], found["hit"]) == (1, 1 / 3, 2 / 3)
    assert found["mota"] == pytest.approx(1 - 2 / 3)


def test_the_assignment_matches_the_most_boxes(tmp_path: Path) -> None:
    """The nearest pair first would leave the second box without a cluster."""
    rows = box(10, id=0) + box(10, id=1, x=20)
    found = scored(tmp_path, {10: [(7, 24, 20), (8, 12, 20)]}, rows=rows)
    assert (found["hit"], found["error"]) == (1, 7)


def test_iou_is_the_overlap_of_the_boxes_that_go_together(tmp_path: Path) -> None:
    """The drawn box is 20 by 10 px around (20, 20)."""

    class Extended(FakeTracker):
        def __init__(self, extents: dict[str, float]) -> None:
            super().__init__(lambda t_us: [])
            fields = {"id": 7.0, "x": 20.0, "y": 20.0, **extents}
            self.told = np.array([tuple(fields.values())], [(name, "f8") for name in fields])

        def clusters_at(self, t_us: int) -> Any:
            return self.told

    scene = labelled(folder(tmp_path))
    half_of_it = {"left": 10.0, "top": 10.0, "width": 10.0, "height": 20.0}  # and as much outside
    assert score(Extended(half_of_it), scene)["iou"] == pytest.approx(100 / 300)
    all_of_it = {"cxx": (10 / 1.75) ** 2, "cyy": (5 / 1.75) ** 2}
    assert score(Extended(all_of_it), scene)["iou"] == pytest.approx(1)
    assert math.isnan(score(Extended({}), scene)["iou"])


def test_an_ignored_zone_excuses_clusters_not_misses(tmp_path: Path) -> None:
    zones = f"50,60,50,60,{T0_US},{T0_US + 20_000}\n"
    extra = {ms: [(7, *CENTRE), (8, 50, 59.9)] for ms in (10, 20, 30)}
    assert scored(tmp_path, extra, zones=zones)["precision"] == 3 / 5  # the zone ends at 20 ms
    over_the_box = f"0,100,0,80,0,{10 * T0_US}\n"
    found = scored(tmp_path, {10: [(7, *CENTRE), (8, 90, 70)]}, zones=over_the_box)
    assert (found["hit"], found["precision"]) == (1 / 3, 1)


def test_precision_is_not_judged_before_an_unlabelled_background(tmp_path: Path) -> None:
    found = scored(tmp_path, {10: [(7, *CENTRE), (8, 90, 70)]}, background="unlabelled")
    assert math.isnan(found["precision"]) and math.isnan(found["mota"])
    assert found["hit"] == 1 / 3


def test_the_tracker_sees_the_events_before_the_labelled_time(tmp_path: Path) -> None:
    scene = labelled(folder(tmp_path))
    tracker = FakeTracker(lambda t_us: [])
    score(tracker, scene)
    ends = [int(package["t"][-1]) - T0_US for package in tracker.packages]
    assert ends == [9_000, 19_000, 29_000, 99_000]


# ---- recordings outside the project ---------------------------------------------------------

#: The published rule on the five recordings: hit and precision, as labelled and measured there.
PUBLISHED_RULE = {
    "atis_traffic": (0.88, 0.28),
    "shapes_clip": (1.00, 0.99),
    "insects_crossing": (0.19, 0.20),
    "cars_davis346": (0.93, 1.00),
    "night_davis346_public": (0.86, 0.54),
}


@pytest.mark.parametrize("name", PUBLISHED_RULE)
def test_labelled_recordings_score_as_their_authors_measured(name: str) -> None:
    scene = labelled(recording("labelled") / name)
    found = score(asap.PublishedClusterTracker(scene.width, scene.height), scene)
    assert (found["hit"], found["precision"]) == pytest.approx(PUBLISHED_RULE[name], abs=0.0051)
