"""Bad event data, class by class, through asap.run and asap.simulate, as array and as file.

(asap.read and asap.load: test_io_anomalies.py.)
"""

import warnings

import numpy as np
import pytest

import asap
import corrupt
from asap.io import CorruptFile, TruncatedFileWarning

EVENTS = corrupt.clean_events(4000)
SENSOR = {"width": corrupt.WIDTH, "height": corrupt.HEIGHT}


class Collector:
    def __init__(self):
        self.packages = []

    def process(self, events):
        self.packages.append(events)

    def column(self, name):
        parts = [events[name] for events in self.packages]
        return np.concatenate(parts) if parts else np.zeros(0)


def simulate(source, **options):
    got = Collector()
    cost = asap.LinearCost(alpha_us=10, beta_ns=10)
    options = {"scheme": asap.Greedy(), **options}
    return asap.simulate(source, cost=cost, algorithm=got, **options), got


def replay(source, **options):
    got = Collector()
    options = {"scheme": asap.Greedy(), **options}
    return asap.run(source, algorithm=got, speed=10, **options), got


def as_array(events, tmp_path):
    return events


def as_file(events, tmp_path):
    path = tmp_path / "events.npy"
    np.save(path, events)
    return path


@pytest.fixture(params=[simulate, replay], ids=["simulate", "run"])
def play(request):
    return request.param


@pytest.fixture(params=[as_array, as_file], ids=["array", "file"])
def source(request, tmp_path):
    return lambda events: request.param(events, tmp_path)


def check(run, got, **rejected):
    """The books are balanced, and exactly these events were rejected for exactly these reasons."""
    assert run.ledger.balanced
    assert {k: v for k, v in run.rejected.items() if v} == rejected
    assert run.ledger.rejected == sum(rejected.values())
    assert run.ledger.delivered == got.column("t").size
    t = got.column("t")
    assert (np.diff(t) >= 0).all()


def test_A1_back_steps_are_dropped_and_counted(play, source):
    bad = corrupt.back_steps(EVENTS, 40)
    run, got = play(source(bad), **SENSOR)
    check(run, got, nonmonotonic=40)
    assert run.ledger.received == EVENTS.size
    np.testing.assert_array_equal(got.column("t"), EVENTS["t"][bad["t"] == EVENTS["t"]])


def test_A1_back_step_raises_on_request(play, source):
    bad = corrupt.back_steps(EVENTS, 1)
    with pytest.raises(ValueError, match="t = "):
        play(source(bad), on_bad="raise", **SENSOR)
    assert asap.last_run().ledger.balanced


def test_A2_clock_reset_starts_an_epoch(play, source):
    bad = corrupt.clock_reset(EVENTS, 2000, to_us=0)
    run, got = play(source(bad), **SENSOR)
    check(run, got)
    assert run.ledger.delivered == EVENTS.size
    t = got.column("t")
    assert t[2000] == t[1999] + 1
    np.testing.assert_array_equal(np.diff(t[2000:]), np.diff(EVENTS["t"][2000:]))
    assert run.clock_resets == 1
    assert run.summary()["source"]["duration_s"] == pytest.approx((t[-1] - t[0]) / 1e6)


def test_A5_events_outside_the_sensor_are_dropped_and_counted(play, source):
    bad = corrupt.outside_sensor(EVENTS, 30)
    run, got = play(source(bad), **SENSOR)
    check(run, got, out_of_bounds=30)
    assert got.column("x").max() < corrupt.WIDTH
    assert got.column("y").max() < corrupt.HEIGHT


def test_A5_events_outside_the_sensor_raise_on_request(play, source):
    with pytest.raises(ValueError, match=r"[xy] = "):
        play(source(corrupt.outside_sensor(EVENTS, 2)), on_bad="raise", **SENSOR)


def test_A5_events_outside_the_sensor_are_clamped_on_request(play, source):
    run, got = play(source(corrupt.outside_sensor(EVENTS, 30)), on_bad="clamp", **SENSOR)
    check(run, got)
    assert run.ledger.delivered == EVENTS.size
    assert got.column("x").max() == corrupt.WIDTH - 1


def test_A6_many_events_on_one_stamp(play, source):
    run, got = play(source(corrupt.one_stamp(EVENTS, 100, 700)), scheme=asap.FixedSize(size=100))
    check(run, got)
    assert run.ledger.delivered == EVENTS.size
    rows = run.packages
    assert np.isfinite(rows["rate"]).all()
    # Clean events come at 0.2 Mev/s; 700 on one stamp must not look like 100 Mev/s.
    assert rows["event_rate"][1:].max() < 2e6 * run.speed


def test_A8_odd_polarities_are_normalised(play, source):
    run, got = play(source(corrupt.odd_polarity(EVENTS, 50)), **SENSOR)
    check(run, got)
    np.testing.assert_array_equal(got.column("p"), EVENTS["p"])


def test_A8_duplicates_pass_and_are_counted_once_each(play, source):
    run, got = play(source(corrupt.duplicates(EVENTS, 20)), **SENSOR)
    check(run, got)
    assert run.ledger.received == run.ledger.delivered == EVENTS.size + 20


@pytest.mark.parametrize("count", [0, 1])
def test_A9_nothing_and_a_single_event(play, source, count):
    run, got = play(source(EVENTS[:count]), **SENSOR)
    check(run, got)
    assert run.ledger.received == count
    assert run.packages.size == count


def test_A9_empty_arrays_and_none_in_a_stream(play):
    chunks = [EVENTS[:0], EVENTS[:10], None, EVENTS[10:10], EVENTS[10:]]
    run, got = play(iter(chunks), **SENSOR)
    check(run, got)
    assert run.ledger.delivered == EVENTS.size


def test_A9_ten_million_events_in_one_call():
    events = np.zeros(10_000_000, asap.EVENT_DTYPE)
    events["t"] = np.arange(events.size) // 10
    run = asap.simulate(events, cost=asap.LinearCost(10, 10), scheme=asap.Greedy())
    assert run.ledger.delivered == events.size


def test_A10_a_long_silence_is_flushed_and_forgotten(play, source):
    silence_us = 10_000_000
    run, got = play(
        source(corrupt.gap(EVENTS, 2000, silence_us)),
        scheme=asap.FixedSize(size=1500),
        latency_ms=500,  # half the silence as asap.run plays it, far more than the events before it
    )
    check(run, got)
    assert run.ledger.delivered == EVENTS.size
    # 1500, then the 500 before the silence, which nothing follows; no package spans the silence.
    assert run.packages["size"].tolist() == [1500, 500, 1500, 500]
    assert (run.packages["t_last"] - run.packages["t_first"]).max() < silence_us
    # Over the silence the rate is low, before it it is what it was.
    rates = run.packages["event_rate"] / run.speed
    assert rates[1] == pytest.approx(2e5, rel=0.1)
    assert rates[2] < 1e3


def test_A13_a_truncated_file_keeps_what_is_good(play, tmp_path):
    path = tmp_path / "events.npy"
    np.save(path, EVENTS)
    corrupt.cut_file(path, path.stat().st_size - 16 * 1000 - 3)
    with pytest.warns(TruncatedFileWarning, match="byte"):
        run, got = play(path, **SENSOR)
    check(run, got)
    np.testing.assert_array_equal(got.column("t"), EVENTS["t"][: got.column("t").size])
    assert EVENTS.size - 1002 < got.column("t").size < EVENTS.size - 999


def test_A13_a_truncated_file_raises_on_request(play, tmp_path):
    path = tmp_path / "events.npy"
    np.save(path, EVENTS)
    corrupt.cut_file(path, 40_000)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with pytest.raises(CorruptFile, match="byte"):
            play(path, on_bad="raise", **SENSOR)


def test_A13_a_corrupt_text_line_is_counted(play, tmp_path):
    path = tmp_path / "events.csv"
    lines = [f"{e['t']},{e['x']},{e['y']},{e['p']}" for e in EVENTS[:100]]
    lines[50] = "garbage,1"
    path.write_text("\n".join(lines) + "\n")
    run, got = play(path, **SENSOR)
    check(run, got, bad_record=1)
    assert run.ledger.received == 100
    assert run.ledger.delivered == 99
