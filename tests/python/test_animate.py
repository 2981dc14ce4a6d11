"""Run.animate: a picture to share, of what the run has seen and found."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
import streams
from asap import cli

image = pytest.importorskip("PIL.Image", reason="needs the extra report")

WIDTH, HEIGHT = 346, 260


def moving(duration_s: float = 1.0) -> np.ndarray:
    """ON events of a disc that goes from left to right, at 260 px/s."""
    rng = np.random.default_rng(0)
    t = np.sort(rng.integers(0, int(duration_s * 1e6), int(duration_s * 5e4)))
    x, y = 40 + 260 * t / 1e6 + rng.normal(0, 6, t.size), 130 + rng.normal(0, 6, t.size)
    return streams.make(t, x.astype(int), y.astype(int), p=1)


def watched(events: np.ndarray, **options: Any) -> asap.Run:
    tracks = asap.Tracks(asap.ClusterTracker(WIDTH, HEIGHT))
    return asap.simulate(
        events,
        cost=asap.LinearCost(20, 50),
        algorithm=tracks,
        width=WIDTH,
        height=HEIGHT,
        **options,
    )


def frames_of(path: Path) -> list[np.ndarray]:
    with image.open(path) as film:
        found = []
        for number in range(film.n_frames):
            film.seek(number)
            found.append(np.asarray(film.convert("RGB")).astype(int))
        assert film.info["duration"] == 40 and film.info["loop"] == 0
    return found


def centre_of_red(frame: np.ndarray) -> float:
    red = (frame[..., 0] > 200) & (frame[..., 1] < 140)
    return float(np.nonzero(red)[1].mean()) / frame.shape[1]


def test_events_move_through_the_frames(tmp_path: Path) -> None:
    frames = frames_of(watched(moving()).animate(tmp_path / "run.gif"))
    assert len(frames) == 25  # a second
    places = [centre_of_red(frame) for frame in frames]
    assert np.allclose(places, np.linspace(45, 295, 25) / WIDTH, atol=0.02)


def test_a_cluster_is_drawn_around_its_events(tmp_path: Path) -> None:
    (*_, frame) = frames_of(watched(moving()).animate(tmp_path / "run.gif"))
    picture = frame[:-40]
    drawn = picture.sum(axis=2) > 60  # all but the background
    red = (picture[..., 0] > 100) & (picture[..., 1] < 140)
    columns, inner = np.nonzero(drawn & ~red)[1], np.nonzero(red)[1]
    assert columns.max() > np.quantile(inner, 0.8) and columns.min() < np.quantile(inner, 0.2)


def test_many_events_are_thinned_evenly(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("asap.experiment.tracks._MAX_SEEN", 4000)
    seen = watched(moving()).algorithm.seen
    assert 1500 < len(seen) <= 4000
    counts, _ = np.histogram(seen["t"], 10)
    assert counts.min() > 0.5 * counts.max()


def test_an_mp4_is_ffmpegs_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run = watched(moving(0.2))
    if shutil.which("ffmpeg") is not None:
        assert b"ftyp" in run.animate(tmp_path / "run.mp4").read_bytes()[:12]
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(RuntimeError, match=r"needs the program ffmpeg.*\.gif"):
        run.animate(tmp_path / "other.mp4")
    fake = tmp_path / "ffmpeg"
    count = "import sys; print(len(sys.stdin.buffer.read()), file=open(sys.argv[-1], 'w'))"
    fake.write_text(f"#!{sys.executable}\n{count}\n")
    fake.chmod(0o755)
    sides = frames_of(run.animate(tmp_path / "run.gif"))[0].shape
    pixels = int(run.animate(tmp_path / "told.mp4").read_text())
    assert pixels == 5 * np.prod(sides)
    assert sides[0] % 2 == sides[1] % 2 == 0
    fake.write_text(f"#!{sys.executable}\nimport sys\nsys.exit(3)\n")
    with pytest.raises(RuntimeError, match=r"bad\.mp4.*code 3"):
        run.animate(tmp_path / "bad.mp4")


def test_a_run_without_pictures_names_the_remedy(tmp_path: Path) -> None:
    run = asap.simulate(moving(0.1), cost=asap.LinearCost(20, 50))
    with pytest.raises(ValueError, match=r"asap\.Tracks"):
        run.animate(tmp_path / "run.gif")
    with pytest.raises(ValueError, match=r"\.gif or \.mp4"):
        watched(moving(0.1)).animate(tmp_path / "run.avi")


def test_video_on_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    np.save(tmp_path / "flight.npy", moving(0.2))
    size = ("--width", str(WIDTH), "--height", str(HEIGHT))
    files = str(tmp_path / "flight.npy"), "--video", str(tmp_path / "run.gif")
    assert cli.main(["run", *files, *size, "--cost", "20us+50ns"]) == 0
    assert "run.gif" in capsys.readouterr().out
    assert len(frames_of(tmp_path / "run.gif")) == 5
