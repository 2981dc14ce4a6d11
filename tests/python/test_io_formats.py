"""asap.read and asap.load: formats, options, laziness, errors."""

from __future__ import annotations

import io
import os
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
import corrupt
from asap.events import Events
from asap.io import FILE_FORMATS, CorruptFile, UnsupportedFormat
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

    def test_no_events(self, path: Path) -> None:
        WRITERS[path.suffix[1:]](path, EVENTS[:0])
        if path.suffix == ".txt":
            path.write_text("# nothing happened\n")
        assert len(asap.load(path)) == 0
        assert list(asap.read(path)) == []


def test_every_format_stands_in_the_table_of_the_page() -> None:
    page = Path(__file__).parents[2] / "notebooks" / "recordings.md"
    rows = [line for line in page.read_text().splitlines() if line.startswith("| ")]
    assert {name for name in FILE_FORMATS if not any(f"`{name}`" in row for row in rows)} == set()


class TestNpy:
    @pytest.mark.parametrize("memory_order", ["C", "F"])
    def test_a_file_may_become_shorter(self, tmp_path: Path, memory_order: Any) -> None:
        rows = np.ones((300_000, 4), "i8", memory_order)
        np.save(tmp_path / "events.npy", rows)
        chunks = iter(asap.read(tmp_path / "events.npy", order="txyp"))
        next(chunks)
        os.truncate(tmp_path / "events.npy", 1000)
        with pytest.raises(asap.io.CorruptFile, match=r"byte 1000: .*shorter"):
            list(chunks)

    @pytest.mark.parametrize("memory_order", ["C", "F"])
    def test_rows_with_order(self, tmp_path: Path, memory_order: Any) -> None:
        rows = np.stack([EVENTS[name] for name in "xytp"], axis=1).astype("f8", memory_order)
        rows[:, 2] /= 1e6
        np.save(tmp_path / "events.npy", rows)
        assert_equal_events(asap.load(tmp_path / "events.npy", order="xytp"), EVENTS)
        with pytest.raises(ValueError, match=r"order = None: .* what its columns are; give order"):
            asap.read(tmp_path / "events.npy")

    def test_cut_by_columns_nothing_is_whole(self, tmp_path: Path) -> None:
        rows = np.stack([EVENTS[name] for name in "txyp"], axis=1).astype("i8", "F")
        np.save(tmp_path / "events.npy", rows)
        corrupt.cut_file(tmp_path / "events.npy", 20_000)
        with pytest.raises(CorruptFile, match="1000 events promised"):
            asap.read(tmp_path / "events.npy", order="txyp")

    def test_a_value_of_absurd_size_takes_no_memory(self, tmp_path: Path) -> None:
        header = b"{'descr': '<U99999999', 'fortran_order': False, 'shape': (0,)}\n"
        (tmp_path / "a.npy").write_bytes(b"\x93NUMPY\x01\x00" + bytes([len(header), 0]) + header)
        with pytest.raises(CorruptFile, match="its values have 399999996 bytes each"):
            asap.load(tmp_path / "a.npy")

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
        events = np.concatenate(list(rec))
        assert events["x"].tolist() == [1, 0, 65535, 3, 4]
        assert events["y"].tolist() == [1, 1, 2, 0, 6]  # the nearest pixel
        assert rec.repaired["clamped_positions"] == 3

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


class TestNpz:
    @pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
    def test_one_structured_array(self, tmp_path: Path, save: Any) -> None:
        save(tmp_path / "a.npz", EVENTS)
        assert_equal_events(asap.load(tmp_path / "a.npz"), EVENTS)
        save(tmp_path / "b.npz", labels=np.arange(3), events=EVENTS)
        assert_equal_events(asap.load(tmp_path / "b.npz"), EVENTS)

    def test_without_events(self, tmp_path: Path) -> None:
        np.savez(tmp_path / "a.npz", images=np.zeros(3), labels=np.zeros(3))
        with pytest.raises(UnsupportedFormat, match="images, labels"):
            asap.read(tmp_path / "a.npz")
        np.savez(tmp_path / "b.npz", t=np.zeros(3), x=np.zeros(3), y=np.zeros(3))
        with pytest.raises(UnsupportedFormat, match="no field for p"):
            asap.load(tmp_path / "b.npz")

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
            "x,y,p,t,",
        ):  # fmt: skip
            path = text(tmp_path, f"{header}\n1,2,0,5\n3,4,1,7\n")
            assert txyp(asap.load(path)) == expected, header

    @pytest.mark.parametrize("separator", [";", "\t"])
    def test_decimal_commas_are_named(self, tmp_path: Path, separator: str) -> None:
        rows = "".join(separator.join((f"0,00{i}", "1", "2", "0")) + "\n" for i in range(9))
        with pytest.raises(CorruptFile, match="decimal comma"):
            asap.read(text(tmp_path, rows))

    def test_header_that_names_no_events(self, tmp_path: Path) -> None:
        with pytest.raises(ValueError, match=r"a, b, c; say what they are"):
            asap.read(text(tmp_path, "a,b,c\n5,1,2\n"))
        path = text(tmp_path, "a,b,c,d\n5,1,2,0\n")
        with pytest.raises(ValueError, match=r"order = None: the header of .* a, b, c, d"):
            asap.read(path)
        assert txyp(asap.load(path, order="txyp")) == [(5, 1, 2, 0)]

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
            ("# timestamp [ms] x y polarity\n", "15", 15_000),
        ],
    )  # fmt: skip
    def test_unit_of_time(self, tmp_path: Path, header: str, time: str, t_us: int) -> None:
        assert txyp(asap.load(text(tmp_path, f"{header}{time},1,2,1\n"))) == [(t_us, 1, 2, 1)]

    def test_savetxt_is_ambiguous_where_times_are_whole(self, tmp_path: Path) -> None:
        rows = np.array([[1.0, 2, 3, 1], [2.0, 2, 3, 0]])
        np.savetxt(tmp_path / "events.txt", rows)
        with pytest.raises(ValueError, match="time_unit = None"):
            asap.read(tmp_path / "events.txt")
        assert asap.load(tmp_path / "events.txt", time_unit="us")["t"].tolist() == [1, 2]
        rows[:, 0] /= 1000
        np.savetxt(tmp_path / "events.txt", rows)
        assert asap.load(tmp_path / "events.txt")["t"].tolist() == [1000, 2000]


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
