"""AEDAT4: packets, several cameras, compression, files that were cut or damaged."""

from __future__ import annotations

import struct
import warnings
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import asap
import corrupt
from aedat4_files import packet, write_aedat4
from asap.events import Events
from asap.io import CorruptFile, NoGoodEvent, TruncatedFileWarning
from event_files import assert_equal_events, recording

EVENTS = corrupt.clean_events(10_000)
RECORDINGS = ("aedat/office_davis346.aedat4", "aedat/cars_davis346.aedat4")


def in_packets(events: Events, size: int) -> list[tuple[int, Events]]:
    return [(0, events[at : at + size]) for at in range(0, len(events), size)]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "a.aedat4"


@pytest.mark.parametrize("compression", [0, 1, 2, 3, 4])
def test_packets_of_any_size(path: Path, compression: int) -> None:
    cuts = (0, 1, 1, 3, 5000, 10_000)
    packets = [(0, EVENTS[first:last]) for first, last in pairwise(cuts)]
    write_aedat4(path, packets, compression=compression)
    rec = asap.read(path)
    assert (rec.format, rec.width, rec.height, rec.streams) == ("aedat4", 346, 260, ("0",))
    assert_equal_events(np.concatenate(list(rec)), EVENTS)
    assert rec.truncated_at is None


@pytest.mark.parametrize("name", RECORDINGS)
def test_agrees_with_the_library_of_the_format(name: str) -> None:
    aedat = pytest.importorskip("aedat")
    packets = [p["events"] for p in aedat.Decoder(str(recording(name))) if "events" in p]
    assert_equal_events(asap.load(recording(name)), asap.as_events(np.concatenate(packets)))


class TestStreams:
    def test_several_cameras_are_a_question(self, path: Path) -> None:
        packets = [(0, EVENTS[:100]), (1, EVENTS[100:200]), (0, EVENTS[200:300])]
        write_aedat4(path, packets, streams=((346, 260), (640, 480)))
        words = r"holds 2 streams of events \(0 \(346x260\), 1 \(640x480\)\); choose one, such as"
        with pytest.raises(ValueError, match=words):
            asap.read(path)
        rec = asap.read(path, stream="1")
        assert (rec.width, rec.height) == (640, 480)
        assert_equal_events(np.concatenate(list(rec)), EVENTS[100:200])
        rest = np.concatenate((EVENTS[:100], EVENTS[200:300]))
        assert_equal_events(asap.load(path, stream="0"), rest)

    def test_packets_of_unknown_streams_are_skipped(self, path: Path) -> None:
        write_aedat4(path, [(0, EVENTS[:10]), (7, EVENTS[10:20]), (0, EVENTS[20:30])])
        rest = np.concatenate((EVENTS[:10], EVENTS[20:30]))
        assert_equal_events(asap.load(path), rest)


class TestDamage:
    def test_cut_at_every_byte(self, path: Path) -> None:
        write_aedat4(path, [])
        starts = [path.stat().st_size]  # where each packet begins
        for count in range(5, 20, 5):
            write_aedat4(path, in_packets(EVENTS[:count], 5))
            starts.append(path.stat().st_size)
        content = path.read_bytes()
        for size in range(14, starts[0]):
            path.write_bytes(content[:size])
            with pytest.raises(CorruptFile, match="byte 14: "):
                asap.load(path)
        for size in range(starts[0], len(content)):
            path.write_bytes(content[:size])
            whole = sum(start <= size for start in starts[1:])
            with warnings.catch_warnings(record=True) as warned:
                warnings.simplefilter("always")
                if whole or size == starts[0]:
                    assert_equal_events(asap.load(path), EVENTS[: 5 * whole])
                else:
                    with pytest.raises(CorruptFile):
                        asap.load(path)
            if size not in starts:  # else nothing tells that more was there
                (warning,) = warned
                assert warning.category is TruncatedFileWarning
                assert f"byte {starts[whole]}: " in str(warning.message)

    def test_the_table_behind_the_packets_is_cut(self, tmp_path: Path) -> None:
        pytest.importorskip("lz4")
        whole = recording("aedat/cars_davis346.aedat4")
        content = whole.read_bytes()
        events = asap.load(whole)
        for there in (len(content) - 5, len(content) - 900):  # its end mark takes 4 bytes
            (tmp_path / "a.aedat4").write_bytes(content[:there])
            words = f"byte {there}: the table of all packets, which ends it, is cut"
            with pytest.warns(TruncatedFileWarning, match=words):
                assert_equal_events(asap.load(tmp_path / "a.aedat4"), events)

    @pytest.mark.filterwarnings("ignore::asap.io.LossWarning")
    def test_offsets_out_of_the_packet_lead_nowhere(self, path: Path) -> None:
        write_aedat4(path, [])
        header, good = path.read_bytes(), packet(EVENTS[:3])
        refused = 0
        for at in range(4, 32):
            for number in (0, 1, 2**15, 2**31 - 1, 2**31, 2**32 - 1):
                bad = good[:at] + struct.pack("<I", number) + good[at + 4 :]
                path.write_bytes(header + struct.pack("<ii", 0, len(bad)) + bad)
                try:
                    assert len(asap.load(path)) <= 3
                except (CorruptFile, NoGoodEvent):
                    refused += 1
        assert refused > 100

    def test_what_is_before_a_damaged_packet_is_kept(self, path: Path) -> None:
        write_aedat4(path, in_packets(EVENTS[:30], 10))
        content = path.read_bytes()
        second = content.index(packet(EVENTS[10:20])) - 8
        path.write_bytes(content[: second + 16] + b"FRME" + content[second + 20 :])
        words = f"byte {second}: EVTS is needed, the packet is b'FRME'"
        rec = asap.read(path)
        with pytest.warns(TruncatedFileWarning, match=f"{words}; what came before was read"):
            assert_equal_events(np.concatenate(list(rec)), EVENTS[:10])
        assert rec.truncated_at == second
        with pytest.raises(CorruptFile, match=words):
            asap.load(path, on_bad="raise")

    @pytest.mark.parametrize("compression", [1, 3])
    def test_packets_that_unpack_to_more_than_any_good_one(
        self, path: Path, monkeypatch: pytest.MonkeyPatch, compression: int
    ) -> None:
        monkeypatch.setattr(asap.io.aedat4, "MAX_RATIO", 10)
        write_aedat4(path, [(0, np.zeros(100_000, asap.EVENT_DTYPE))], compression=compression)
        with (
            pytest.warns(TruncatedFileWarning, match="100000 events promised, .* are there"),
            pytest.raises(CorruptFile),
        ):
            asap.load(path)

    def test_a_text_of_the_header_that_grows_without_end(self, path: Path) -> None:
        write_aedat4(path, [])
        content = path.read_bytes()
        text = content[content.index(b"<dv") : content.index(b"</dv>") + 5]
        bomb = b'<!DOCTYPE d [<!ENTITY a "aaaaaaaaaa">]><dv>&a;</dv>'
        path.write_bytes(content.replace(text, bomb.ljust(len(text))))
        with pytest.raises(CorruptFile, match="defines entities"):
            asap.read(path)
