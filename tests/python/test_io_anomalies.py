"""Bad event data, class by class, through asap.read and asap.load in every own format."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import asap
import corrupt
from asap import _core
from asap.events import Events
from asap.io import CorruptFile, TruncatedFileWarning
from event_files import WRITERS, assert_equal_events, recording

EVENTS = corrupt.clean_events(3000)
SENSOR = {"width": corrupt.WIDTH, "height": corrupt.HEIGHT}

Write = Callable[[Events], Path]


@pytest.fixture(params=WRITERS)
def write(request: pytest.FixtureRequest, tmp_path: Path) -> Write:
    """Write events into a file of each format."""

    def to_file(events: Events) -> Path:
        path = tmp_path / f"events.{request.param}"
        WRITERS[request.param](path, events)
        return path

    return to_file


def read_all(path: Path, **options: object) -> tuple[Events, asap.io.Recording]:
    """Events and the recording with its counters; load must give the same events."""
    rec = asap.read(path, **SENSOR, **options)  # type: ignore[arg-type]
    chunks = list(rec)
    events = np.concatenate(chunks) if chunks else np.zeros(0, asap.EVENT_DTYPE)
    assert rec.received == len(events) + sum(rec.rejected.values())
    assert (np.diff(events["t"]) >= 0).all()
    lost = sum(rec.rejected.values()) + rec.clock_resets > 0
    with pytest.warns(UserWarning, match=str(path)) if lost else nullcontext():
        loaded = asap.load(path, **SENSOR, **options)  # type: ignore[arg-type]
    assert_equal_events(loaded, events)
    return events, rec


def only(**reasons: int) -> dict[str, int]:
    zero = dict.fromkeys(
        ("nonmonotonic", "out_of_bounds", "bad_polarity", "bad_record", "before_start"), 0
    )
    return zero | reasons


def test_clean_events_pass_untouched(write: Write) -> None:
    events, rec = read_all(write(EVENTS))
    assert_equal_events(events, EVENTS)
    assert rec.rejected == only()
    assert set(rec.repaired.values()) == {0}
    assert rec.clock_resets == 0


def test_A1_back_step_is_dropped_and_counted(write: Write) -> None:
    bad = corrupt.back_steps(EVENTS, 40)
    events, rec = read_all(write(bad))
    assert rec.rejected == only(nonmonotonic=40)
    assert_equal_events(events, EVENTS[bad["t"] == EVENTS["t"]])


def test_A1_back_step_within_the_tolerance_is_lifted(write: Write) -> None:
    bad = corrupt.back_steps(EVENTS, 40, by_us=100)
    events, rec = read_all(write(bad), reorder_tolerance_us=100)
    assert rec.rejected == only()
    assert rec.repaired["lifted_stamps"] == 40
    np.testing.assert_array_equal(events["t"], np.maximum.accumulate(bad["t"]))


def test_A1_back_step_is_lifted_by_clamp_and_raised_by_raise(write: Write) -> None:
    bad = corrupt.back_steps(EVENTS, 1)
    path = write(bad)
    events, rec = read_all(path, on_bad="clamp")
    assert len(events) == len(EVENTS)
    assert rec.repaired["lifted_stamps"] == 1
    at = int(np.argmax(bad["t"] != EVENTS["t"]))
    with pytest.raises(ValueError, match=rf"t = {bad['t'][at]} \(event {at}\): goes back"):
        asap.load(path, on_bad="raise")


@pytest.mark.parametrize("bit", [12, 19, 21, 40])
@pytest.mark.parametrize("at", [1, 255, 256, 1500, 2997])
def test_A1_a_flipped_bit_of_a_stamp_loses_one_event(write: Write, bit: int, at: int) -> None:
    bad = EVENTS.copy()
    bad["t"][at] ^= 1 << bit
    path = write(bad)
    events, rec = read_all(path)
    assert rec.rejected == only(nonmonotonic=1)
    assert rec.clock_resets == 0
    assert_equal_events(events, np.delete(EVENTS, at))
    finding = asap.check(path, **SENSOR).findings["back_steps"]
    assert (finding.count, finding.event) == (1, at)


def test_load_tells_what_it_dropped(write: Write) -> None:
    bad = corrupt.clock_reset(corrupt.back_steps(EVENTS, 3), 2000)
    path = write(bad)
    with pytest.warns(UserWarning) as told:
        asap.load(path)
    words = sorted(str(warning.message) for warning in told)
    assert words[0].startswith(f"{path}: the clock jumped back 1 times by 1 s or more")
    assert words[1] == f"{path}: without the events that were rejected: 3 nonmonotonic"
    assert {warning.filename for warning in told} == {__file__}


def test_A2_clock_reset_starts_a_new_epoch(write: Write) -> None:
    bad = corrupt.clock_reset(EVENTS, 1000)
    events, rec = read_all(write(bad))
    assert rec.rejected == only()
    assert rec.clock_resets == 1
    np.testing.assert_array_equal(events["t"][:1000], EVENTS["t"][:1000])
    assert events["t"][1000] == events["t"][999] + 1
    np.testing.assert_array_equal(np.diff(events["t"][1000:]), np.diff(EVENTS["t"][1000:]))


def test_A2_wrap_of_a_counter_is_unwrapped(write: Write) -> None:
    start = 2**31 - int(EVENTS["t"][1500])
    shifted = EVENTS.copy()
    shifted["t"] += start
    bad = shifted.copy()
    bad["t"] %= 2**31
    events, rec = read_all(write(bad))
    assert rec.clock_resets == 1
    assert len(events) == len(EVENTS)
    np.testing.assert_array_equal(np.diff(events["t"][1500:]), np.diff(shifted["t"][1500:]))


def test_A5_pixels_outside_the_sensor_are_dropped_and_counted(write: Write) -> None:
    bad = corrupt.outside_sensor(EVENTS, 60)
    inside = (bad["x"] < corrupt.WIDTH) & (bad["y"] < corrupt.HEIGHT)
    events, rec = read_all(write(bad))
    assert rec.rejected == only(out_of_bounds=60)
    assert_equal_events(events, EVENTS[inside])


def test_A5_pixels_outside_the_sensor_are_clamped_or_raised(write: Write) -> None:
    bad = corrupt.outside_sensor(EVENTS, 60)
    path = write(bad)
    events, rec = read_all(path, on_bad="clamp")
    assert rec.repaired["clamped_positions"] == 60
    np.testing.assert_array_equal(events["x"], np.minimum(bad["x"], corrupt.WIDTH - 1))
    with pytest.raises(ValueError, match=r"[xy] = \d+ \(event \d+\): outside the sensor"):
        asap.load(path, **SENSOR, on_bad="raise")


def test_A5_without_a_sensor_nothing_is_checked(write: Write) -> None:
    bad = corrupt.outside_sensor(EVENTS, 60)
    assert_equal_events(asap.load(write(bad)), bad)


def test_A6_many_events_on_one_stamp_all_pass(write: Write) -> None:
    events, rec = read_all(write(corrupt.one_stamp(EVENTS, 500, 600)))
    assert rec.rejected == only()
    assert np.unique(events["t"], return_counts=True)[1].max() == 600


def test_A8_polarity_is_normalised_and_counted(write: Write) -> None:
    events, rec = read_all(write(corrupt.odd_polarity(EVENTS, 80)))
    assert rec.rejected == only()
    assert rec.repaired["normalised_polarity"] == 80
    assert_equal_events(events, EVENTS)


def test_A8_duplicates_all_pass(write: Write) -> None:
    bad = corrupt.duplicates(EVENTS, 80)
    events, rec = read_all(write(bad))
    assert len(bad) == len(EVENTS) + 80
    assert_equal_events(events, bad)
    assert rec.rejected == only()


@pytest.mark.parametrize("count", [0, 1])
def test_A9_none_or_one_event(write: Write, count: int) -> None:
    path = write(EVENTS[:count])
    if path.suffix == ".txt" and count == 0:
        path.write_text("# no events\n")
    events, rec = read_all(path)
    assert_equal_events(events, EVENTS[:count])
    assert rec.received == count


def test_A10_a_year_of_silence_is_no_fault(write: Write) -> None:
    quiet = corrupt.gap(EVENTS, 100, 365 * 24 * 3600 * 10**6)
    events, rec = read_all(write(quiet))
    assert_equal_events(events, quiet)
    assert rec.clock_resets == 0
    assert rec.rejected == only()


@pytest.mark.parametrize("suffix", ["npy", "txt", "csv"])
def test_A13_truncated_file_keeps_what_is_good(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"events.{suffix}"
    WRITERS[suffix](path, EVENTS)
    whole = path.read_bytes()
    record = 16 if suffix == "npy" else len(whole.splitlines()[-1]) + 1
    cut = len(whole) - 10 * record - 6
    good_bytes = len(whole) - 11 * 16 if suffix == "npy" else whole[:cut].rfind(b"\n") + 1
    corrupt.cut_file(path, cut)

    with pytest.warns(TruncatedFileWarning, match=f"byte {good_bytes}:"):
        events = asap.load(path)
    assert len(EVENTS) - 13 < len(events) < len(EVENTS) - 9
    assert_equal_events(events, EVENTS[: len(events)])
    with pytest.raises(CorruptFile, match=f"byte {good_bytes}:"):
        asap.load(path, on_bad="raise")


def test_A13_cut_npz_is_an_error_with_an_offset(tmp_path: Path) -> None:
    path = tmp_path / "events.npz"
    WRITERS["npz"](path, EVENTS)
    there = path.stat().st_size // 2
    corrupt.cut_file(path, there)
    words = f"byte {there}: .*; nothing can be read of the {there} bytes .* this npz file. Copy it"
    with pytest.raises(CorruptFile, match=words):
        asap.load(path)


def test_A13_flipped_byte_in_npz_is_found(tmp_path: Path) -> None:
    path = tmp_path / "events.npz"
    np.savez(path, **{name: EVENTS[name] for name in "txyp"})
    data = bytearray(path.read_bytes())
    data[300] ^= 1
    path.write_bytes(bytes(data))
    with pytest.raises(CorruptFile, match="CRC"):
        asap.load(path)


@pytest.mark.parametrize("suffix", ["npy", "npz", "txt"])
def test_A13_nothing_good_at_all_is_an_error(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"events.{suffix}"
    WRITERS[suffix](path, EVENTS)
    corrupt.cut_file(path, {"npy": 130, "npz": 20, "txt": 12}[suffix])
    with pytest.raises(ValueError, match=r"byte \d+|columns"):
        asap.load(path)


def test_A13_header_that_lies_about_the_count(tmp_path: Path) -> None:
    path = tmp_path / "events.npy"
    np.save(path, EVENTS)
    path.write_bytes(path.read_bytes().replace(b"(3000,)", b"(9000,)"))
    with pytest.warns(TruncatedFileWarning, match=f"byte {path.stat().st_size}: 3000 of 9000"):
        assert_equal_events(asap.load(path), EVENTS)


def test_A13_text_with_torn_lines(tmp_path: Path) -> None:
    path = tmp_path / "events.txt"
    WRITERS["txt"](path, EVENTS)
    lines = path.read_text().splitlines()
    for at in (0, 700, 1400):
        lines[at] = lines[at][:9]
    path.write_text("\n".join(lines) + "\n")
    events, rec = read_all(path)
    assert rec.rejected == only(bad_record=3)
    assert_equal_events(events, np.delete(EVENTS, [0, 700, 1400]))
    assert len(rec.bad_offsets) == 3


@pytest.mark.parametrize("share", [0.3, 0.6, 0.97])
def test_A13_half_an_aedat4_keeps_its_packets(tmp_path: Path, share: float) -> None:
    pytest.importorskip("lz4")
    whole_path = recording("aedat/office_davis346.aedat4")
    whole = asap.load(whole_path)
    path = tmp_path / "half.aedat4"
    path.write_bytes(whole_path.read_bytes())
    corrupt.cut_file(path, int(share * path.stat().st_size))
    with pytest.warns(TruncatedFileWarning, match=r"byte \d+: no whole packet follows"):
        events = asap.load(path)
    assert 0.2 * share * len(whole) < len(events) < len(whole)
    assert_equal_events(events, whole[: len(events)])
    with pytest.raises(CorruptFile, match="byte"):
        asap.load(path, on_bad="raise")


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.filterwarnings("ignore::asap.io.LossWarning")
def test_A13_damaged_aedat4_raises_only_what_is_promised(tmp_path: Path, seed: int) -> None:
    pytest.importorskip("lz4")
    path = tmp_path / "damaged.aedat4"
    path.write_bytes(recording("aedat/cars_davis346.aedat4").read_bytes())
    corrupt.flip_bytes(path, 20, seed=seed, first=4000 if seed % 2 else 14)
    try:
        events = asap.load(path)
    except (ValueError, OSError, RuntimeError):
        return
    assert (np.diff(events["t"]) >= 0).all()


EVENT = st.tuples(
    st.integers(0, 400), st.integers(0, 300), st.integers(-3, 3),
    st.one_of(st.integers(0, 300), st.integers(-(2**63), 2**63 - 1)),
)  # fmt: skip


@settings(deadline=None)
@given(st.lists(EVENT, max_size=60), st.sampled_from(["drop", "clamp"]), st.integers(0, 50))
def test_validated_output_never_goes_back_and_the_ledger_is_exact(
    rows: list[tuple[int, ...]], on_bad: str, tolerance_us: int
) -> None:
    events = np.array(rows, asap.EVENT_DTYPE)
    validator = _core.Validator(**SENSOR, on_bad=on_bad, reorder_tolerance_us=tolerance_us)
    good = validator.check(events)
    assert validator.received == len(events) == len(good) + sum(validator.rejected.values())
    assert (np.diff(good["t"]) >= 0).all()
    assert (good["x"] < corrupt.WIDTH).all() and (good["y"] < corrupt.HEIGHT).all()
    assert set(good["p"].tolist()) <= {0, 1}
