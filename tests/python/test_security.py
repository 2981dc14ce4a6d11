"""What ASAP must never do: talk to a network, or run code that a recording brings along."""

from __future__ import annotations

import contextlib
import os
import re
import struct
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import numpy as np
import pytest

import asap
from asap.io import CorruptFile
from house import name_of, run, sources

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


def test_the_guard_sees_a_socket(folder: Path) -> None:
    program = GUARDED.replace("main(command.split())", "__import__('socket').socket()")
    with pytest.raises(AssertionError, match="exit code 99"):
        run([sys.executable, "-c", program, *VERBS], cwd=folder)


# ---- listeners ------------------------------------------------------------------------------

# A second view, from outside: what the kernel knows of this network, looked at while a verb works.
LISTENERS = ("tcp", "tcp6", "udp", "udp6")


def listeners() -> set[tuple[str, str, str]]:
    """Protocol, address and inode of every socket that waits for others."""
    found = set()
    for protocol in LISTENERS:
        for line in Path(f"/proc/net/{protocol}").read_text().splitlines()[1:]:
            _, local, _, state, *rest = line.split()
            if protocol.startswith("udp") or state == "0A":
                found.add((protocol, local, rest[5]))
    return found


def sockets_of(process: int) -> set[str]:
    """Inodes of the sockets that the process holds."""
    found = set()
    for link in Path(f"/proc/{process}/fd").glob("*"):
        with contextlib.suppress(OSError):
            if (name := os.readlink(link)).startswith("socket:"):
                found.add(name[8:-1])
    return found


def watched(program: list[str], cwd: Path) -> tuple[int, set[str], set[tuple[str, str, str]]]:
    """Exit code, sockets ever held, and listeners that came up, of a process and while it ran.

    Its standard input ends when a listener has been seen.
    """
    before, held, new = listeners(), set(), set()
    with subprocess.Popen(
        program, cwd=cwd, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL
    ) as process:
        while process.poll() is None:
            held |= sockets_of(process.pid)
            new |= {one for one in listeners() - before if one[2] in held}
            if new:
                process.stdin.close()
            time.sleep(0.02)
    return process.returncode, held, new


@pytest.mark.skipif(not Path("/proc/net/tcp").is_file(), reason="no /proc/net")
@pytest.mark.full
@pytest.mark.parametrize("command", VERBS)
def test_no_verb_listens(command: str, folder: Path) -> None:
    code, held, new = watched([sys.executable, "-m", "asap", *command.split()], folder)
    assert code == 0
    assert not held
    assert not new


LISTENS = """if True:
    import select, socket, sys
    kind = getattr(socket, sys.argv[1])
    one = socket.socket(socket.AF_INET, kind)
    one.bind(("127.0.0.1", 0))
    if kind == socket.SOCK_STREAM:
        one.listen()
    select.select([sys.stdin], [], [], 60)
"""


@pytest.mark.skipif(not Path("/proc/net/tcp").is_file(), reason="no /proc/net")
@pytest.mark.parametrize("kind", ["SOCK_STREAM", "SOCK_DGRAM"])
def test_the_watch_sees_a_listener(kind: str, folder: Path) -> None:
    code, held, new = watched([sys.executable, "-c", LISTENS, kind], folder)
    assert code == 0
    assert held
    assert {protocol for protocol, _, _ in new} == {"tcp" if kind == "SOCK_STREAM" else "udp"}


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


UNPICKLES = re.compile(
    r"^\s*(import|from) (pickle|cPickle|dill|cloudpickle|joblib|marshal|shelve)\b|"
    r"\b(pickle|marshal)\.loads?\b|\byaml\.(unsafe_)?load\(|\b(eval|exec)\(|\bread_pickle\b",
    re.MULTILINE,
)
ASKS = "import pickle  # only to ask whether something can be pickled; nothing here reads one\n"
LOADS = re.compile(r"\b(np\.load|npy\.read_array|np\.fromfile|np\.memmap)\(([^()]|\([^()]*\))*\)")


def test_nothing_unpickles_or_evaluates() -> None:
    for path in sources("python", suffixes={".py"}):
        text = path.read_text()
        if path.name == "data.py":
            text = text.replace(ASKS, "")
        assert not UNPICKLES.search(text), name_of(path)
        for call in LOADS.finditer(text):
            if call[1] in ("np.load", "npy.read_array"):
                assert "allow_pickle=False" in call[0], f"{name_of(path)}: {call[0]}"


@pytest.mark.parametrize(
    "line",
    ["import pickle", "    from joblib import load", "yaml.load(text)", "eval(text)",
     "pickle.loads(data)"],
)  # fmt: skip
def test_the_search_for_pickles_finds_one(line: str) -> None:
    assert UNPICKLES.search(line)


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


def test_decompression_is_in_one_place() -> None:
    """What unpacks anything needs a cap: archives, chunks of bags, and the library for AEDAT4."""
    unpacks = re.compile(
        r"^\s*(import|from) (zipfile|zlib|gzip|bz2|lzma|tarfile|lz4|zstandard)", re.M
    )
    found = [
        name_of(p) for p in sources("python", suffixes={".py"}) if unpacks.search(p.read_text())
    ]
    assert found == [f"python/asap/io/{one}.py" for one in ("bags", "numpy_files", "writers")]
