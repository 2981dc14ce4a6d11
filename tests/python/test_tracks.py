"""What a tracker found leaves the process: asap.Tracks, asap run --tracks, the picture."""

import csv

import numpy as np
import pytest

import asap
import streams
from asap import cli

COST = asap.LinearCost(10, 50)
CLUSTER = np.dtype([("id", "<i8"), ("x", "<f4"), ("y", "<f4")])


class Centre:
    """One cluster: the mean of a package."""

    def __init__(self, width=346, height=260, step=1):
        self.step = step
        self.clusters = np.empty(0, CLUSTER)

    def process(self, events):
        centre = (self.step, events["x"].mean(), events["y"].mean())
        self.clusters = np.array([centre], CLUSTER)


def rows_of(path):
    with path.open() as file:
        return list(csv.DictReader(file))


@pytest.fixture
def recording(tmp_path):
    path = tmp_path / "events.npz"
    asap.convert(asap.synthetic.FlightOverChairs(duration_s=0.1), path)
    return path


def test_every_package_leaves_a_row_of_each_cluster():
    events = streams.make(10**15 + np.arange(0, 50_000, 10), x=7, y=9)
    tracks = asap.Tracks(Centre())
    run = asap.simulate(events, cost=COST, algorithm=tracks)
    found = tracks.tracks
    assert found.dtype.names == ("id", "t", "x", "y")  # what the clusters have
    assert found["t"].tolist() == run.packages["t_last"].tolist()
    assert set(found["id"]) == {1} and set(found["x"]) == {7} and set(found["y"]) == {9}


def test_rows_come_in_steps_of_time():
    events = streams.make(np.arange(0, 50_000, 10), x=7, y=9)
    tracks = asap.Tracks(Centre(), every_ms=10)
    asap.simulate(events, cost=COST, algorithm=tracks)
    assert (tracks.tracks["t"] // 10_000).tolist() == [0, 1, 2, 3, 4]


def test_a_tracker_finds_the_same_with_and_without_notes():
    scene = asap.synthetic.FlightOverChairs(duration_s=0.2)
    plain, noted = (asap.ClusterTracker(scene.width, scene.height) for _ in range(2))
    asap.simulate(scene, cost=COST, algorithm=plain)
    tracks = asap.Tracks(noted)
    run = asap.simulate(scene, cost=COST, algorithm=tracks)
    assert noted.objects.tobytes() == plain.objects.tobytes()
    assert tracks.objects["id"].tolist() == noted.objects["id"].tolist()
    last = tracks.tracks[tracks.tracks["t"] == run.packages["t_last"][-1]]
    assert last["x"].tolist() == plain.objects["x"].tolist()
    assert run.summary()["algorithm"]["name"] == "clusters"
    tracks.reset()
    assert tracks.tracks.size == 0 and noted.objects.size == 0


@pytest.mark.parametrize("given", [None, len, asap.EFast(10, 10)])
def test_an_algorithm_without_clusters_is_refused(given):
    with pytest.raises(
        TypeError, match=r"^algorithm = .*process\(events\) and objects or clusters"
    ):
        asap.Tracks(given)


def test_a_tracker_for_a_smaller_sensor_is_refused():
    scene = asap.synthetic.FlightOverChairs(duration_s=0.01)
    with pytest.raises(ValueError, match="algorithm = ClusterTracker for 100 x 100 px"):
        asap.run(scene, algorithm=asap.Tracks(asap.ClusterTracker(100, 100)))


def test_the_command_writes_tracks_with_parameters_and_a_filter(recording, tmp_path):
    out, page = tmp_path / "tracks.csv", tmp_path / "run.html"
    command = (
        f"run {recording} --cost 10us+50ns --tracks {out} --every 10ms "
        "--algorithm published_clusters:window=500 --before background:window_us=2000"
    )
    pytest.importorskip("matplotlib")
    assert cli.main([*command.split(), "--report", str(page)]) == 0
    rows = rows_of(out)
    assert list(rows[0]) == ["id", "t", "x", "y", "vx", "vy", "size"]
    assert len({row["t"] for row in rows}) <= 11
    run = asap.last_run()
    assert run.algorithm.parameters["window"] == 500 and run.ledger.filtered > 0
    assert "<template data-tracks>" in page.read_text()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ("--every 10ms", "--every: needs --tracks"),
        ("--tracks out.txt", "a name that ends in .csv"),
        ("--tracks out.csv --algorithm e_fast", "process(events) and objects or clusters"),
        ("--algorithm clusters:window_us=5", "window_us = 5"),
        ("--before e_fast", "give one of background, hot_pixels"),
    ],
)
def test_what_cannot_be_is_wrong_use(options, words, recording, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["run", str(recording), "--cost", "1us+1ns", *options.split()]) == 2
    assert words in capsys.readouterr().err


def test_parameters_go_to_a_class_of_ones_own(recording, tmp_path, monkeypatch):
    out = tmp_path / "tracks.csv"
    own = ["--algorithm", f"{__name__}:Centre:step=5", "--tracks", str(out)]
    assert cli.main(["run", str(recording), "--cost", "1us+1ns", *own]) == 0
    assert {row["id"] for row in rows_of(out)} == {"5"}


def test_help_lists_algorithms_with_their_parameters(capsys):
    assert cli.main(["run", "--help", "algorithm"]) == 0
    shown = capsys.readouterr().out
    assert "background  (asap.BackgroundActivityFilter)\n    window_us=5000" in shown
    assert cli.main(["run", "--help"]) == 0
    assert "usage: asap run" in capsys.readouterr().out
