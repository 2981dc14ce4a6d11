"""Native files of 10^7 events, from the page cache into an array, beside other readers.

pytest tests/bench/test_native_decoders_bench.py --benchmark-only
The rivals skip where they are absent: pip install expelliarmus evt3 eventcv event-stream. They make
an array of their own; ours is there already, as a copy of the events is, which bounds what memory
allows.
"""

import numpy as np
import pytest

import asap
import raw_files
import record_files
from asap import _core

COUNT = 10_000_000
PIECE = 1 << 18  # bytes; stays in the second-level cache


@pytest.fixture(scope="module")
def events():
    """10 Mev/s of an HD sensor: pixels at random within rows that stay for 4 events."""
    random = np.random.default_rng(0)
    events = np.zeros(COUNT, asap.EVENT_DTYPE)
    events["x"] = random.integers(0, 1280, COUNT)
    events["y"] = np.repeat(random.integers(0, 720, COUNT // 4), 4)
    events["p"] = random.integers(0, 2, COUNT)
    events["t"] = 1_000_000 + np.arange(COUNT) // 10
    return events


@pytest.fixture(scope="module")
def of_dvs128(events):
    """The same on a small sensor."""
    small = events.copy()
    small["x"] %= record_files.SIDE
    small["y"] %= record_files.SIDE
    return small


@pytest.fixture(scope="module", params=record_files.FORMATS)
def written(request, events, of_dvs128, tmp_path_factory):
    """A file and its events."""
    kind = request.param
    form = record_files.FORMATS[kind]
    path = tmp_path_factory.mktemp("bench") / f"{kind}{form.suffix}"
    if kind in record_files.RECORDS:
        form.write(path, of_dvs128)
        yield path, of_dvs128
    else:
        yield raw_files.WRITERS[kind](path, events, 1280, 720), events
    for file in path.parent.iterdir():
        file.unlink()


@pytest.fixture
def path(written):
    return written[0]


def told(path):
    """Return what the user has to say about the file."""
    return {"height": record_files.SIDE} if path.stem == "es1" else {}


def measure(benchmark, path, read):
    count = benchmark.pedantic(read, rounds=5, warmup_rounds=1)
    assert count == COUNT
    seconds = benchmark.stats.stats.min
    benchmark.extra_info["Mev/s"] = round(COUNT / seconds / 1e6)
    benchmark.extra_info["GB/s"] = round((path.stat().st_size + 16 * COUNT) / seconds / 1e9, 2)


def test_decoder(benchmark, written):
    path, events = written
    opened = _core.OpenedRecording(path, asap.read(path, **told(path)).format, **told(path))
    out, piece = np.empty(COUNT, asap.EVENT_DTYPE), memoryview(bytearray(PIECE))

    def read():
        decoder, filled = opened.decoder(opened.start), 0
        with path.open("rb", buffering=0) as file:
            file.seek(opened.start)
            while size := file.readinto(piece):
                _, written = decoder.decode_into(piece[:size], out[filled:])
                filled += written
        return filled

    measure(benchmark, path, read)
    assert all((out[name] == events[name]).all() for name in "txyp")


def test_iterated(benchmark, path):
    measure(benchmark, path, lambda: sum(map(len, asap.read(path, **told(path)))))


def test_anchor_copy(benchmark, path, events):
    out, source = np.empty(16 * COUNT, np.uint8), events.view(np.uint8)

    def copy():
        np.copyto(out, source)
        return COUNT

    measure(benchmark, path, copy)


def test_rival_expelliarmus(benchmark, path):
    expelliarmus = pytest.importorskip("expelliarmus")
    if path.stem not in ("evt2", "evt3", "dat"):
        pytest.skip("expelliarmus does not read it")
    wizard = expelliarmus.Wizard(encoding=path.stem)
    measure(benchmark, path, lambda: len(wizard.read(path)))


def test_rival_evt3(benchmark, path):
    evt3 = pytest.importorskip("evt3")
    if path.stem != "evt3":
        pytest.skip("evt3 reads EVT3")
    measure(benchmark, path, lambda: len(evt3.decode_file(str(path))))


def test_rival_eventcv(benchmark, path):
    eventcv = pytest.importorskip("eventcv")
    if path.stem not in ("evt2", "evt3", "dat"):
        pytest.skip("EventCV does not read it, or not rightly")
    measure(benchmark, path, lambda: len(eventcv.load(str(path))))


def test_rival_event_stream(benchmark, path):
    event_stream = pytest.importorskip("event_stream")
    if path.stem != "es":
        pytest.skip("event_stream reads Event Stream 2")
    measure(benchmark, path, lambda: sum(map(len, event_stream.Decoder(str(path)))))
