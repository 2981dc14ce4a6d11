"""SoftwareCamera: a process that plays a recording as a driver would, and dies with its user."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
import streams
from asap.cli import main
from children import run_script

SENSOR = {"width": 20, "height": 10}
LONG_MS = 1000.0  # a bound that a busy machine keeps


def stream(count: int = 2000, step_us: int = 50) -> Any:
    return streams.make(np.arange(count) * step_us, x=3, y=4)


def players() -> list[int]:
    """The processes that cameras of this one have begun and not yet seen off."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            parent = int((folder / "stat").read_text().rpartition(")")[2].split()[1])
            plays = b"asap.camera.playback" in (folder / "cmdline").read_bytes()
        except OSError:  # it has ended meanwhile
            continue
        if parent == os.getpid() and plays:
            found.append(int(folder.name))
    return found


@pytest.fixture(autouse=True)
def nothing_is_left() -> Iterator[None]:
    threads, files = set(threading.enumerate()), os.listdir("/proc/self/fd")
    yield
    assert set(threading.enumerate()) <= threads
    assert len(os.listdir("/proc/self/fd")) <= len(files)
    assert not players()


def test_it_plays_what_is_in_the_recording_from_0_on(tmp_path: Path) -> None:
    later = stream()
    later["t"] += 1_589_163_147_368_868
    np.save(tmp_path / "few.npy", later)
    for source in (stream(), tmp_path / "few.npy", iter([later[:700], later[700:]])):
        with asap.SoftwareCamera(source, **SENSOR) as camera:
            packets = list(camera)
        assert np.array_equal(np.concatenate([packet.events for packet in packets]), stream())
        assert camera.stats()["ended"] == "recording over"
        assert camera.stats()["packets"] == len(packets)


def test_no_packet_comes_before_its_last_event_has_happened() -> None:
    with asap.SoftwareCamera(stream(count=400), **SENSOR) as camera:
        before_s = time.monotonic()
        for packet in camera:
            full_us = (packet.events["t"][-1] // 1000 + 1) * 1000
            assert packet.arrival_time - before_s > full_us * 1e-6 - 0.002 * len(packet.events) / 20


@pytest.mark.parametrize("speed", [0.5, 4.0])
def test_speed_divides_the_stamps(speed: float) -> None:
    with asap.SoftwareCamera(stream(count=100), speed=speed, **SENSOR) as camera:
        events = np.concatenate([packet.events for packet in camera])
    assert np.array_equal(events["t"], np.rint(stream(count=100)["t"] / speed))


def test_a_loop_goes_on_in_time() -> None:
    with asap.SoftwareCamera(stream(count=100), loop=True, **SENSOR) as camera:
        seen = 0
        for packet in camera:
            assert (packet.events["t"] == (np.arange(len(packet.events)) + seen) * 50).all()
            seen += len(packet.events)
            if seen >= 350:
                break


def test_what_it_drops_is_counted() -> None:
    with (
        asap.SoftwareCamera(stream(), drop=0.3, **SENSOR) as camera,
        asap.Pipeline(camera=camera, latency_ms=LONG_MS) as pipeline,
    ):
        for _ in pipeline:
            pass
    lost = pipeline.stats()["upstream_lost"]
    assert pipeline.ledger.received + 20 * lost["packets"] == 2000
    assert 0 < lost["marks"] <= lost["packets"] < 60


@pytest.mark.parametrize("drop", [0.0, 1.0])
def test_what_is_not_read_in_time_is_lost_and_counted(drop: float) -> None:
    events = stream(count=200_000, step_us=2)
    with asap.SoftwareCamera(events, drop=drop, packet_us=50, **SENSOR) as camera:
        packets = iter(camera)
        received = [next(packets)]
        time.sleep(1)  # the pipe holds 1 MiB, the camera 1000 packets of 25 events
        received += packets
    lost = sum(packet.lost_packets for packet in received)
    assert sum(len(packet.events) for packet in received) + 25 * lost == 200_000
    assert lost > 1000


@pytest.mark.parametrize(
    ("source", "given", "words"),
    [
        (stream(), {}, "width and height"),
        (stream(), {"width": 20}, "width and height"),
        (stream()[:0], SENSOR, "no events"),
        (stream()[::-1], SENSOR, r"t = .* \(event 1\): goes back"),
        (iter([stream(), stream()]), SENSOR, r"t = 0 \(event 2000\): goes back"),
        (stream(), {"speed": 0, **SENSOR}, "speed = 0"),
        (stream(), {"drop": 2, **SENSOR}, "drop = 2"),
        (stream(), {"packet_us": 0, **SENSOR}, "packet_us = 0"),
    ],
)
def test_bad_arguments(source: Any, given: Any, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        asap.SoftwareCamera(source, **given)


def test_what_it_leaves_out_of_a_file_is_told(tmp_path: Path) -> None:
    events = stream(count=100)
    events["t"][50] = 0
    np.save(tmp_path / "back.npy", events)
    with pytest.warns(UserWarning, match=r"SoftwareCamera .* rejected: .*1 "):
        camera = asap.SoftwareCamera(tmp_path / "back.npy", **SENSOR)
    with camera:
        assert sum(len(packet.events) for packet in camera) == 99


# ---- unplanned ends -------------------------------------------------------------------------


def test_its_process_is_killed() -> None:
    with asap.SoftwareCamera(stream(), loop=True, **SENSOR) as camera:
        pipeline = asap.Pipeline(camera=camera, latency_ms=LONG_MS)
        killed = pytest.raises(asap.CameraError, match=r"SoftwareCamera .*has ended \(-9\)")
        with pipeline, killed:
            for package in pipeline:
                if package.index == 3:
                    camera.device.process.send_signal(signal.SIGKILL)
        assert camera.stats()["ended"] == "failed"
    assert pipeline.ledger.received == pipeline.ledger.delivered > 0


def test_its_process_stands_still() -> None:
    """Also in the middle of a packet; closing does not wait for the rest."""
    with (
        asap.SoftwareCamera(stream(), loop=True, **SENSOR) as camera,
        pytest.warns(RuntimeWarning, match="no event came"),
    ):
        camera.device.process.send_signal(signal.SIGSTOP)
        asap.run(camera, algorithm=len, duration_s=0.3)


def test_its_process_cannot_begin(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.executable", "/bin/false")
    with pytest.raises(RuntimeError, match=r"its process has ended \(1\)"):
        asap.SoftwareCamera(stream(count=100_000), **SENSOR)


SCRIPT = """
os.setpgrp()  # Ctrl-C in a terminal goes to all of a group
events = np.zeros(2000, asap.EVENT_DTYPE)
events["t"] = np.arange(2000) * 50
camera = asap.SoftwareCamera(events, loop=True, width=20, height=10)
print(camera.device.process.pid, flush=True)
def consume():
    with camera, asap.Pipeline(camera=camera, latency_ms=1000) as pipeline:
        global ledger
        try:
            for package in pipeline:
                if package.index == 3:
                    {}
        finally:
            ledger = pipeline.ledger
try:
    consume()
except KeyboardInterrupt:
    print("interrupted", ledger.balanced, ledger.received > 0, threading.active_count())
"""


def has_ended(pid: int) -> bool:
    for _ in range(300):
        try:
            state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
        except FileNotFoundError:
            return True
        if state == "Z":
            return True
        time.sleep(0.1)
    return False


@pytest.mark.parametrize(
    ("end", "code", "said"),
    [
        ("os.kill(os.getpid(), signal.SIGKILL)", -9, []),
        ("os.killpg(0, signal.SIGINT)", 0, ["interrupted True True 1"]),
        ("os._exit(3)", 3, []),
    ],
)
def test_the_users_process_ends(end: str, code: int, said: list[str]) -> None:
    ended = run_script(SCRIPT.format(end))
    assert (ended.code, ended.lines[1:], ended.errors) == (code, said, "")
    assert has_ended(int(ended.lines[0]))


@pytest.mark.parametrize("drop", [0.0, 1.0])  # the latter never writes
def test_a_camera_that_is_never_read_ends_with_its_user(drop: float) -> None:
    head, _, _ = SCRIPT.partition("def consume")
    ended = run_script(head.replace("loop=True", f"loop=True, drop={drop}") + "os._exit(0)")
    assert has_ended(int(ended.lines[0]))
    assert ended.errors == ""


# ---- the command ----------------------------------------------------------------------------


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    np.savez(tmp_path / "few.npz", **{name: stream()[name] for name in "txyp"}, **SENSOR)
    recorded = tmp_path / "copy.npy"
    command = ["run", "--software-camera", str(tmp_path / "few.npz"), "--latency", "1s"]
    assert main([*command, "--record", str(recorded)]) == 0
    assert "2,000 events" in capsys.readouterr().out
    assert np.array_equal(asap.load(recorded), stream())
    assert main(["run", "--software-camera", str(tmp_path / "none.npz")]) == 3
    assert main([*command, "--cost", "1us+1ns"]) == 2
    kept = (tmp_path / "few.npz").read_bytes()
    assert main([*command, "--record", str(tmp_path / "few.npz")]) == 2
    assert (tmp_path / "few.npz").read_bytes() == kept
    assert main(["run", "--camera", "--from", "1s"]) == 2


# ---- long -----------------------------------------------------------------------------------


class Noting(asap.Pipeline):
    """Knows the stamp of the last event that was pushed."""

    last_us = -1

    def push(self, events: Any, arrival_time: float | None = None) -> None:
        super().push(events, arrival_time)
        self.last_us = int(events["t"][-1])


@pytest.mark.full
def test_ten_million_events_per_second_for_a_minute() -> None:
    """Every event is accounted for. What the machine makes of the pace is printed."""
    events = streams.make(np.arange(2_000_000) // 10, x=3, y=4)
    with asap.SoftwareCamera(events, loop=True, **SENSOR) as camera:
        pipeline = Noting(camera=camera, latency_ms=10)
        end = threading.Timer(60, camera._release)
        with pipeline:
            end.start()
            for package in pipeline:
                package.events["x"].sum()
        end.join()
    lost = pipeline.stats()["upstream_lost"]
    print(pipeline.stats())
    assert pipeline.ledger.balanced
    assert pipeline.ledger.received + 10_000 * lost["packets"] == 10 * (pipeline.last_us + 1)
