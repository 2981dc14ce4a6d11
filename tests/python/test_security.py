"""What ASAP must never do: talk to a network, or run code that a recording brings along."""

from __future__ import annotations

import os
import struct
import sys
import zipfile
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

    codes = [main(command.split()) for command in sys.argv[1:]]
    links = [f"/proc/self/fd/{fd}" for fd in os.listdir("/proc/self/fd")]
    sockets = [os.readlink(link) for link in links if os.path.lexists(link)]
    sockets = [name for name in sockets if name.startswith("socket:")]
    sys.exit(max(codes) or (98 if sockets else 0))
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("security")
    events = asap.synthetic.FlightOverChairs(duration_s=0.05).events()
    np.save(folder / "flight.npy", events)
    asap.simulate(events, cost=asap.LinearCost(20, 150)).save(folder / "run.npz")
    return folder


VERBS = (
    "info flight.npy --json",
    "check flight.npy",
    "run flight.npy --width 346 --height 260 --json",
    "run flight.npy --cost 100us+300ns --save again.npz",
    "compare flight.npy --cost 100us+300ns",
    "report run.npz -o run.html",
)


def test_no_verb_opens_a_socket(folder: Path) -> None:
    run([sys.executable, "-c", GUARDED, *VERBS], cwd=folder)


@pytest.mark.full
def test_the_demo_opens_no_socket(folder: Path) -> None:
    run([sys.executable, "-c", GUARDED, "demo --quick --out demo"], cwd=folder)


# ---- pickles --------------------------------------------------------------------------------


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


def test_a_run_imports_no_module_that_unpickles(folder: Path) -> None:
    """NumPy brings pickle itself; none of ours is what calls it."""
    program = """if True:
        import sys
        import pickle

        def never(*_, **__):
            raise AssertionError("unpickled")

        pickle.load = pickle.loads = pickle.Unpickler = never
        import asap

        asap.simulate(asap.read(sys.argv[1]), cost=asap.LinearCost(20, 150)).save("again.npz")
        asap.load_run("again.npz")
    """
    run([sys.executable, "-c", program, "flight.npy"], cwd=folder)


# ---- sizes ----------------------------------------------------------------------------------


def npz_that_says(folder: Path, size: int) -> Path:
    """A real archive of zeros whose directory states this size for its one member."""
    path = folder / "bomb.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("t.npy", bytes(100_000))
    content = bytearray(path.read_bytes())
    directory = content.rindex(b"PK\x01\x02")
    content[directory + 24 : directory + 28] = struct.pack("<I", size)
    path.write_bytes(bytes(content))
    return path


def test_an_archive_beyond_the_ratio_of_1000_is_refused_unopened(tmp_path: Path) -> None:
    with pytest.raises(CorruptFile, match=f"decompresses to {2**31} bytes, more than 1000 times"):
        asap.load(npz_that_says(tmp_path, 2**31))


def test_an_archive_that_understates_its_sizes_is_not_unpacked_further(tmp_path: Path) -> None:
    with pytest.raises(CorruptFile):
        asap.load(npz_that_says(tmp_path, 1000))
