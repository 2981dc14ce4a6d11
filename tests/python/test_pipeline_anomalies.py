"""Bad event data, class by class, pushed into a live pipeline.

(Files and arrays: test_anomalies.py.) A11 to A14 are of messages, of several cameras and of files.
"""

from __future__ import annotations

import numpy as np
import pytest

import asap
import corrupt

EVENTS = corrupt.clean_events(4000)
SENSOR = {"width": corrupt.WIDTH, "height": corrupt.HEIGHT}


def push(pipeline, *chunks):
    """Push, then deliver all; the events that came out."""
    for chunk in chunks:
        pipeline.push(chunk)
    pipeline.stop()
    parts = [package.events for package in pipeline]
    return np.concatenate([EVENTS[:0], *parts])


def live(*chunks, **options):
    pipeline = asap.Pipeline(**{"scheme": asap.Greedy(), "latency_ms": 1e4, **options})
    return pipeline, push(pipeline, *chunks)


def check(pipeline, got, **rejected):
    """The books are balanced, and exactly these events were rejected for exactly these reasons."""
    ledger = pipeline.ledger
    assert ledger.balanced
    assert {k: v for k, v in pipeline.stats()["rejected"].items() if v} == rejected
    assert ledger.rejected == sum(rejected.values())
    assert ledger.delivered == got.size
    assert (np.diff(got["t"]) >= 0).all()


def refused(bad, message, **options):
    """With on_bad="raise": what was good before is in, and the pipeline can go on."""
    pipeline = asap.Pipeline(on_bad="raise", scheme=asap.Greedy(), **options)
    with pytest.raises(ValueError, match=message):
        pipeline.push(bad)
    good = pipeline.ledger.received - pipeline.ledger.rejected
    assert pipeline.ledger.rejected == 1
    later = EVENTS[-1:].copy()
    later["t"] += 10
    got = push(pipeline, later)
    assert got.size == good + 1
    assert pipeline.ledger.balanced


def test_A1_back_steps():
    bad = corrupt.back_steps(EVENTS, 40)
    pipeline, got = live(bad, **SENSOR)
    check(pipeline, got, nonmonotonic=40)
    assert got["t"].tolist() == EVENTS["t"][bad["t"] == EVENTS["t"]].tolist()
    refused(bad, "t = ")
    pipeline, got = live(bad, on_bad="clamp", **SENSOR)
    check(pipeline, got)
    assert got.size == EVENTS.size


def test_A1_back_steps_within_the_tolerance():
    bad = corrupt.back_steps(EVENTS, 40)
    pipeline, got = live(bad, reorder_tolerance_us=500)
    check(pipeline, got)
    assert got.size == EVENTS.size
    late = bad["t"] != EVENTS["t"]
    assert got["t"][late].tolist() == EVENTS["t"][np.flatnonzero(late) - 1].tolist()
    pipeline, got = live(bad, reorder_tolerance_us=250)
    lost = pipeline.stats()["rejected"]["nonmonotonic"]
    check(pipeline, got, nonmonotonic=lost)
    assert 0 < lost < 40


def test_A1_back_steps_between_two_pushes():
    pipeline, got = live(EVENTS[:1000], EVENTS[990:2000])
    check(pipeline, got, nonmonotonic=9)  # the tenth has the stamp of the last one


def test_A2_clock_reset_starts_an_epoch():
    pipeline, got = live(corrupt.clock_reset(EVENTS, 2000, to_us=0), **SENSOR)
    check(pipeline, got)
    assert got.size == EVENTS.size
    assert got["t"][2000] == got["t"][1999] + 1
    assert np.diff(got["t"][2000:]).tolist() == np.diff(EVENTS["t"][2000:]).tolist()
    assert pipeline.stats()["clock_resets"] == 1


def test_A2_clock_reset_makes_due_what_waits():
    with asap.Pipeline(scheme=asap.FixedSize(size=5000), latency_ms=1e6) as pipeline:
        pipeline.push(EVENTS[:2000])
        pipeline.push(corrupt.clock_reset(EVENTS, 2000, to_us=0)[2000:])
        assert len(next(iter(pipeline))) >= 2000  # not only with the 5000th


def test_A3_wrap_of_24_bits():
    long = EVENTS.copy()
    long["t"] = (1 << 24) - 9000 + (EVENTS["t"] - EVENTS["t"][0])
    wrapped = long.copy()
    wrapped["t"] %= 1 << 24
    pipeline, got = live(wrapped)
    check(pipeline, got)
    assert got.size == EVENTS.size
    assert pipeline.stats()["clock_resets"] == 1


@pytest.mark.parametrize("first_us", [-(1 << 51), -1, 0, 6_437_104, 1_633_953_690_975_950])
def test_A4_the_first_stamp_does_not_matter(first_us):
    moved = EVENTS.copy()
    moved["t"] += first_us - moved["t"][0]
    pipeline, got = live(moved)
    check(pipeline, got)
    assert got["t"].tolist() == moved["t"].tolist()
    assert pipeline.stats()["latency_us"]["max"] < 60e6  # from the push, not from the stamp


def test_A5_events_outside_the_sensor():
    bad = corrupt.outside_sensor(EVENTS, 30)
    pipeline, got = live(bad, **SENSOR)
    check(pipeline, got, out_of_bounds=30)
    assert got["x"].max() < corrupt.WIDTH
    assert got["y"].max() < corrupt.HEIGHT
    refused(bad, "[xy] = ", **SENSOR)
    pipeline, got = live(bad, on_bad="clamp", **SENSOR)
    check(pipeline, got)
    assert got["x"].max() == corrupt.WIDTH - 1
    assert got.size == EVENTS.size


def test_A6_many_events_on_one_stamp():
    bad = corrupt.one_stamp(EVENTS, 100, 700)
    pipeline, got = live(bad, scheme=asap.FixedSize(size=100))
    check(pipeline, got)
    assert got["t"].tolist() == bad["t"].tolist()
    for name in pipeline.packages.dtype.names:
        assert np.isfinite(pipeline.packages[name]).all()


def test_A7_hot_pixels_pass_or_are_masked_in_front():
    hot = EVENTS.copy()
    hot["x"][::4], hot["y"][::4] = 17, 11
    pipeline, got = live(hot, **SENSOR)
    check(pipeline, got)
    assert got.size == EVENTS.size
    mask = np.zeros((corrupt.WIDTH, corrupt.HEIGHT), bool)
    mask[17, 11] = True
    pipeline, got = live(hot, before=lambda e: e[~mask[e["x"], e["y"]]], **SENSOR)
    check(pipeline, got)
    assert pipeline.ledger.filtered == EVENTS.size - got.size >= 1000


def test_A8_odd_polarities_and_duplicates():
    pipeline, got = live(corrupt.odd_polarity(EVENTS, 50), **SENSOR)
    check(pipeline, got)
    assert got["p"].tolist() == EVENTS["p"].tolist()
    pipeline, got = live(corrupt.duplicates(EVENTS, 20), **SENSOR)
    check(pipeline, got)
    assert got.size == EVENTS.size + 20


def test_A9_nothing_one_event_and_ten_million():
    pipeline, got = live(EVENTS[:0])
    check(pipeline, got)
    assert pipeline.packages.size == 0
    pipeline, got = live(EVENTS[:0], EVENTS[:1], EVENTS[:0])
    check(pipeline, got)
    assert got.tolist() == EVENTS[:1].tolist()
    pipeline, got = live(None)  # as drivers that have nothing say it
    check(pipeline, got)
    many = np.zeros(10_000_000, asap.EVENT_DTYPE)
    pipeline, got = live(many, when_full="newest", capacity=1 << 20)
    check(pipeline, got)
    assert pipeline.ledger.received == many.size
    assert (pipeline.ledger.delivered, got.size) == (1 << 20, 1 << 20)


def test_A10_a_long_gap_of_stamps_loses_nothing_and_a_silence_is_flushed():
    gap_us = 3_600_000_000
    pipeline, got = live(corrupt.gap(EVENTS, 2000, gap_us))
    check(pipeline, got)
    assert got.size == EVENTS.size
    assert pipeline.ledger.stale == 0
    with asap.Pipeline(scheme=asap.FixedSize(size=5000), latency_ms=5) as pipeline:
        pipeline.push(EVENTS[:10])
        assert len(next(iter(pipeline))) == 10  # though nothing follows


def test_A15_what_comes_first_is_left_over():
    rest = corrupt.clean_events(100, start_us=7_000_000)
    rest["x"][::2] = 9999
    fresh = EVENTS.copy()
    fresh["t"] -= fresh["t"][0]
    warm = int((fresh["t"] >= 5000).sum())
    pipeline, got = live(rest, fresh, warmup_discard_us=5000, **SENSOR)
    check(pipeline, got, before_start=rest.size + fresh.size - warm)
    assert got["t"].tolist() == fresh["t"][-warm:].tolist()
    assert pipeline.stats()["clock_resets"] == 0
    pipeline, got = live(rest, fresh, warmup_discard_us=5000, on_bad="raise", **SENSOR)
    assert got.size == warm
