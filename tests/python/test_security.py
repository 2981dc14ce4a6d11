"""What ASAP must never do: talk to a network, or run code that a recording brings along."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import numpy as np
import pytest

import asap
from asap.io import CorruptFile
from house import run

# Any use of a socket ends the process, from whatever library; sockets of native code are looked for
# at the end.
GUARDED = """if True:
    import os, sys

    def guard(event, arguments):
        if event.startswith("socket."):
            os.write(2, f"{event} {arguments}".encode())
            os._exit(99)

    sys.addaudithook(guard)
    from asap.cli import main

    code = main(sys.argv[1:])
    links = [f"/proc/self/fd/{fd}" for fd in os.listdir("/proc/self/fd")]
    sockets = [os.readlink(link) for link in links if os.path.lexists(link)]
    sockets = [name for name in sockets if name.startswith("socket:")]
    sys.exit(code or (98 if sockets else 0))
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("security")
    events = asap.synthetic.FlightOverChairs(duration_s=0.05).events()
    np.save(folder / "flight.npy", events)
    asap.simulate(events, cost=asap.LinearCost(20, 150)).save(folder / "run.json")
    return folder


@pytest.mark.parametrize(
    "command",
    [
        "info flight.npy --json",
        "check flight.npy --report check.html",
        "run flight.npy --width 346 --height 260 --json",
        "run flight.npy --cost 100us+300ns --report run.html",
        "report run.json",
        "demo --quick --out demo",
    ],
)
def test_no_verb_opens_a_socket(command: str, folder: Path) -> None:
    run([sys.executable, "-c", GUARDED, *command.split()], cwd=folder)


def test_the_guard_sees_a_socket(folder: Path) -> None:
    program = GUARDED.replace("main(sys.argv[1:])", "__import__('socket').socket()")
    with pytest.raises(AssertionError, match="exit code 99"):
        run([sys.executable, "-c", program], cwd=folder)


class Evil:
    """Unpickling it makes a file."""

    def __init__(self, trace: Path) -> None:
        self.trace = trace

    def __reduce__(self) -> tuple[object, tuple[object, ...]]:
        return os.mkdir, (str(self.trace),)


@pytest.mark.parametrize("kind", ["npy", "npz", "npz of columns"])
def test_a_pickle_in_a_recording_is_refused(kind: str, tmp_path: Path) -> None:
    trace = tmp_path / "trace"
    evil = np.array([Evil(trace)], object)
    path = tmp_path / f"evil.{kind[:3]}"
    if kind == "npy":
        np.save(path, evil)
    elif kind == "npz":
        np.savez(path, events=evil)
    else:
        np.savez(path, x=evil, y=evil, t=evil, p=evil)
    with pytest.raises(CorruptFile, match=f"evil.{kind[:3]}.*pickle"):
        asap.load(path)
    assert not trace.exists()


def test_a_saved_run_is_plain_json(folder: Path) -> None:
    document = json.loads((folder / "run.json").read_text())
    assert document["schema_version"] == 1
