"""Files of the formats that libraries read, each beside its library, into memory that is there.

The rival is the library's own read and one copy of 16 bytes per event; ours finds the columns,
checks every event and writes it in our layout. The figures are those of 10^7 events:

ASAP_BENCH_EVENTS=10000000 pytest tests/bench/test_files_bench.py --benchmark-only
"""

import os

import numpy as np
import pytest

import asap
from aedat4_files import write_aedat4

COUNT = int(os.environ.get("ASAP_BENCH_EVENTS", "1000000"))
RECORD = np.dtype("V16")  # copied as memory, not field by field
OUT = np.empty(COUNT, RECORD)


@pytest.fixture(scope="module")
def events():
    random = np.random.default_rng(0)
    events = np.zeros(COUNT, asap.EVENT_DTYPE)
    events["t"] = np.cumsum(random.integers(0, 3, COUNT))
    events["x"] = random.integers(0, 346, COUNT)
    events["y"] = random.integers(0, 260, COUNT)
    events["p"] = random.integers(0, 2, COUNT)
    return events


def columns(events):
    types = {"t": "i8", "x": "u2", "y": "u2", "p": "u1"}
    return {name: events[name].astype(kind) for name, kind in types.items()}


def write_npy_packed(path, events):
    packed = np.zeros(len(events), [("t", "i8"), ("x", "u2"), ("y", "u2"), ("p", "u1")])
    for name in "txyp":
        packed[name] = events[name]
    np.save(path, packed)


def write_hdf5(path, events, **options):
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        for name, column in columns(events).items():
            file.create_dataset(f"events/{name}", data=column, **options)


def write_metavision(path, events):
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        file.create_dataset("CD/events", data=events, chunks=(1 << 14,))


def write_mat(path, events):
    pytest.importorskip("scipy.io").savemat(path, columns(events))


def write_packets(path, events, compression=0):
    pytest.importorskip("aedat")
    packets = ((0, events[at : at + 10_000]) for at in range(0, len(events), 10_000))
    write_aedat4(path, packets, compression=compression)


def read_npy(path):
    np.load(path)


def read_npz(path):
    with np.load(path) as archive:
        [archive[name] for name in "txyp"]


def read_columns(path):
    with pytest.importorskip("h5py").File(path) as file:
        [file["events"][name][:] for name in "txyp"]


def read_metavision(path):
    with pytest.importorskip("h5py").File(path) as file:
        file["CD/events"][:]


def read_mat(path):
    pytest.importorskip("scipy.io").loadmat(path)


def read_packets(path):
    for packet in pytest.importorskip("aedat").Decoder(path):
        packet["events"]


CHUNKS = {"chunks": (1 << 16,)}
FORMATS = {
    "npy": (np.save, read_npy),
    "npy, 13 bytes": (write_npy_packed, read_npy),
    "npz": (lambda path, events: np.savez(path, **columns(events)), read_npz),
    "npz, deflated": (
        lambda path, events: np.savez_compressed(path, **columns(events)),
        read_npz,
    ),
    "aedat4": (write_packets, read_packets),
    "aedat4, lz4": (lambda path, events: write_packets(path, events, 1), read_packets),
    "aedat4, zstd": (lambda path, events: write_packets(path, events, 3), read_packets),
    "h5": (write_hdf5, read_columns),
    "h5, chunks": (lambda path, events: write_hdf5(path, events, **CHUNKS), read_columns),
    "h5, gzip": (
        lambda path, events: write_hdf5(path, events, compression="gzip", **CHUNKS),
        read_columns,
    ),
    "h5, Metavision": (write_metavision, read_metavision),
    "mat": (write_mat, read_mat),
}


@pytest.fixture(scope="module", params=FORMATS)
def file(request, tmp_path_factory, events):
    write, rival = FORMATS[request.param]
    path = tmp_path_factory.mktemp("files") / f"a.{request.param.partition(',')[0]}"
    write(path, events)
    yield request.param, path, rival
    path.unlink()


def ours(path):
    count = 0
    for chunk in asap.read(path):
        OUT[count : count + len(chunk)] = chunk.view(RECORD)
        count += len(chunk)
    assert count == COUNT


def test_asap(benchmark, file):
    name, path, _ = file
    benchmark.group = name
    benchmark.pedantic(ours, (path,), rounds=5, warmup_rounds=1)


def test_rival_and_copy(benchmark, file, events):
    name, path, rival = file
    benchmark.group = name

    def read_and_copy():
        rival(str(path))
        OUT[:] = events.view(RECORD)

    benchmark.pedantic(read_and_copy, rounds=5, warmup_rounds=1)
