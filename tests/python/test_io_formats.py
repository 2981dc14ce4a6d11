"""asap.read and asap.load: formats, options, laziness, errors."""

from __future__ import annotations

import io
import pickle
import random
import zipfile
from decimal import Decimal
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import asap
import corrupt
from asap import _core
from asap.events import Events
from asap.io import CorruptFile, UnsupportedFormat
from event_files import WRITERS, assert_equal_events

EVENTS = corrupt.clean_events(1000)


@pytest.fixture(params=WRITERS)
def path(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """A file of EVENTS in each format."""
    file = tmp_path / f"events.{request.param}"
    WRITERS[request.param](file, EVENTS)
    return file


def text(tmp_path: Path, content: str, name: str = "events.txt") -> Path:
    file = tmp_path / name
    file.write_text(content)
    return file


def txyp(events: Events) -> list[tuple[int, ...]]:
    return [tuple(int(event[name]) for name in "txyp") for event in events]


class TestEveryFormat:
    def test_load_gives_the_events(self, path: Path) -> None:
        events = asap.load(path)
        assert_equal_events(events, EVENTS)
        events["x"][0] = 1  # it belongs to the caller

    def test_read_can_be_iterated_again(self, path: Path) -> None:
        rec = asap.read(path, width=corrupt.WIDTH, height=corrupt.HEIGHT)
        for _ in range(2):
            assert_equal_events(np.concatenate(list(rec)), EVENTS)
            assert rec.received == len(EVENTS)
        assert rec.path == path
        assert (rec.width, rec.height) == (corrupt.WIDTH, corrupt.HEIGHT)

    def test_reading_counts_begin_anew(self, path: Path) -> None:
        rec = asap.read(path, width=100)
        for _ in range(2):
            kept = sum(len(chunk) for chunk in rec)
            assert rec.rejected["out_of_bounds"] == np.count_nonzero(EVENTS["x"] >= 100)
            assert rec.received == kept + sum(rec.rejected.values()) == len(EVENTS)

    def test_content_goes_before_the_name(self, path: Path) -> None:
        assert_equal_events(asap.load(path.rename(path.with_name("events.dvs"))), EVENTS)

    def test_str_paths(self, path: Path) -> None:
        assert len(asap.load(str(path))) == len(EVENTS)

    def test_no_events(self, path: Path) -> None:
        WRITERS[path.suffix[1:]](path, EVENTS[:0])
        if path.suffix == ".txt":
            path.write_text("# nothing happened\n")
        assert len(asap.load(path)) == 0
        assert list(asap.read(path)) == []

    def test_on_bad_is_checked(self, path: Path) -> None:
        with pytest.raises(ValueError, match="on_bad = 'keep'"):
            asap.read(path, on_bad="keep")

    def test_sizes_are_checked(self, path: Path) -> None:
        with pytest.raises(ValueError, match="width = -1"):
            asap.read(path, width=-1)
        with pytest.raises(ValueError, match="height = 70000"):
            asap.read(path, height=70000)
        with pytest.raises(ValueError, match=f"width = {2**40}"):
            asap.read(path, width=2**40)


class TestNpy:
    def test_own_dtype_is_mapped_not_copied(self, tmp_path: Path) -> None:
        np.save(tmp_path / "events.npy", EVENTS)
        (chunk,) = asap.read(tmp_path / "events.npy")
        assert not chunk.flags.writeable
        assert not chunk.flags.owndata

    def test_comes_in_chunks(self, tmp_path: Path) -> None:
        events = corrupt.clean_events(200_000)
        np.save(tmp_path / "events.npy", events)
        chunks = list(asap.read(tmp_path / "events.npy"))
        assert max(map(len, chunks)) <= 1 << 16
        assert_equal_events(np.concatenate(chunks), events)

    def test_packed_and_in_another_order(self, tmp_path: Path) -> None:
        packed = np.zeros(1000, [("t", "<u8"), ("y", "u2"), ("x", "u2"), ("on", "?")])
        for name, source in (("t", "t"), ("y", "y"), ("x", "x"), ("on", "p")):
            packed[name] = EVENTS[source]
        np.save(tmp_path / "events.npy", packed)
        assert_equal_events(asap.load(tmp_path / "events.npy"), EVENTS)

    @pytest.mark.parametrize("memory_order", ["C", "F"])
    def test_rows_with_order(self, tmp_path: Path, memory_order: Any) -> None:
        rows = np.stack([EVENTS[name] for name in "xytp"], axis=1).astype("f8", memory_order)
        rows[:, 2] /= 1e6
        np.save(tmp_path / "events.npy", rows)
        assert_equal_events(asap.load(tmp_path / "events.npy", order="xytp"), EVENTS)
        words = r"events\.npy: order = None: an array of shape \(1000, 4\) .* order='txyp'"
        with pytest.raises(ValueError, match=words):
            asap.read(tmp_path / "events.npy")

    def test_three_columns_need_three_letters(self, tmp_path: Path) -> None:
        np.save(tmp_path / "events.npy", np.zeros((9, 3), int))
        with pytest.raises(ValueError, match=r"shape \(9, 3\) .* order='txy',"):
            asap.read(tmp_path / "events.npy")

    def test_cut_by_columns_nothing_is_whole(self, tmp_path: Path) -> None:
        rows = np.stack([EVENTS[name] for name in "txyp"], axis=1).astype("i8", "F")
        np.save(tmp_path / "events.npy", rows)
        corrupt.cut_file(tmp_path / "events.npy", 20_000)
        with pytest.raises(CorruptFile, match="1000 events promised"):
            asap.read(tmp_path / "events.npy", order="txyp")

    def test_events_are_numbered_over_all_chunks(self, tmp_path: Path) -> None:
        rows = np.zeros(100_000, [("t", "i8"), ("x", "i4"), ("y", "i4"), ("p", "i1")])
        rows["x"][90_000] = -5
        np.save(tmp_path / "events.npy", rows)
        with pytest.raises(ValueError, match=r"x = -5 \(event 90000\)"):
            asap.load(tmp_path / "events.npy", on_bad="raise")

    def test_without_events(self, tmp_path: Path) -> None:
        np.save(tmp_path / "image.npy", np.zeros((4, 4, 4)))
        with pytest.raises(UnsupportedFormat, match=r"image\.npy"):
            asap.read(tmp_path / "image.npy")

    def test_a_value_of_absurd_size_takes_no_memory(self, tmp_path: Path) -> None:
        header = b"{'descr': '<U99999999', 'fortran_order': False, 'shape': (0,)}\n"
        (tmp_path / "a.npy").write_bytes(b"\x93NUMPY\x01\x00" + bytes([len(header), 0]) + header)
        with pytest.raises(CorruptFile, match="its values have 399999996 bytes each"):
            asap.load(tmp_path / "a.npy")

    def test_is_never_unpickled(self, tmp_path: Path) -> None:
        np.save(tmp_path / "events.npy", np.array([{"t": 1}], object))
        with pytest.raises(CorruptFile, match="never unpickled"):
            asap.read(tmp_path / "events.npy")

    def test_values_that_do_not_fit_are_counted(self, tmp_path: Path) -> None:
        wide = np.zeros(6, [("t", "f8"), ("x", "i4"), ("y", "f8"), ("p", "i8")])
        wide["t"] = [1, 2, np.nan, 3, 4, 5.5]
        wide["x"] = [1, -1, 2, 70000, 3, 4]
        wide["y"] = [1, 1, 2, 2, 0.5, 6]
        np.save(tmp_path / "events.npy", wide)
        rec = asap.read(tmp_path / "events.npy")
        assert txyp(np.concatenate(list(rec))) == [(10**6, 1, 1, 0), (5_500_000, 4, 6, 0)]
        assert rec.rejected["out_of_bounds"] == 2
        assert rec.rejected["bad_record"] == 2
        assert rec.received == 6

        rec = asap.read(tmp_path / "events.npy", on_bad="clamp")
        assert np.concatenate(list(rec))["x"].tolist() == [1, 0, 65535, 4]
        assert rec.repaired["clamped_positions"] == 2

        with pytest.raises(ValueError, match=r"x = -1 \(event 1\)"):
            asap.load(tmp_path / "events.npy", on_bad="raise")


@pytest.mark.parametrize("suffix", ["npy", "npz"])
class TestFloatingTimes:
    def write(self, path: Path, times: list[float]) -> Path:
        rows = np.zeros(len(times), [("t", "f8"), ("x", "u2"), ("y", "u2"), ("p", "u1")])
        rows["t"] = times
        (np.save if path.suffix == ".npy" else np.savez)(path, rows)
        return path

    @pytest.mark.filterwarnings("ignore::asap.io.LossWarning")
    def test_whole_ones_could_be_both(self, tmp_path: Path, suffix: str) -> None:
        path = self.write(tmp_path / f"events.{suffix}", [0, 1000, np.nan, 2000])
        with pytest.raises(ValueError, match=rf"^time_unit = None: .*events\.{suffix} are whole"):
            asap.load(path)
        for time_unit, scale in (("us", 1), ("s", 10**6)):
            assert asap.load(path, time_unit=time_unit)["t"].tolist() == [
                0,
                1000 * scale,
                2000 * scale,
            ]

    def test_fractions_are_seconds(self, tmp_path: Path, suffix: str) -> None:
        path = self.write(tmp_path / f"events.{suffix}", [0, 1, 1.5])
        assert asap.load(path)["t"].tolist() == [0, 10**6, 1_500_000]

    def test_whole_ones_after_a_fraction_are_seconds(self, tmp_path: Path, suffix: str) -> None:
        path = self.write(tmp_path / f"events.{suffix}", [0.5] * (1 << 16) + [1.0] * 5)
        assert asap.load(path)["t"][-1] == 10**6


class TestNpz:
    @pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
    def test_one_structured_array(self, tmp_path: Path, save: Any) -> None:
        save(tmp_path / "a.npz", EVENTS)
        assert_equal_events(asap.load(tmp_path / "a.npz"), EVENTS)
        save(tmp_path / "b.npz", labels=np.arange(3), events=EVENTS)
        assert_equal_events(asap.load(tmp_path / "b.npz"), EVENTS)

    @pytest.mark.parametrize("names", ["ts xs ys ps", "timestamps x y polarities"])
    def test_columns_by_their_plurals(self, tmp_path: Path, names: str) -> None:
        columns = zip(names.split(), "txyp", strict=True)
        np.savez(tmp_path / "a.npz", **{name: EVENTS[role] for name, role in columns})
        assert_equal_events(asap.load(tmp_path / "a.npz"), EVENTS)

    def test_columns_by_their_other_names(self, tmp_path: Path) -> None:
        np.savez(tmp_path / "a.npz", timestamp=EVENTS["t"], x=EVENTS["x"], y=EVENTS["y"],
                 polarity=EVENTS["p"], frames=np.zeros(3))  # fmt: skip
        assert_equal_events(asap.load(tmp_path / "a.npz"), EVENTS)

    def test_width_and_height(self, tmp_path: Path) -> None:
        np.savez(tmp_path / "a.npz", events=EVENTS, width=100, height=np.array([90]))
        rec = asap.read(tmp_path / "a.npz")
        assert (rec.width, rec.height) == (100, 90)
        assert max(chunk["x"].max() for chunk in rec) < 100

    def test_without_events(self, tmp_path: Path) -> None:
        np.savez(tmp_path / "a.npz", images=np.zeros(3), labels=np.zeros(3))
        with pytest.raises(UnsupportedFormat, match="images, labels"):
            asap.read(tmp_path / "a.npz")
        np.savez(tmp_path / "b.npz", t=np.zeros(3), x=np.zeros(3), y=np.zeros(3))
        with pytest.raises(UnsupportedFormat, match="no field for p"):
            asap.load(tmp_path / "b.npz")

    def test_zip_that_is_none(self, tmp_path: Path) -> None:
        with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
            archive.writestr("readme.txt", "hello")
        with pytest.raises(UnsupportedFormat):
            asap.read(tmp_path / "a.npz")

    def test_columns_of_different_lengths(self, tmp_path: Path) -> None:
        np.savez(tmp_path / "a.npz", t=np.zeros(3), x=np.zeros(2), y=np.zeros(3), p=np.zeros(3))
        with pytest.raises(ValueError, match="equally long"):
            asap.load(tmp_path / "a.npz")

    def test_rows_need_their_order(self, tmp_path: Path) -> None:
        np.savez(tmp_path / "a.npz", np.zeros((70_000, 4), int))
        words = r"a\.npz: order = None: an array of shape \(70000, 4\) "
        with pytest.raises(ValueError, match=words):
            asap.load(tmp_path / "a.npz")

    @pytest.mark.parametrize("on_bad", ["drop", "clamp"])
    def test_an_event_that_is_both_unreadable_and_outside_counts_once(
        self, tmp_path: Path, on_bad: str
    ) -> None:
        one = [1, 1, 1]
        np.savez(tmp_path / "a.npz", t=[0.0, np.nan, 2.0], x=[1, 70_000, 3], y=one, p=one)
        rec = asap.read(tmp_path / "a.npz", on_bad=on_bad, time_unit="us")
        assert sum(map(len, rec)) == 2 and rec.received == 3
        assert (rec.rejected["bad_record"], rec.rejected["out_of_bounds"]) == (1, 0)
        assert rec.repaired["clamped_positions"] == 0


class TestText:
    def test_header_names_the_columns(self, tmp_path: Path) -> None:
        expected = [(5, 1, 2, 0), (7, 3, 4, 1)]
        for header in (
            "x,y,polarity,timestamp", "x;y;p;t", "# x y p t", "X, Y, P, T", '"x","y","pol","time"',
            "x,y,p,t_us", "x,y,p,t [us]", "x y on timestamp(us)",
        ):  # fmt: skip
            path = text(tmp_path, f"{header}\n1,2,0,5\n3,4,1,7\n")
            assert txyp(asap.load(path)) == expected, header

    def test_header_may_name_other_columns(self, tmp_path: Path) -> None:
        path = text(tmp_path, "id,t,x,y,p,label\n1,5,1,2,0,car\n2,7,3,4,1,dog\n")
        assert txyp(asap.load(path)) == [(5, 1, 2, 0), (7, 3, 4, 1)]

    def test_header_that_names_no_events(self, tmp_path: Path) -> None:
        with pytest.raises(ValueError, match=r"a, b, c; say what they are"):
            asap.read(text(tmp_path, "a,b,c\n5,1,2\n"))
        path = text(tmp_path, "a,b,c,d\n5,1,2,0\n")
        with pytest.raises(ValueError, match=r"order = None: the header of .* a, b, c, d"):
            asap.read(path)
        assert txyp(asap.load(path, order="txyp")) == [(5, 1, 2, 0)]

    def test_order_of_the_user_goes_before_the_header(self, tmp_path: Path) -> None:
        path = text(tmp_path, "t,x,y,p\n1,2,0,5\n")
        assert txyp(asap.load(path, order="xypt")) == [(5, 1, 2, 0)]

    def test_polarity_as_pandas_writes_a_bool(self, tmp_path: Path) -> None:
        rows = "".join(f"0.00000{i},1,2,{i % 2 == 0}\n" for i in range(1, 5))
        for header in ("", "t,x,y,p\n"):
            (tmp_path / "a.csv").write_text(header + rows)
            events = asap.load(tmp_path / "a.csv")
            assert (events["t"].tolist(), events["p"].tolist()) == ([1, 2, 3, 4], [0, 1, 0, 1])

    def test_two_numbers_first_are_the_sensor(self, tmp_path: Path) -> None:
        rec = asap.read(text(tmp_path, "346 260\n5 1 2 0\n6 346 2 0\n"))
        assert (rec.width, rec.height) == (346, 260)
        assert txyp(np.concatenate(list(rec))) == [(5, 1, 2, 0)]
        with pytest.raises(ValueError, match="width = 99999999999"):
            asap.load(text(tmp_path, "99999999999 5\n1 2 3 1\n"))

    @pytest.mark.parametrize(
        ("header", "time", "t_us"),
        [
            ("", "1.5", 1_500_000), ("", "15", 15), ("t,x,y,p\n", "1.5", 1_500_000),
            ("t_s,x,y,p\n", "3", 3_000_000), ("t [ms],x,y,p\n", "1.5", 1500),
            ("timestamp_ns,x,y,p\n", "1500", 2), ("time(seconds),x,y,p\n", "2", 2_000_000),
        ],
    )  # fmt: skip
    def test_unit_of_time(self, tmp_path: Path, header: str, time: str, t_us: int) -> None:
        assert txyp(asap.load(text(tmp_path, f"{header}{time},1,2,1\n"))) == [(t_us, 1, 2, 1)]

    def test_unit_of_the_user_goes_first(self, tmp_path: Path) -> None:
        path = text(tmp_path, "t_us,x,y,p\n3,1,2,1\n")
        assert asap.load(path, time_unit="s")["t"].tolist() == [3_000_000]
        with pytest.raises(ValueError, match="time_unit = 'min'"):
            asap.load(path, time_unit="min")

    def test_seconds_whose_first_one_is_written_whole(self, tmp_path: Path) -> None:
        path = text(tmp_path, "0 1 2 1\n0.25 1 2 1\n")
        assert asap.load(path)["t"].tolist() == [0, 250_000]

    def test_savetxt_is_ambiguous_where_times_are_whole(self, tmp_path: Path) -> None:
        rows = np.array([[1.0, 2, 3, 1], [2.0, 2, 3, 0]])
        np.savetxt(tmp_path / "events.txt", rows)
        with pytest.raises(ValueError, match="time_unit = None"):
            asap.read(tmp_path / "events.txt")
        assert asap.load(tmp_path / "events.txt", time_unit="us")["t"].tolist() == [1, 2]
        rows[:, 0] /= 1000
        np.savetxt(tmp_path / "events.txt", rows)
        assert asap.load(tmp_path / "events.txt")["t"].tolist() == [1000, 2000]

    @pytest.mark.parametrize(
        ("line", "order", "words"),
        [
            ("5 1 2", None, "have 3 columns; name each, such as order='txy'"),
            ("5 1 2", "txyp", "have 3 columns; name each, such as order='txy'"),
            ("5 1 2 0", "txy", "have 4 columns; name each, such as order='txyp'"),
            ("5 1 2 0 9", None, "have 5 columns; only a header line can name them, such as"),
        ],
    )
    def test_remedy_has_a_letter_for_each_column(
        self, tmp_path: Path, line: str, order: str | None, words: str
    ) -> None:
        with pytest.raises(ValueError, match=words):
            asap.read(text(tmp_path, f"{line}\n"), order=order)

    def test_the_unit_of_time_is_not_told_by_a_line_that_the_head_cuts(
        self, tmp_path: Path
    ) -> None:
        lines = "".join(f"{t:08}.0 5.0 6.0 1.0\n" for t in range(2000))
        path = text(tmp_path, "# 345678\n\n\n" + lines)
        assert path.read_bytes()[: 1 << 14].endswith(b" 5.0 6.0 1")
        with pytest.raises(ValueError, match="time_unit = None"):
            asap.read(path)

    @pytest.mark.parametrize("last", ["5000", "128", "-128", "0.5"])
    def test_columns_in_another_order_are_not_taken_for_txyp(
        self, tmp_path: Path, last: str
    ) -> None:
        with pytest.raises(ValueError, match="holds no polarity"):
            asap.read(text(tmp_path, f"1 2 0 {last}\n"))

    def test_a_polarity_may_be_any_number_of_8_bits(self, tmp_path: Path) -> None:
        events = asap.load(text(tmp_path, "1 2 0 127\n2 2 0 -127\n"))
        assert events["p"].tolist() == [1, 0]

    def test_byte_order_mark_and_windows_lines(self, tmp_path: Path) -> None:
        path = tmp_path / "events.csv"
        path.write_bytes(b"\xef\xbb\xbft,x,y,p\r\n5,1,2,0\r\n")
        assert txyp(asap.load(path)) == [(5, 1, 2, 0)]

    def test_lines_longer_than_the_head_of_the_file(self, tmp_path: Path) -> None:
        path = text(tmp_path, "# " + "x" * 100_000 + "\n5 1 2 0\n")
        assert txyp(asap.load(path)) == [(5, 1, 2, 0)]

    def test_more_than_one_piece(self, tmp_path: Path) -> None:
        events = corrupt.clean_events(120_000)
        WRITERS["txt"](tmp_path / "events.txt", events)
        assert (tmp_path / "events.txt").stat().st_size > 1 << 21
        assert_equal_events(asap.load(tmp_path / "events.txt"), events)

    def test_bad_lines_are_counted_with_their_offset(self, tmp_path: Path) -> None:
        path = text(tmp_path, "5 1 2 0\n6 one 2 0\n7 1 2 0\n8 1 2 0 9\n9 70000 2 0\n")
        rec = asap.read(path)
        assert sum(map(len, rec)) == 2
        assert rec.rejected["bad_record"] == 2
        assert rec.rejected["out_of_bounds"] == 1
        assert rec.bad_offsets == (8, 26, 36)
        with pytest.raises(CorruptFile, match=r"byte 8: .*6 one 2 0") as error:
            asap.load(path, on_bad="raise")
        assert error.value.offset == 8

    def test_a_last_line_that_is_cut_is_told_where_it_begins(self, tmp_path: Path) -> None:
        rec = asap.read(text(tmp_path, "5 1 2 0\n6 1"))
        with pytest.warns(asap.io.TruncatedFileWarning, match="byte 8: the last line is cut"):
            assert txyp(np.concatenate(list(rec))) == [(5, 1, 2, 0)]
        assert rec.truncated_at == 8

    def test_clamped_beyond_16_bits(self, tmp_path: Path) -> None:
        rec = asap.read(text(tmp_path, "5 -1 2 0\n6 70000 2 0\n"), width=346, on_bad="clamp")
        assert np.concatenate(list(rec))["x"].tolist() == [0, 345]
        assert sum(rec.rejected.values()) == 0


@settings(deadline=None)
@given(st.decimals(0, 10**9, places=9, allow_nan=False))
def test_seconds_equal_exact_rounding(seconds: Decimal) -> None:
    decoder = _core.TextDecoder()
    (event,) = decoder.decode(f"{seconds:f} 1 2 1\n".encode())
    assert event["t"] == round(seconds * 10**6)


@settings(deadline=None)
@given(
    st.lists(
        st.sampled_from([b"1", b"2.5", b" ", b",", b"\n", b"\r\n", b"#", b"-", b"5 1 2 0\n", b"e"])
    ).map(b"".join),
    st.lists(st.integers(0, 60)),
)
def test_text_is_resumable_at_any_cut(content: bytes, cuts: list[int]) -> None:
    def decode(pieces: list[bytes]) -> tuple[Any, ...]:
        decoder = _core.TextDecoder()
        events = [txyp(decoder.decode(piece)) for piece in pieces]
        last, ended_well = decoder.finish()
        joined = [event for part in events for event in part] + txyp(last)
        return joined, ended_well, decoder.bad_records, decoder.out_of_bounds, decoder.noted

    edges = [0, *sorted(cut for cut in cuts if cut <= len(content)), len(content)]
    pieces = [content[a:b] for a, b in pairwise(edges)]
    assert decode(pieces) == decode([content])


class TestErrors:
    def test_no_such_file(self, tmp_path: Path) -> None:
        with pytest.raises(FileNotFoundError):
            asap.load(tmp_path / "nothing.npy")
        with pytest.raises(OSError, match="irectory"):
            asap.load(tmp_path)

    @pytest.mark.parametrize("name", ["a.aedat", "a.xyz"])
    def test_formats_that_are_not_served(self, tmp_path: Path, name: str) -> None:
        (tmp_path / name).write_bytes(bytes(range(256)))
        words = {"a.aedat": "without '#!AER-DAT'", "a.xyz": "begins with the bytes 00 01 02 03"}[
            name
        ]
        with pytest.raises(UnsupportedFormat, match=rf"{words}.* is not read yet.*aedat4") as error:
            asap.read(tmp_path / name)
        assert isinstance(error.value, ValueError)

    @pytest.mark.parametrize("suffix", ["raw", "h5", "aedat4", "aedat", "npz", "bag", "bs2"])
    def test_text_under_another_suffix(self, tmp_path: Path, suffix: str) -> None:
        path = tmp_path / f"a.{suffix}"
        path.write_text("5 1 2 0\n")
        words = rf"byte 0: text, not the events of a \.{suffix} file; file_format='text' reads it"
        with pytest.raises(CorruptFile, match=words):
            asap.read(path)
        assert len(asap.load(path, file_format="text")) == 1

    @pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be"])
    def test_text_in_utf_16(self, tmp_path: Path, encoding: str) -> None:
        (tmp_path / "a.csv").write_bytes("\ufefft,x,y,p\n5,1,2,0\n".encode(encoding))
        with pytest.raises(UnsupportedFormat, match=r"text in UTF-16; save it in UTF-8$"):
            asap.read(tmp_path / "a.csv")

    @pytest.mark.parametrize("there", [1, 5])
    def test_a_file_cut_inside_its_signature(self, tmp_path: Path, there: int) -> None:
        (tmp_path / "a.h5").write_bytes(b"\x89HDF\r\n\x1a\n"[:there])
        with pytest.raises(CorruptFile, match=f"byte {there}: the file ends inside its signature"):
            asap.read(tmp_path / "a.h5")

    @pytest.mark.parametrize(
        "head",
        [
            b"% evt 4.0\n",
            b"% camera\n% format EVT4;height=720\n% end\n",
            b"% Data file containing",
        ],
    )
    def test_prophesee_of_another_encoding(self, tmp_path: Path, head: bytes) -> None:
        (tmp_path / "a.txt").write_bytes(head)
        with pytest.raises(UnsupportedFormat, match="Prophesee"):
            asap.read(tmp_path / "a.txt")

    @pytest.mark.parametrize("name", ["a.npy", "a.npz", "a.aedat4", "a.es", "a.txt", "a.bin", "a"])
    def test_an_empty_file(self, tmp_path: Path, name: str) -> None:
        (tmp_path / name).touch()
        with pytest.raises(CorruptFile, match="byte 0: the file is empty"):
            asap.read(tmp_path / name)

    @pytest.mark.parametrize("name", ["a.npy", "a.npz", "a.aedat4", "a.es"])
    def test_not_what_the_name_promises(self, tmp_path: Path, name: str) -> None:
        (tmp_path / name).write_bytes(bytes(range(200)))
        with pytest.raises(CorruptFile, match="byte 0: not the beginning of"):
            asap.read(tmp_path / name)

    def test_corrupt_file_survives_pickling(self, tmp_path: Path) -> None:
        error = pickle.loads(pickle.dumps(CorruptFile(tmp_path, 7, "broken")))
        assert (error.path, error.offset, error.fault) == (tmp_path, 7, "broken")


def test_npz_bombs_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(asap.io.errors, "HARMLESS", 1 << 10)
    monkeypatch.setattr(asap.io.errors, "MAX_RATIO", 100)
    np.savez_compressed(tmp_path / "a.npz", events=np.zeros(100_000, asap.EVENT_DTYPE))
    with pytest.raises(CorruptFile, match="more than 100 times"):
        asap.read(tmp_path / "a.npz")


def test_npz_headers_that_lie_about_the_size_allocate_nothing(tmp_path: Path) -> None:
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        header, {"descr": "<i8", "fortran_order": False, "shape": (10**15,)}
    )
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        for name in "txyp":
            archive.writestr(f"{name}.npy", header.getvalue() + bytes(80))
    with pytest.raises(CorruptFile, match="8000000000000128 bytes promised"):
        asap.load(tmp_path / "a.npz")


def test_npz_members_longer_than_their_header_says_are_refused(tmp_path: Path) -> None:
    content = io.BytesIO()
    np.save(content, np.arange(3))
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        for name in "txyp":
            archive.writestr(f"{name}.npy", content.getvalue() + bytes(8))
    with pytest.raises(CorruptFile, match="152 bytes promised, 160 are there"):
        asap.load(tmp_path / "a.npz")


@pytest.mark.parametrize("seed", range(40))
@pytest.mark.filterwarnings("ignore::asap.io.LossWarning")
def test_A13_random_bytes_raise_only_what_is_promised(seed: int, path: Path) -> None:
    chance = random.Random(seed)
    corrupt.flip_bytes(path, chance.choice([1, 5, 50]), seed=seed)
    if seed % 3 == 0:
        corrupt.cut_file(path, chance.randrange(1, path.stat().st_size))
    for on_bad in ("drop", "clamp", "raise"):
        try:
            events = asap.load(path, width=corrupt.WIDTH, height=corrupt.HEIGHT, on_bad=on_bad)
        except (ValueError, OSError, RuntimeError):
            continue
        assert (np.diff(events["t"]) >= 0).all()
        assert events["x"].max(initial=0) < corrupt.WIDTH
        assert set(events["p"].tolist()) <= {0, 1}
