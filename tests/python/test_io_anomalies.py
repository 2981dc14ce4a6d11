"""Files that are cut or damaged, and what is told of their events; others: test_anomalies.py."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import asap
import corrupt
from asap.events import Events
from asap.io import CorruptFile, TruncatedFileWarning
from event_files import WRITERS, assert_equal_events
from record_files import FORMATS, PLAIN, SIDE, Format

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


@pytest.mark.parametrize("bit", [12, 19, 21, 40])
@pytest.mark.parametrize("at", [1, 255, 256, 1500, 2997])
def test_A1_a_flipped_bit_of_a_stamp_loses_one_event(write: Write, bit: int, at: int) -> None:
    bad = EVENTS.copy()
    bad["t"][at] ^= 1 << bit
    path = write(bad)
    rec = asap.read(path)
    assert_equal_events(np.concatenate(list(rec)), np.delete(EVENTS, at))
    assert rec.rejected["nonmonotonic"] == sum(rec.rejected.values()) == 1
    assert rec.clock_resets == 0
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
    rec = asap.read(path)
    assert_equal_events(np.concatenate(list(rec)), np.delete(EVENTS, [0, 700, 1400]))
    assert rec.rejected["bad_record"] == len(rec.bad_offsets) == 3


SMALL = corrupt.clean_events(20_000)
for axis in "xy":
    SMALL[axis] %= SIDE


def convert(path: Path, events: Events) -> None:
    asap.convert(events, path, width=SIDE, height=SIDE)


ZEROED = FORMATS | PLAIN | {"aedat4": Format(convert, "aedat4", ".aedat4")}
del ZEROED["npz"]


@pytest.mark.parametrize("name", ZEROED)
def test_zeros_to_the_end_are_named_and_no_events(tmp_path: Path, name: str) -> None:
    if name == "aedat4":
        pytest.importorskip("lz4")
    form = ZEROED[name]
    path, told = tmp_path / f"events{form.suffix}", {"height": form.height}
    form.write(path, SMALL)
    whole = asap.load(path, **told)
    content = path.read_bytes()
    half = len(content) // 2
    path.write_bytes(content[:half] + bytes(len(content) - half))
    rec = asap.read(path, **told)
    with pytest.warns(TruncatedFileWarning, match=r"byte \d+: "):
        events = np.concatenate(list(rec))
    assert len(whole) / 4 < len(events) < len(whole) * 3 / 4
    assert_equal_events(events, whole[: len(events)])
    assert sum(rec.rejected.values()) == rec.clock_resets == 0
    assert rec.truncated_at is not None and abs(rec.truncated_at - half) < 20_000
    finding = asap.check(rec).findings["truncated"]
    assert (finding.verdict, finding.byte) == ("wrong", rec.truncated_at)
