"""Every format that the core decodes: every event, every cut; of AEDAT and ATIS what is none."""

from __future__ import annotations

import warnings
from bisect import bisect_right
from pathlib import Path

import numpy as np
import pytest

import asap
import corrupt
from asap import _core
from asap.events import Events
from asap.io import CorruptFile, TruncatedFileWarning, UnsupportedFormat
from event_files import assert_equal_events
from record_files import FORMATS, SIDE, Format, aedat2, aedat3, atis40

EVENTS = corrupt.clean_events(1000, start_us=7_000_000)
EVENTS["x"] %= SIDE
EVENTS["y"] %= SIDE


@pytest.fixture(params=FORMATS.values(), ids=FORMATS)
def form(request: pytest.FixtureRequest) -> Format:
    found: Format = request.param
    return found


def file_of(tmp_path: Path, content: bytes, name: str) -> Path:
    path = tmp_path / name
    path.write_bytes(content)
    return path


def written(form: Format, events: Events, folder: Path) -> Path:
    path = folder / f"a{form.suffix}"
    form.write(path, events)
    return path


def test_every_format_of_the_core_is_here() -> None:
    assert {form.name for form in FORMATS.values()} == {*_core.RECORDING_FORMATS}


def test_every_event_is_read(form: Format, tmp_path: Path) -> None:
    path = written(form, EVENTS, tmp_path)
    rec = asap.read(path, on_bad="raise", height=form.height)
    for _ in range(2):
        assert_equal_events(np.concatenate(list(rec)), EVENTS)
        assert rec.received == len(EVENTS)
    height = form.side or form.height
    assert (rec.format, rec.width, rec.height) == (form.name, form.side, height)
    assert rec.truncated_at is None


def test_pieces_and_chunks_make_no_difference(form: Format, tmp_path: Path) -> None:
    many = corrupt.clean_events(150_000)
    for axis in "xy":
        many[axis] %= SIDE
    chunks = list(asap.read(written(form, many, tmp_path), height=form.height))
    assert len(chunks) > 2
    assert_equal_events(np.concatenate(chunks), many)


def test_decode_into_says_how_far_it_came(form: Format, tmp_path: Path) -> None:
    path = written(form, EVENTS, tmp_path)
    opened = _core.OpenedRecording(path, form.name, height=form.height or 0)
    words = path.read_bytes()[opened.start :]
    decoder, out = opened.decoder(opened.start), np.empty(len(EVENTS), asap.EVENT_DTYPE)
    used, count = decoder.decode_into(words, out[:100])
    assert count == 100 and 0 < used < len(words)
    assert decoder.decode_into(words[used:], out[100:]) == (len(words) - used, len(EVENTS) - 100)
    assert_equal_events(out, EVENTS)


def test_no_events(form: Format, tmp_path: Path) -> None:
    path = written(form, EVENTS[:0], tmp_path)
    if path.stat().st_size == 0:
        with pytest.raises(CorruptFile, match="byte 0: the file is empty"):
            asap.read(path, file_format=form.name)
    else:
        assert len(asap.load(path, height=form.height)) == 0


def test_cut_at_every_byte(form: Format, tmp_path: Path) -> None:
    """All events that are whole, and the byte from which on something is missing."""
    events = EVENTS[:12].copy()
    events["t"] -= 6_999_000
    sizes = [events[:count] for count in range(len(events) + 1)]
    ends = [written(form, some, tmp_path).stat().st_size for some in sizes]
    content = (tmp_path / f"a{form.suffix}").read_bytes()
    for size in range(max(ends[0], 1), len(content)):
        whole = bisect_right(ends, size) - 1
        path = file_of(tmp_path, content[:size], f"a{form.suffix}")
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            rec = asap.read(path, file_format=form.name, height=form.height)
            try:
                read = np.concatenate([events[:0], *rec])
            except CorruptFile as error:  # not one whole event
                assert error.offset == rec.truncated_at
                read = events[:0]
        assert_equal_events(read, events[:whole])
        cuts = [str(w.message) for w in caught if issubclass(w.category, TruncatedFileWarning)]
        if rec.truncated_at is None:  # between two records, some of which hold time alone
            assert form.name in ("es", "evt2", "evt21", "evt3") or size == ends[whole]
            assert cuts == []
        else:
            first = ends[0] if form.name == "aedat3" else ends[whole]
            assert first <= rec.truncated_at < size
            assert f"byte {rec.truncated_at}: " in cuts[0]


# ---- 40-bit events: nothing in the bytes says what they are ------------------------------------


def test_what_does_not_look_like_40_bit_events_warns(tmp_path: Path) -> None:
    odd = EVENTS.copy()
    odd["t"][::10] -= 1000
    odd["y"] = 250
    with pytest.warns(UserWarning, match=r"time goes back \d+ times in \d+ events and \d+ of"):
        asap.read(file_of(tmp_path, atis40(odd), "a.bin"))
    whole = atis40(EVENTS)
    with pytest.warns(UserWarning, match="its 5002 bytes are no multiple of 5; .* file_format"):
        rec = asap.read(file_of(tmp_path, whole + b"\0\0", "a.bs2"))
    with pytest.warns(TruncatedFileWarning, match="byte 5000"):
        assert len(np.concatenate(list(rec))) == len(EVENTS)


def test_bytes_whose_times_go_back_are_no_40_bit_events(tmp_path: Path) -> None:
    noise = np.random.default_rng(1).integers(0, 256, 5000, np.uint8).tobytes()
    words = r"byte 0: no 40-bit events: the time goes back \d+ times in \d+; .* file_format"
    with pytest.raises(CorruptFile, match=words):
        asap.read(file_of(tmp_path, noise, "a.bin"))


# ---- what is not read, and why -----------------------------------------------------------------


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"Event Stream\x02\x00\x00\x02" + bytes(8), "Event Stream of type atis"),
        (b"Event Stream\x03\x00\x00\x01" + bytes(8), "no whole header of Event Stream 1 or 2"),
        (aedat2(EVENTS, "# AEChip: com.sec.dvs.SecDvs640Gen2\r\n"), "names another chip"),
        (aedat2(EVENTS, ""), "does not say which chip it is of"),
        (aedat3(EVENTS, "#Format: SerializedTS\r\n"), "compressed AEDAT 3.1"),
        (b"#!AER-DAT1.0\r\n" + bytes(100), "AEDAT 1.0"),
    ],
)
def test_what_is_not_read_says_so(content: bytes, words: str, tmp_path: Path) -> None:
    with pytest.raises((CorruptFile, UnsupportedFormat), match=words):
        asap.read(file_of(tmp_path, content, "a.aedat"))


def test_an_unnamed_davis_needs_its_size(tmp_path: Path) -> None:
    path = file_of(tmp_path, aedat2(EVENTS, "# HardwareInterface: DAVIS FX2\r\n"), "a.aedat")
    assert_equal_events(asap.load(path, width=128, height=128), EVENTS)
    path = file_of(tmp_path, aedat2(EVENTS, ""), "b.aedat")
    with pytest.raises(UnsupportedFormat, match="give width and height"):
        asap.read(path, width=128)
    assert_equal_events(asap.load(path, width=128, height=128), EVENTS)
