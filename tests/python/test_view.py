"""view: what a run looks like in Rerun; whatever becomes of the viewer, the run does not notice."""

from __future__ import annotations

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import asap
import streams
from asap import cli, viewer
from asap.viewer.rerun import PORT

pytest.importorskip("rerun", reason="needs the extra view")

SIZE = (346, 260)
LONG_MS = 1000.0  # a bound that a busy machine keeps


@pytest.fixture(autouse=True)
def patience(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(viewer, "_PATIENCE_S", 60.0)  # on a busy machine


@pytest.fixture(autouse=True)
def nothing_is_left() -> Iterator[None]:
    threads = set(threading.enumerate())
    yield
    assert set(threading.enumerate()) <= threads


def disc(duration_s: float = 1.0, rate_hz: float = 5e4) -> np.ndarray:
    """A disc of events that crosses the sensor, half of them ON."""
    rng = np.random.default_rng(0)
    count = int(duration_s * rate_hz)
    t = np.sort(rng.integers(0, int(duration_s * 1e6), count))
    x, y = 60 + 200 * t / 1e6 + rng.normal(0, 8, count), 130 + rng.normal(0, 8, count)
    return streams.make(t, x.astype(int), y.astype(int))


def shown_in(path: Path) -> dict[str, int]:
    """The entities of a file, and how many chunks each has."""
    import rerun_cli

    rerun = Path(rerun_cli.__file__).parent / "rerun"
    text = subprocess.run(
        [rerun, "rrd", "print", path],
        check=True,
        capture_output=True,
        text=True,
        env=os.environ | {"CI": "1"},
    ).stdout
    return {
        name: text.count(name)
        for name in (
            "/scene/events",
            "/scene/found",
            "/scene/tracks",
            "/loop/latency/worst",
            "/loop/gamma/gamma",
        )
    }


def test_a_live_run_is_shown(tmp_path: Path) -> None:
    tracker = asap.ClusterTracker(*SIZE)
    with asap.SoftwareCamera(disc(), width=SIZE[0], height=SIZE[1]) as camera:
        pipeline = asap.Pipeline(tracker, camera=camera, latency_ms=LONG_MS)
        with pipeline, asap.view(pipeline, tmp_path / "run.rrd"):
            pipeline.run()
    assert all(shown_in(tmp_path / "run.rrd").values())


def test_a_loop_is_shown_with_the_clusters_that_it_makes(tmp_path: Path) -> None:
    tracker = asap.ClusterTracker(*SIZE)
    with asap.SoftwareCamera(disc(), width=SIZE[0], height=SIZE[1]) as camera:
        pipeline = asap.Pipeline(camera=camera, latency_ms=LONG_MS)
        with pipeline, asap.view(pipeline, tmp_path / "run.rrd", algorithm=tracker):
            for package in pipeline:
                tracker.process(package.events)
    assert all(shown_in(tmp_path / "run.rrd").values())


def test_a_finished_run_is_shown(tmp_path: Path) -> None:
    tracks = asap.Tracks(asap.ClusterTracker(*SIZE))
    run = asap.simulate(
        disc(), cost=asap.LinearCost(20, 50), algorithm=tracks, width=SIZE[0], height=SIZE[1]
    )
    asap.view(run, tmp_path / "run.rrd")
    assert all(shown_in(tmp_path / "run.rrd").values())


def test_view_of_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    np.save(tmp_path / "flight.npy", disc(0.5))
    size = ("--width", str(SIZE[0]), "--height", str(SIZE[1]))
    files = str(tmp_path / "flight.npy"), "--target", str(tmp_path / "run.rrd")
    assert cli.main(["view", *files, *size, "--latency", "1s"]) == 0
    assert capsys.readouterr().out.endswith(f"wrote {tmp_path / 'run.rrd'}\n")
    assert all(shown_in(tmp_path / "run.rrd").values())


# ---- a viewer that is no help


def test_the_run_comes_first(tmp_path: Path) -> None:
    with viewer.View(tmp_path / "run.rrd") as shown:
        deadline_s = time.monotonic() + 60
        while os.getpriority(os.PRIO_PROCESS, shown._process.pid) < 19:
            assert time.monotonic() < deadline_s
            time.sleep(0.01)


def test_a_file_is_waited_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(viewer, "_PATIENCE_S", 1e-3)
    run = asap.simulate(disc(0.5), cost=asap.LinearCost(100, 300), width=SIZE[0], height=SIZE[1])
    asap.view(run, tmp_path / "run.rrd")
    assert any(shown_in(tmp_path / "run.rrd").values())


def test_a_file_that_is_not_written_is_told(tmp_path: Path) -> None:
    with (
        pytest.raises(RuntimeError, match=r"run\.rrd: not written"),
        viewer.View(tmp_path / "run.rrd") as shown,
    ):
        shown._process.kill()


@pytest.mark.parametrize("fault", [signal.SIGSTOP, signal.SIGKILL])
def test_a_viewer_that_stalls_or_dies_is_not_waited_for(
    monkeypatch: pytest.MonkeyPatch, fault: signal.Signals
) -> None:
    monkeypatch.setattr(viewer, "_PATIENCE_S", 0.2)
    events = disc(1.0, rate_hz=1e6)  # more than a pipe holds
    with asap.SoftwareCamera(events, width=SIZE[0], height=SIZE[1]) as camera:
        tracker = asap.ClusterTracker(*SIZE)
        pipeline = asap.Pipeline(tracker, camera=camera, latency_ms=LONG_MS)
        with pipeline, asap.view(pipeline, "connect") as shown:
            os.kill(shown._process.pid, fault)
            pipeline.run()
            assert pipeline.ledger.balanced and pipeline.ledger.pending == 0
            assert pipeline.ledger.overflow == 0 < pipeline.ledger.delivered
    assert shown._process.returncode is not None


def test_a_program_may_end_without_closing_it(tmp_path: Path) -> None:
    script = f"""if True:
        import numpy as np, asap
        pipeline = asap.Pipeline(print, width=10, height=10)
        asap.view(pipeline, {str(tmp_path / "run.rrd")!r})
        """
    subprocess.run([sys.executable, "-c", script], check=True, timeout=60)


# ---- the network

SHIM = r"""
#include <arpa/inet.h>
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <netdb.h>

static void refuse(const char* what) {
  FILE* file = fopen(getenv("REFUSED"), "a");
  fprintf(file, "%s\n", what);
  fclose(file);
}
int connect(int fd, const struct sockaddr* address, socklen_t size) {
  static int (*real)(int, const struct sockaddr*, socklen_t);
  if (!real) real = (int (*)(int, const struct sockaddr*, socklen_t))dlsym(RTLD_NEXT, "connect");
  char text[64] = "not IPv4";
  if (address->sa_family == AF_INET) {
    inet_ntop(AF_INET, &((const struct sockaddr_in*)address)->sin_addr, text, sizeof text);
  }
  if (address->sa_family != AF_UNIX && strncmp(text, "127.", 4) != 0) {
    refuse(text);
    return -1;
  }
  return real(fd, address, size);
}
int bind(int fd, const struct sockaddr* address, socklen_t size) {
  static int (*real)(int, const struct sockaddr*, socklen_t);
  if (!real) real = (int (*)(int, const struct sockaddr*, socklen_t))dlsym(RTLD_NEXT, "bind");
  char text[64] = "127.";
  if (address->sa_family == AF_INET) {
    inet_ntop(AF_INET, &((const struct sockaddr_in*)address)->sin_addr, text, sizeof text);
  }
  if (address->sa_family == AF_INET6) strcpy(text, "IPv6");
  if (strncmp(text, "127.", 4) != 0) refuse(text);
  return real(fd, address, size);
}
int getaddrinfo(const char* name, const char* service, const struct addrinfo* hints,
                struct addrinfo** found) {
  refuse(name ? name : "?");
  return EAI_FAIL;
}
"""


@pytest.fixture
def guarded(tmp_path: Path) -> dict[str, str]:
    """An environment in which every address but the loopback is refused, and noted in a file."""
    if (compiler := shutil.which("cc")) is None:
        pytest.skip("needs a C compiler for the guard")
    (tmp_path / "guard.c").write_text(SHIM)
    guard = tmp_path / "guard.so"
    command = [
        compiler,
        "-shared",
        "-fPIC",
        "-D_GNU_SOURCE",
        "-o",
        guard,
        tmp_path / "guard.c",
        "-ldl",
    ]
    subprocess.run(command, check=True)
    refused = tmp_path / "refused"
    refused.touch()
    return os.environ | {"LD_PRELOAD": str(guard), "REFUSED": str(refused), "HOME": str(tmp_path)}


def is_open() -> bool:
    with socket.socket() as listener:
        return listener.connect_ex(("127.0.0.1", PORT)) == 0


def view(folder: Path, target: str, environment: dict[str, str]) -> None:
    np.save(folder / "flight.npy", disc(0.5))
    command = f"view flight.npy --target {target} --width 346 --height 260 --latency 1s"
    run = [sys.executable, "-m", "asap", *command.split()]
    subprocess.run(run, check=True, cwd=folder, env=environment, timeout=100)


def test_the_guard_sees_an_address(tmp_path: Path, guarded: dict[str, str]) -> None:
    script = "import socket; socket.create_connection(('192.0.2.1', 80), 1)"
    subprocess.run([sys.executable, "-c", script], env=guarded, stderr=subprocess.DEVNULL)
    assert (tmp_path / "refused").read_text()


def test_a_file_is_written_without_the_network(tmp_path: Path, guarded: dict[str, str]) -> None:
    view(tmp_path, "run.rrd", guarded)
    assert (tmp_path / "refused").read_text() == ""
    assert sorted(path.name for path in tmp_path.iterdir() if path.is_dir()) == []


def test_a_viewer_is_talked_to_on_the_loopback_alone(
    tmp_path: Path, guarded: dict[str, str]
) -> None:
    import rerun_cli

    if is_open():
        pytest.skip("a viewer is open on this machine")
    rerun = Path(rerun_cli.__file__).parent / "rerun"
    address = f"--serve-grpc --bind 127.0.0.1 --port {PORT} --save got.rrd".split()
    server = subprocess.Popen([rerun, *address], cwd=tmp_path, env=guarded | {"CI": "1"})
    try:
        while not is_open():
            time.sleep(0.05)
        view(tmp_path, "connect", guarded)
    finally:
        server.terminate()
        server.wait()
    assert (tmp_path / "refused").read_text() == ""


def test_the_window_is_told_to_keep_to_itself(tmp_path: Path, guarded: dict[str, str]) -> None:
    if is_open():
        pytest.skip("a viewer is open on this machine")
    fake = tmp_path / "fake" / "rerun_cli"
    fake.mkdir(parents=True)
    (fake / "__init__.py").touch()
    (fake / "__main__.py").write_text(
        "import json, os, sys; print(json.dumps([sys.argv[1:], dict(os.environ)]), "
        f"file=open({str(tmp_path / 'told')!r}, 'w'))"
    )
    view(tmp_path, "spawn", guarded | {"PYTHONPATH": str(fake.parent), "DISPLAY": ":77"})
    arguments, environment = json.loads((tmp_path / "told").read_text())
    assert arguments[arguments.index("--bind") + 1] == "127.0.0.1"
    assert "--hide-welcome-screen" in arguments  # which fetches examples
    assert environment["CI"] == "1"  # no usage statistics
    assert environment["HTTPS_PROXY"] == "http://127.0.0.1:9"  # no look for a newer version
    assert (tmp_path / "refused").read_text() == ""


# ---- wrong use


def test_wrong_targets_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pipeline = asap.Pipeline(print)
    with pytest.raises(ValueError, match=r"spawn.*connect.*rrd"):
        asap.view(pipeline, tmp_path / "run.mp4")
    with pytest.raises(TypeError, match="Pipeline or a run"):
        asap.view(tmp_path / "flight.npy")
    if sys.platform == "linux":
        for name in ("DISPLAY", "WAYLAND_DISPLAY"):
            monkeypatch.delenv(name, raising=False)
        with pytest.raises(RuntimeError, match=r"no screen.*run\.rrd.*ssh"):
            asap.view(pipeline)
