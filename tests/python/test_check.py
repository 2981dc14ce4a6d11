"""asap.check: every anomaly is found, as often as it is there and where it is there first."""

from __future__ import annotations

import json
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import asap
import corrupt
from asap.events import Events
from asap.inspection import raw_source
from event_files import WRITERS, write_csv

SENSOR = {"width": corrupt.WIDTH, "height": corrupt.HEIGHT}
EVENTS = corrupt.clean_events(70_000)  # more than one block
EVENTS["y"] //= 4  # dense as a scene, not as noise


def outcome(inspection: asap.Inspection) -> dict[str, tuple[int, str, int | None, int | None]]:
    """Of every check that is not ok: count, verdict, number and stamp of the first event."""
    return {
        name: (finding.count, finding.verdict, finding.event, finding.t_us)
        for name, finding in inspection.findings.items()
        if finding.verdict != "ok"
    }


def place(events: Events, found: np.ndarray) -> tuple[int, int]:
    """Number and stamp of the first of these."""
    first = int(np.flatnonzero(found)[0])
    return first, int(events["t"][first])


def check(events: Any, **options: Any) -> asap.Inspection:
    return asap.check(events, **SENSOR, **options)


# ---- a clean recording ----------------------------------------------------------------------


def test_a_clean_recording_is_ok() -> None:
    found = check(EVENTS)
    assert outcome(found) == {}
    assert {finding.count for finding in found.findings.values()} == {0}
    assert found.ok and found.verdict == "ok"
    assert str(found).endswith("Verdict: ok. Nothing is wrong with this recording.")


def test_facts_of_a_clean_recording() -> None:
    found = check(EVENTS)
    elapsed = EVENTS["t"] - EVENTS["t"][0]
    assert (found.events, found.received) == (EVENTS.size, EVENTS.size)
    assert found.t_first_us == EVENTS["t"][0]
    assert found.duration_s == elapsed[-1] / 1e6
    assert found.on_share == np.mean(EVENTS["p"])
    assert found.rate_mean_hz == EVENTS.size / found.duration_s
    assert found.rate_peak_1ms_hz == np.bincount(elapsed // 1_000).max() * 1e3
    assert found.rate_peak_10ms_hz == np.bincount(elapsed // 10_000).max() * 1e2
    assert found.rate_peak_100ms_hz == np.bincount(elapsed // 100_000).max() * 1e1
    assert found.longest_gap_us == np.diff(elapsed).max()
    counts = np.zeros((corrupt.HEIGHT, corrupt.WIDTH), int)
    np.add.at(counts, (EVENTS["y"], EVENTS["x"]), 1)
    np.testing.assert_array_equal(found.pixel_counts, counts)
    top = found.busiest_pixels
    assert top["events"].tolist() == np.sort(counts.ravel())[:-11:-1].tolist()
    assert (counts[top["y"], top["x"]] == top["events"]).all()


# ---- one anomaly each -----------------------------------------------------------------------


def test_back_steps() -> None:
    bad = corrupt.back_steps(EVENTS, 40)
    went_back = bad["t"] != EVENTS["t"]
    found = check(bad)
    assert outcome(found) == {"back_steps": (40, "wrong", *place(bad, went_back))}
    largest = int((EVENTS["t"][:-1] - bad["t"][1:])[went_back[1:]].max())
    assert f"largest {largest} us" in found.findings["back_steps"].detail
    assert f"reorder_tolerance_us={largest})" in found.findings["back_steps"].remedy


def test_where_most_events_are_late_the_tolerance_that_sorts_them_is_named() -> None:
    late_us = np.random.default_rng(1).integers(0, 500, EVENTS.size)
    found = check(EVENTS[np.argsort(EVENTS["t"] + late_us)]).findings["back_steps"]
    assert found.count > EVENTS.size / 2
    assert "reorder_tolerance_us=" in found.remedy


@pytest.mark.parametrize(("by_us", "words"), [(1 << 24, "24 bits"), (1 << 31, "31 bits")])
def test_a_counter_that_wraps_is_named(by_us: int, words: str) -> None:
    bad = EVENTS[:1000].copy()
    bad["t"] = (by_us + 5 * (np.arange(1000) - 500)) % by_us
    found = check(bad)
    assert outcome(found) == {"clock_resets": (1, "wrong", 500, 0)}
    assert f"as a counter of {words} wraps" in found.findings["clock_resets"].detail
    bad["t"][500:] += by_us // 50
    assert "wraps" not in check(bad).findings["clock_resets"].detail


def test_without_a_sensor_size_addresses_are_not_checked_and_that_is_said() -> None:
    found = asap.check(EVENTS)
    assert outcome(found) == {"out_of_bounds": (0, "note", None, None)}
    assert "addresses up to x = 345, y = 64" in found.findings["out_of_bounds"].detail
    assert found.ok and found.verdict == "note"
    assert asap.check(corrupt.outside_sensor(EVENTS, 30)).ok
    half = asap.check(corrupt.outside_sensor(EVENTS, 30), width=corrupt.WIDTH)
    assert outcome(half)["out_of_bounds"][:2] == (15, "wrong")


@pytest.mark.parametrize(
    ("gap_us", "expected"),
    [(99_999, None), (100_000, "note"), (999_999, "note"), (1_000_000, "wrong")],
)
def test_gaps(gap_us: int, expected: str | None) -> None:
    bad, begin = EVENTS.copy(), raw_source.BLOCK
    bad["t"][begin:] += gap_us - (bad["t"][begin] - bad["t"][begin - 1])
    found = check(bad)
    assert found.longest_gap_us == gap_us
    at = (begin, int(bad["t"][begin]))
    assert outcome(found) == ({"gaps": (1, expected, *at)} if expected else {})


def test_noise_is_named() -> None:
    """Static noise is found too: a pixel is no neighbour of itself."""
    noise = corrupt.clean_events(20_000)
    noise["y"] = np.random.default_rng(1).integers(0, corrupt.HEIGHT, noise.size)
    noise["t"] *= 10
    finding = check(noise).findings["noise"]
    assert finding.verdict == "note" and finding.count / noise.size > 0.9
    assert finding.detail.endswith("within 20 ms, as many as where all are noise")
    flicker = noise.copy()  # pixels apart, each again and again
    flicker["x"], flicker["y"] = noise["x"] // 8 * 8, noise["y"] // 8 * 8
    assert check(flicker).findings["noise"].count == flicker.size
    assert check(EVENTS).findings["noise"].verdict == "ok"
    assert asap.check(noise).findings["noise"].detail == "not measured: the sensor is unknown"


@pytest.mark.parametrize("p", [0, 1])
def test_one_polarity_only_is_worth_knowing(p: int) -> None:
    bad = EVENTS[:100].copy()
    bad["p"] = p
    found = check(bad)
    assert outcome(found) == {"polarity": (0, "note", None, None)}
    assert "One polarity only" in found.findings["polarity"].remedy
    assert outcome(check(bad[:99])) == {}


def with_busy(pixels: list[tuple[int, int]], times: int) -> Events:
    """Of the clean events, `times` are moved to each of these pixels."""
    bad = EVENTS.copy()
    numbers = np.arange(len(pixels) * times) * (EVENTS.size // (len(pixels) * times))
    bad["x"][numbers], bad["y"][numbers] = np.repeat(np.array(pixels), times, axis=0).T
    return bad


def test_hot_pixels() -> None:
    found = check(with_busy([(7, 0), (200, 100), (201, 100)], 300))
    assert outcome(found) == {"hot_pixels": (3, "note", None, None)}
    hot = {(x, y): events for x, y, events in found.hot_pixels.tolist()}
    assert set(hot) == {(7, 0), (200, 100), (201, 100)}  # at an edge, and a pair
    for (x, y), events in hot.items():
        assert found.pixel_counts[y, x] == events
    assert "1.3 % of the events" in found.findings["hot_pixels"].detail
    assert found.hot_pixels["events"].tolist() == sorted(hot.values(), reverse=True)


def test_a_busy_line_is_not_hot() -> None:
    found = check(with_busy([(x, 100) for x in range(20)], 300))
    assert outcome(found) == {}
    assert len(found.hot_pixels) == 0


def test_a_pixel_of_a_small_share_is_not_hot() -> None:
    pixels = np.arange(400_000) % (346 * 260)
    pixels[::2_500] = 12_345  # 160 events, where others have four
    found = check(
        asap.as_events((pixels * 0 + np.arange(400_000), pixels % 346, pixels // 346, pixels % 2))
    )
    assert len(found.hot_pixels) == 0


# ---- all at once ----------------------------------------------------------------------------


def slowly(events: Events) -> dict[str, tuple[int, int | None, int | None]]:
    """The definitions, one event after the other: count, number and stamp of the first."""
    found: dict[str, list[tuple[int, int]]] = {
        name: []
        for name in (
            *("bad_records", "out_of_bounds", "back_steps", "clock_resets", "gaps"),
            "polarity",
        )
    }
    last: int | None = None
    offset = 0

    for number, (x, y, p, t) in enumerate(events.tolist()):
        here = (number, t)
        if abs(t) > 2**52 - 2**50:
            found["bad_records"].append(here)
            continue
        if x >= corrupt.WIDTH or y >= corrupt.HEIGHT:
            found["out_of_bounds"].append(here)
            continue
        if last is not None and t + offset < last:
            if last - (t + offset) < 1_000_000:
                found["back_steps"].append(here)
                continue
            found["clock_resets"].append(here)
            offset = last + 1 - t
        if p not in (0, 1):
            found["polarity"].append(here)
        now = t + offset
        if last is not None and now - last >= 100_000:
            found["gaps"].append(here)
        last = now
    return {name: (len(at), *(at[0] if at else (None, None))) for name, at in found.items()}


WILD = st.lists(
    st.tuples(
        st.sampled_from([0, 3, 345, 346]),
        st.sampled_from([0, 259, 260]),
        st.sampled_from([0, 1, 1, -1, 2]),
        st.sampled_from([0, 0, 0, 1, 7, 5000, 120_000, -3, -900_000, -(2**24), 2**60]),
        st.sampled_from([1, 1, 1, 90, 101]),
    ),
    max_size=25,
)


@settings(max_examples=60)
@given(WILD, st.sampled_from([5, 64, 1 << 16]))
def test_wild_streams_are_told_as_by_the_definitions(
    rows: list[tuple[int, int, int, int, int]], block: int
) -> None:
    parts, t = [], 10_000_000
    for x, y, p, step, times in rows:
        if abs(step) < 2**60:
            t += step
        stamp = t if abs(step) < 2**60 else step
        parts += [(x, (y + i) % 261 if times > 1 else y, p, stamp) for i in range(times)]
    events = np.array(parts, asap.EVENT_DTYPE) if parts else EVENTS[:0]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(raw_source, "BLOCK", block)
        found = check(events)
    expected = slowly(events)
    told = {
        name: (found.findings[name].count, found.findings[name].event, found.findings[name].t_us)
        for name in expected
        if name != "polarity" or found.findings[name].count
    }
    assert told == {name: expected[name] for name in told}
    lost = sum(told[name][0] for name in ("bad_records", "out_of_bounds", "back_steps"))
    assert found.events == events.size - lost
    assert found.pixel_counts.sum() == found.events
    assert found.interval_counts.sum() == max(found.events - 1, 0)


def everything_wrong() -> Events:
    bad = corrupt.back_steps(EVENTS[:20_000], 40)
    bad = corrupt.outside_sensor(bad, 30, seed=1)
    bad = corrupt.odd_polarity(bad, 50, seed=2)
    bad = corrupt.gap(corrupt.clock_reset(bad, 15_000), 17_000, 40_000_000)
    bad["x"][::9], bad["y"][::9] = 30, 40
    return bad


@pytest.mark.parametrize("block", [7, 257, 1 << 16])
def test_blocks_do_not_matter(block: int, monkeypatch: pytest.MonkeyPatch) -> None:
    bad = everything_wrong()
    whole = check(bad)
    assert set(outcome(whole)) == {
        *("out_of_bounds", "back_steps", "clock_resets", "gaps", "polarity", "hot_pixels"),
    }
    monkeypatch.setattr(raw_source, "BLOCK", block)
    for cut in (bad, iter([bad[:5], None, bad[5:5], bad[5:15_001], bad[15_001:]])):
        found = check(cut)
        assert found.findings == whole.findings
        np.testing.assert_array_equal(found.pixel_counts, whole.pixel_counts)
        assert found.summary()["rate_hz"] == whole.summary()["rate_hz"]


@pytest.mark.parametrize("kind", WRITERS)
def test_counts_are_those_of_the_reader(kind: str, tmp_path: Path) -> None:
    path = tmp_path / f"bad.{kind}"
    WRITERS[kind](path, everything_wrong())
    found = check(path)
    rec = asap.read(path, **SENSOR)
    good = sum(map(len, rec))
    assert found.format == rec.format
    assert (found.events, found.received) == (good, rec.received)
    assert rec.rejected["nonmonotonic"] == found.findings["back_steps"].count > 0
    assert rec.rejected["out_of_bounds"] == found.findings["out_of_bounds"].count > 0
    assert rec.clock_resets == found.findings["clock_resets"].count == 1
    assert rec.repaired["normalised_polarity"] == found.findings["polarity"].count > 0


# ---- files ----------------------------------------------------------------------------------


def test_a_line_that_is_no_event(tmp_path: Path) -> None:
    path = tmp_path / "events.csv"
    write_csv(path, EVENTS[:300])
    lines = path.read_text().splitlines(keepends=True)
    offset = len("".join(lines[:50]))
    path.write_text("".join([*lines[:50], "garbage,1\n", "?\n", *lines[50:]]))
    found = check(path)
    assert outcome(found) == {"bad_records": (2, "wrong", None, None)}
    assert found.findings["bad_records"].byte == offset
    assert (found.events, found.received) == (300, 302)
    for on_bad in ("raise", "clamp"):  # which is for what is read, not for what is inspected
        assert asap.check(asap.read(path, **SENSOR, on_bad=on_bad)).findings == found.findings


def test_a_file_that_is_cut_before_its_first_event(tmp_path: Path) -> None:
    np.savez(tmp_path / "events.npz", events=EVENTS)
    corrupt.cut_file(tmp_path / "events.npz", 500)
    (tmp_path / "events.csv").write_text("t,x,y,p\n5,1,x")
    for name, kind, byte in (("events.csv", "text", 8), ("events.npz", "npz", 500)):
        found = check(tmp_path / name)
        assert (found.path, found.format, found.events) == (str(tmp_path / name), kind, 0)
        assert outcome(found)["empty"][:2] == outcome(found)["truncated"][:2] == (1, "wrong")
        assert found.findings["truncated"].byte == byte
    assert "nothing before the end of the file can be read" in str(found)


# ---- sources --------------------------------------------------------------------------------


def test_memory_is_flat() -> None:
    blocks = 24
    stream = (corrupt.clean_events(1 << 16, seed=i, start_us=i * 10**6) for i in range(blocks))
    tracemalloc.start()
    found = check(stream)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert found.events == blocks << 16
    assert peak < found.events * 16 / 2


def test_the_table_has_every_check_and_a_remedy_for_what_is_not_ok() -> None:
    found = check(everything_wrong())
    words = " ".join(str(found).split())
    for name, finding in found.findings.items():
        assert f"{name.replace('_', ' ')} {finding.count:,} {finding.verdict}" in words
        assert finding.remedy in words and bool(finding.remedy) == (finding.verdict != "ok")


# ---- what it tells --------------------------------------------------------------------------


def test_summary_is_plain_json() -> None:
    found = check(everything_wrong())
    summary = json.loads(json.dumps(found.summary(), allow_nan=False))
    assert summary["schema_version"] == 1
    assert summary["verdict"] == "wrong" and not found.ok
    assert summary["source"]["events"] == found.events
    assert summary["checks"]["back_steps"]["event"] == found.findings["back_steps"].event
    assert summary["hot_pixels"] == [
        {"x": 30, "y": 40, "events": int(found.pixel_counts[40, 30])},
    ]
    assert summary["busiest_pixels"][0] == summary["hot_pixels"][0]
    assert repr(found) == f"<Inspection: array, {found.events} events, wrong>"


def test_a_map_of_unknown_size_is_bounded() -> None:
    bad = EVENTS[:100].copy()
    bad["x"][7] = bad["y"][9] = 65_535
    found = asap.check(bad)
    assert found.pixel_counts.sum() == 98
    assert "; 2 events beyond 4096 px" in found.findings["out_of_bounds"].detail


def test_progress_is_told() -> None:
    told: list[Any] = []
    check(EVENTS, on_progress=lambda *given: told.append(given))
    assert told == [(1 << 16, None, {}), (70_000, None, {})]
    options = {"cost": asap.LinearCost(1, 1), "schemes": [asap.Greedy()]}
    asap.compare(EVENTS, **options, on_progress=lambda *given: told.append(given))
    assert told[-1] == (70_000, 70_000, {})
