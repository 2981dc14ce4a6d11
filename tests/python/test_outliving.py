"""Files stay and are named however a run ends: by signals, kill -9 or a full disk."""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
import streams
from asap.io.conversion import WRITERS
from children import run_script

WIDTH, HEIGHT = 346, 260
SENSOR = ("--width", str(WIDTH), "--height", str(HEIGHT))
RECORDED = ("raw", "npy", "csv", "es", "aedat4", "npz", "mcap", "h5")
LONG = ("--latency", "1s")
OLD = b"an older file"
ENDS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a recording of 20 s."""
    monkeypatch.chdir(tmp_path)
    np.save("flight.npy", streams.poisson(2e4, 20.0, seed=1))
    return tmp_path


def until(what: Callable[[], Any]) -> Any:
    deadline_s = time.monotonic() + 120
    while not (found := what()):
        assert time.monotonic() < deadline_s
        time.sleep(0.02)
    return found


def begun(*arguments: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", MAIN, *arguments]
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )


MAIN = """
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # a background job ignores it
from asap import cli
sys.exit(cli.main())
"""


def part_of(suffix: str) -> Path | None:
    found = [one for one in Path().glob(f"out.part{suffix}") if one.stat().st_size > 50_000]
    return found[0] if found else None


# ---- signals and kill -9 ----------------------------------------------------------------------


@pytest.mark.parametrize("suffix", ["raw", "npz"])
def test_a_recording_outlives_kill_9(folder: Path, suffix: str) -> None:
    live = ("--software-camera", "flight.npy", *SENSOR, *LONG)
    with begun("run", *live, "--record", f"out.{suffix}") as child:
        part = until(partial(part_of, ".*"))
        child.kill()
    events = asap.load(part)
    source = asap.load("flight.npy")
    source["t"] -= source["t"][0]
    if suffix == "raw":  # EVT3 has its own order within a us
        assert len(events) > 5000 and np.array_equal(events["t"], source["t"][: len(events)])
    else:
        assert len(events) > 1000 and np.array_equal(events, source[: len(events)])


@pytest.mark.parametrize(("number", "group"), [*zip(ENDS, (False, True, True), strict=True)])
def test_signals_end_a_camera_with_its_files(
    folder: Path, number: signal.Signals, group: bool
) -> None:
    live = ("--software-camera", "flight.npy", *SENSOR, *LONG)
    with begun("run", *live, "--record", "out.npz", "--save", "run.npz") as child:
        until(partial(part_of, ".npy"))
        (os.killpg if group else os.kill)(child.pid, number)
        out, err = child.communicate()
    assert child.returncode == 128 + number, err
    assert "received" in out and out.endswith("wrote run.npz\nwrote out.npz\n")
    assert 0 < asap.load_run("run.npz").ledger.received <= len(asap.load("out.npz"))
    assert sorted(os.listdir()) == ["flight.npy", "out.npz", "run.npz"]


@pytest.mark.parametrize("number", ENDS)
def test_signals_end_a_run_of_a_file_with_its_files(folder: Path, number: signal.Signals) -> None:
    files = {"--save": "run.json", "--tracks": "tracks.csv", "--video": "run.gif"}
    options = [word for option in files.items() for word in option]
    Path("mine.py").write_text(READY)
    with begun("run", "flight.npy", *SENSOR, *LONG, "--algorithm", "mine:Ready", *options) as child:
        until(Path("ready").exists)
        child.send_signal(number)
        out, err = child.communicate()
    assert child.returncode == 128 + number, err
    assert "received" in out and all(f"wrote {file}\n" in out for file in files.values())
    assert 0 < asap.load_run("run.json").ledger.received < len(asap.load("flight.npy"))
    assert Path("tracks.csv").read_text().startswith("id,t,x,y")


READY = """
import asap
class Ready(asap.ClusterTracker):
    def process(self, events, **options):
        open("ready", "w").close()
        return super().process(events, **options)
"""


def test_nohup_is_heeded(folder: Path) -> None:
    script = MAIN.replace("from asap", "signal.signal(signal.SIGHUP, signal.SIG_IGN)\nfrom asap")
    script = script.replace("sys.exit(cli", "os.kill(os.getpid(), signal.SIGHUP)\nsys.exit(cli")
    command = [sys.executable, "-c", script, "info", "flight.npy"]
    assert subprocess.run(command, capture_output=True).returncode == 0


# ---- recordings that are not whole ------------------------------------------------------------

RECORD = """
import os, resource
os.chdir({folder!r})
events = np.zeros(200_000, asap.EVENT_DTYPE)
events["t"] = np.arange(200_000) * 5
events["x"] = np.random.default_rng(0).integers(0, 346, 200_000)
camera = asap.SoftwareCamera(events, width=346, height=260, drop={drop})
resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit}))
try:
    with camera:
        camera.record({name!r})
        asap.run(camera, algorithm={algorithm}, latency_ms=1000)
except BaseException as error:
    print(type(error).__name__, error)
else:
    print()
print(camera.recorded)
print(asap.last_run().ledger.received - camera.stats()["not_recorded"])
"""


def record(folder: Path, name: str, **given: Any) -> tuple[str, str, int]:
    how = {"drop": 0.0, "limit": 10**9, "algorithm": "len"} | given
    ended = run_script(RECORD.format(folder=str(folder), name=name, **how))
    assert ended.code == 0, ended.errors
    said, recorded, count = ended.lines
    return said, recorded, int(count)


@pytest.mark.parametrize("suffix", RECORDED)
def test_a_full_disk_keeps_what_was_written_and_counts_it(tmp_path: Path, suffix: str) -> None:
    (tmp_path / f"out.{suffix}").write_bytes(OLD)
    said, recorded, count = record(tmp_path, f"out.{suffix}", limit=150_000)
    assert said.startswith(f"CameraError out.{suffix}: not recorded: ") and recorded in said
    assert len(asap.load(tmp_path / recorded)) == count > 0
    assert (tmp_path / f"out.{suffix}").read_bytes() == OLD
    assert sorted(os.listdir(tmp_path)) == sorted({f"out.{suffix}", recorded})


@pytest.mark.parametrize("suffix", ["raw", "npz"])
def test_a_recording_without_events_replaces_nothing(tmp_path: Path, suffix: str) -> None:
    (tmp_path / f"out.{suffix}").write_bytes(OLD)
    assert record(tmp_path, f"out.{suffix}", drop=1.0)[1:] == ("None", 0)
    assert (tmp_path / f"out.{suffix}").read_bytes() == OLD
    assert os.listdir(tmp_path) == [f"out.{suffix}"]


def test_what_the_algorithm_raises_leaves_a_recording(tmp_path: Path) -> None:
    said, recorded, count = record(tmp_path, "out.npz", algorithm="lambda events: 1 / 0")
    assert said.startswith("ZeroDivisionError") and recorded == "out.npz"
    assert len(asap.load(tmp_path / "out.npz")) >= count > 0
    older = (tmp_path / "out.npz").read_bytes()
    recorded = record(tmp_path, "out.npz", algorithm="lambda events: 1 / 0")[1]
    assert recorded == "out.part.npy" and len(asap.load(tmp_path / recorded)) > 0
    assert (tmp_path / "out.npz").read_bytes() == older


def test_a_part_that_is_there_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "out.part.raw").write_bytes(OLD)
    assert record(tmp_path, "out.raw")[1:] == ("out.raw", 200_000)
    assert (tmp_path / "out.part.raw").read_bytes() == OLD


# ---- every other writer on a full disk --------------------------------------------------------


def limited(limit: int) -> Callable[[], None]:
    return partial(resource.setrlimit, resource.RLIMIT_FSIZE, (limit, limit))


@pytest.mark.parametrize("to", WRITERS)
def test_a_conversion_on_a_full_disk_keeps_the_older_file(folder: Path, to: str) -> None:
    Path("out").write_bytes(OLD)
    named = ["--format", to, *SENSOR]
    command = [sys.executable, "-m", "asap", "convert", "flight.npy", "out", *named]
    done = subprocess.run(command, capture_output=True, text=True, preexec_fn=limited(100_000))
    assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
    assert done.stderr.startswith("asap: error: out: ")
    assert Path("out").read_bytes() == OLD and sorted(os.listdir()) == ["flight.npy", "out"]


def test_results_on_a_full_disk_keep_the_older_files_and_the_run_is_shown(folder: Path) -> None:
    files = {"--save": "run.npz", "--tracks": "t.csv", "--video": "run.gif", "--report": "r.html"}
    for file in files.values():
        Path(file).write_bytes(OLD)
    options = [word for option in files.items() for word in option]
    command = [sys.executable, "-m", "asap", "run", "flight.npy", *SENSOR, "--to", "500ms"]
    done = subprocess.run(
        [*command, *options, "--json"], capture_output=True, text=True, preexec_fn=limited(10)
    )
    assert done.returncode == 2
    assert json.loads(done.stdout)["ledger"]["received"] > 0
    for file in files.values():
        assert f"asap: error: {file}: " in done.stderr
        assert Path(file).read_bytes() == OLD
    assert sorted(os.listdir()) == sorted(["flight.npy", *files.values()])


@pytest.mark.parametrize("name", ["run.avi", "run.mp4"])
def test_a_video_that_cannot_be_written_is_refused_before_the_run(
    folder: Path, call: Callable[..., tuple[int, str, str]], monkeypatch: pytest.MonkeyPatch,
    name: str,
) -> None:  # fmt: skip
    monkeypatch.setenv("PATH", "")
    before = asap.last_run()
    for source in (["flight.npy"], ["--software-camera", "flight.npy"]):
        code, _, err = call("run", *source, *SENSOR, "--video", name)
        assert code == 2 and ".gif" in err
    assert asap.last_run() is before
