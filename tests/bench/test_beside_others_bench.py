"""Filters, corners, surfaces and slices, each beside those of other libraries, on the same events.

Every rule is the library's own, with its defaults and the same time of 2 ms, window of 9 x 9 px or
slice of 10 ms. Each gets the events in its own container, made before.

pytest tests/bench/test_beside_others_bench.py --benchmark-only --benchmark-columns=min
"""

import datetime

import numpy as np
import pytest

import asap

SCENE = asap.synthetic.FlightOverChairs(duration_s=1.0)
SIZE = (SCENE.width, SCENE.height)
EVENTS = SCENE.events()
FILTER_US = 2000
SLICE_US = 10_000
PARAMETERS = {
    "BackgroundActivityFilter": {"window_us": FILTER_US},
    "SpeedInvariantTimeSurface": {"radius": 4},  # 9 x 9 px, as that of dv-processing
}


@pytest.fixture(scope="module")
def eventcv_stream():
    columns = [EVENTS[name].astype(np.int64) for name in ("x", "y", "t", "p")]
    eventcv = pytest.importorskip("eventcv")
    return eventcv.from_numpy(np.stack(columns, axis=1), sensor_size=SIZE, time_unit="us")


@pytest.fixture(scope="module")
def dv_store():
    store = pytest.importorskip("dv_processing").EventStore()
    for event in EVENTS.tolist():
        store.push_back(event[3], event[0], event[1], event[2] > 0)
    return store


@pytest.fixture(scope="module")
def tonic_events():
    pytest.importorskip("tonic")
    made = np.empty(len(EVENTS), [("x", "<i2"), ("y", "<i2"), ("t", "<i8"), ("p", "?")])
    for name in made.dtype.names:
        made[name] = EVENTS[name]
    return made


def run(benchmark, group, call, rounds=5):
    benchmark.group = group
    benchmark.extra_info["events"] = len(EVENTS)
    benchmark.pedantic(call, rounds=rounds, warmup_rounds=1)


@pytest.mark.parametrize(
    "name", ["BackgroundActivityFilter", "EFast", "EHarris", "SpeedInvariantTimeSurface"]
)
def test_asap(benchmark, name):
    made = getattr(asap, name)
    parameters = PARAMETERS.get(name, {})
    run(benchmark, name, lambda: made(*SIZE, **parameters).process(EVENTS))


def test_eventcv_filter(benchmark, eventcv_stream):
    run(
        benchmark,
        "BackgroundActivityFilter",
        lambda: eventcv_stream.background_activity_filter(FILTER_US),
    )


def test_dv_filter(benchmark, dv_store):
    dv = pytest.importorskip("dv_processing")
    duration = datetime.timedelta(microseconds=FILTER_US)

    def filtered():
        noise = dv.noise.BackgroundActivityNoiseFilter(SIZE, duration)
        noise.accept(dv_store)
        return noise.generateEvents()

    run(benchmark, "BackgroundActivityFilter", filtered)


def test_tonic_filter(benchmark, tonic_events):
    denoise = pytest.importorskip("tonic").transforms.Denoise(filter_time=FILTER_US)
    run(benchmark, "BackgroundActivityFilter", lambda: denoise(tonic_events), rounds=1)


def test_eventcv_efast(benchmark, eventcv_stream):
    run(benchmark, "EFast", eventcv_stream.efast)


def test_eventcv_harris(benchmark, eventcv_stream):
    run(benchmark, "EHarris", eventcv_stream.harris_corners)


def test_dv_surface(benchmark, dv_store):
    dv = pytest.importorskip("dv_processing")
    run(
        benchmark,
        "SpeedInvariantTimeSurface",
        lambda: dv.SpeedInvariantTimeSurface(SIZE).accept(dv_store),
    )


def test_asap_slices(benchmark, tmp_path):
    np.save(tmp_path / "flight.npy", EVENTS)

    def count():
        recording = asap.read(tmp_path / "flight.npy", width=SIZE[0], height=SIZE[1])
        return sum(1 for _ in recording.slices(ms=SLICE_US / 1000))

    run(benchmark, "slices of 10 ms (ours from a file)", count)


def test_dv_slices(benchmark, dv_store):
    dv = pytest.importorskip("dv_processing")

    def count():
        sizes = []
        slicer = dv.EventStreamSlicer()
        interval = datetime.timedelta(microseconds=SLICE_US)
        slicer.doEveryTimeInterval(interval, lambda events: sizes.append(len(events)))
        slicer.accept(dv_store)

    run(benchmark, "slices of 10 ms (ours from a file)", count)


def test_tonic_slices(benchmark, tonic_events):
    slicer = pytest.importorskip("tonic").slicers.SliceByTime(SLICE_US)
    run(benchmark, "slices of 10 ms (ours from a file)", lambda: slicer.slice(tonic_events, None))
