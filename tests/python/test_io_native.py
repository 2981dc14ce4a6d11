"""Prophesee RAW and DAT files: triggers, bad words, headers; every event: test_io_records.py."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import asap
import raw_files
from asap.io import CorruptFile, UnsupportedFormat
from corrupt import clean_events

EVENTS = clean_events(2000)


def raw(tmp_path: Path, words: list[int], encoding: str = "3.0", dtype: str = "<u2") -> Path:
    file = tmp_path / "some.raw"
    file.write_bytes(f"% evt {encoding}\n".encode() + np.array(words, dtype).tobytes())
    return file


def evt3(kind: int, value: int) -> int:
    return kind << 12 | value


Y, X, LOW, HIGH, TRIGGER = 0, 2, 6, 8, 10


class TestTriggers:
    def check(self, path: Path, expected: list[tuple[int, int, int]]) -> None:
        rec = asap.read(path)
        assert len(rec.triggers) == rec.trigger_count == 0
        for _ in range(2):
            assert sum(map(len, rec)) == 1
            assert rec.triggers.dtype.names == ("t", "id", "value")
            assert rec.triggers.tolist() == expected
            assert rec.trigger_count == len(expected)

    def test_evt2(self, tmp_path: Path) -> None:
        words = [8 << 28 | 1, 10 << 28 | 5 << 22 | 6 << 8 | 1, 1 << 28, 10 << 28 | 7 << 22]
        self.check(raw(tmp_path, words, "2.0", "<u4"), [(69, 6, 1), (71, 0, 0)])

    def test_evt21(self, tmp_path: Path) -> None:
        words = [8 << 60 | 1 << 32, 10 << 60 | 5 << 54 | 6 << 40 | 1 << 32, 1 << 60 | 1]
        legacy = [word >> 32 | (word & 0xFFFFFFFF) << 32 for word in words]
        self.check(raw(tmp_path, legacy, "2.1", "<u8"), [(69, 6, 1)])

    def test_evt3(self, tmp_path: Path) -> None:
        words = [evt3(HIGH, 1), evt3(LOW, 2), evt3(TRIGGER, 6 << 8 | 1), evt3(Y, 1), evt3(X, 1)]
        self.check(raw(tmp_path, words), [(4098, 6, 1)])


class TestBadWords:
    def test_are_counted_with_their_offsets(self, tmp_path: Path) -> None:
        words = [evt3(HIGH, 1), evt3(Y, 1), evt3(X, 1), evt3(13, 5), evt3(X, 2), evt3(1, 0)]
        path = raw(tmp_path, words)
        rec = asap.read(path)
        assert np.concatenate(list(rec))["x"].tolist() == [1, 2]
        assert rec.rejected["bad_record"] == 2
        assert rec.bad_offsets == (len("% evt 3.0\n") + 6, len("% evt 3.0\n") + 10)
        with pytest.raises(CorruptFile, match="byte 16: no record of a file in evt3"):
            asap.load(path, on_bad="raise")

    def test_events_before_the_first_time_are_counted(self, tmp_path: Path) -> None:
        rec = asap.read(raw(tmp_path, [evt3(Y, 1), evt3(X, 1), evt3(HIGH, 0), evt3(X, 2)]))
        assert sum(map(len, rec)) == 1
        assert rec.rejected["before_start"] == 1
        assert rec.received == 2


class TestWithoutAHeader:
    @pytest.mark.parametrize("suffix", [".raw", ".dat"])
    def test_bytes_are_corrupt(self, tmp_path: Path, suffix: str) -> None:
        path = tmp_path / f"some{suffix}"
        path.write_bytes(raw_files.evt2_words(EVENTS).tobytes())
        with pytest.raises(CorruptFile, match=rf"byte 0: not the beginning of a {suffix} file"):
            asap.read(path)

    def test_another_encoding_is_named_as_such(self, tmp_path: Path) -> None:
        path = tmp_path / "some.raw"
        path.write_bytes(b"% evt 4.0\n% end\n" + bytes(16))
        with pytest.raises(UnsupportedFormat, match=r"this Prophesee encoding .*evt2, evt21"):
            asap.read(path)
