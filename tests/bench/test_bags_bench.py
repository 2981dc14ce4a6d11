"""ROS bags beside `rosbags`: its raw messages and one copy of 16 bytes per event, and its decoding.

Ours decodes and checks every event; of a packet the library decodes the fields, not the events. The
figures are those of 10^7 events:

ASAP_BENCH_EVENTS=10000000 pytest tests/bench/test_bags_bench.py --benchmark-only
"""

import os

import numpy as np
import pytest

import asap
from ros_bags import ENCODERS, SUFFIXES, Types, write_bag

COUNT = int(os.environ.get("ASAP_BENCH_EVENTS", "1000000"))
PER_MESSAGE = 10_000
OUT, FROM = (np.zeros(COUNT, "V16") for _ in range(2))  # copied as memory, not field by field


@pytest.fixture(scope="module")
def events():
    random = np.random.default_rng(0)
    events = np.zeros(COUNT, asap.EVENT_DTYPE)
    events["t"] = np.cumsum(random.integers(0, 3, COUNT))
    events["x"] = random.integers(0, 346, COUNT)
    events["y"] = random.integers(0, 260, COUNT)
    events["p"] = random.integers(0, 2, COUNT)
    return events


ROS1 = np.dtype([("x", "<u2"), ("y", "<u2"), ("s", "<u4"), ("ns", "<u4"), ("p", "u1")])
CDR = np.dtype(  # x comes at the end of the record before
    {
        "names": ["y", "s", "ns", "p", "x"],
        "formats": ["<u2", "<u4", "<u4", "u1", "<u2"],
        "offsets": [0, 4, 8, 12, 14],
        "itemsize": 16,
    }
)


def array(types, events):
    """The message of dvs_msgs, without an object for each event."""
    records = np.zeros(len(events), ROS1 if types.is_ros1 else CDR)
    records["x"] = events["x"] if types.is_ros1 else np.roll(events["x"], -1)
    records["y"], records["p"] = events["y"], events["p"]
    records["s"], records["ns"] = events["t"] // 10**6, events["t"] % 10**6 * 1000 + 999
    wire = records.tobytes()
    if not types.is_ros1:
        wire = events["x"][:1].tobytes() + events["y"][:1].tobytes() + wire[4:-3]
    name, empty = types.array(events[:0])
    return name, empty[:-4] + np.uint32(len(events)).tobytes() + wire


def messages(types, events, encoding):
    assert array(types, events[:50]) == types.array(events[:50])
    for at in range(0, COUNT, PER_MESSAGE):
        part = events[at : at + PER_MESSAGE]
        if encoding == "dvs_msgs":
            yield "/events", array(types, part)
        else:
            base_us = 0 if encoding == "evt3" else int(part["t"][0])
            payload = ENCODERS[encoding](part, base_us)
            yield "/events", types.packet(payload, encoding, time_base=1000 * base_us)


@pytest.fixture(scope="module", params=SUFFIXES)
def types(request):
    return Types(request.param)


@pytest.fixture(scope="module", params=[*ENCODERS, "dvs_msgs"])
def bag(request, types, events, tmp_path_factory):
    path = tmp_path_factory.mktemp("bags") / f"events.{SUFFIXES[types.format]}"
    write_bag(path, types, messages(types, events, request.param))
    yield path
    path.unlink()


def fill(path):
    filled = 0
    for chunk in asap.read(path):
        OUT[filled : filled + len(chunk)] = chunk.view(OUT.dtype)
        filled += len(chunk)
    assert filled == COUNT


def read_raw(path):
    """The raw messages, and a copy of as many bytes as the events take."""
    with pytest.importorskip("rosbags.highlevel").AnyReader([path]) as reader:
        for _ in reader.messages():
            pass
    OUT[:] = FROM


def deserialize(path):
    with pytest.importorskip("rosbags.highlevel").AnyReader([path]) as reader:
        for connection, _, raw in reader.messages():
            reader.deserialize(raw, connection.msgtype)


@pytest.mark.parametrize("read", [fill, read_raw, deserialize])
def test_reading(benchmark, bag, read):
    benchmark.extra_info["events"] = COUNT
    benchmark.pedantic(read, (bag,), rounds=1 if read is deserialize else 5, warmup_rounds=1)
