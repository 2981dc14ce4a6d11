"""HDF5: the layouts in circulation, several cameras, filters, links, sizes, damage."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
import corrupt
from asap.io import CorruptFile, TruncatedFileWarning, UnsupportedFormat
from event_files import assert_equal_events, recording

h5py = pytest.importorskip("h5py")

EVENTS = corrupt.clean_events(200_000)
OFFSET = 59_001_000_000


def columns(group: Any, events: Any = EVENTS, offset: int = 0, **options: Any) -> None:
    for name, dtype in (("t", "u4"), ("x", "u2"), ("y", "u2"), ("p", "u1")):
        values = events[name] - offset if name == "t" else events[name]
        group.create_dataset(name, data=values.astype(dtype), **options)


def dsec(path: Path, **options: Any) -> Path:
    """Events whose times count from t_offset, and an index that is none of our business."""
    with h5py.File(path, "w") as file:
        columns(file.create_group("events"), **options)
        file["t_offset"] = np.int64(OFFSET)
        file["ms_to_idx"] = np.arange(1000, dtype="u8")
    return path


def shifted(events: Any = EVENTS) -> Any:
    events = events.copy()
    events["t"] += OFFSET
    return events


def mvsec(path: Path, cameras: tuple[str, ...] = ("left", "right"), order: str = "xytp") -> Path:
    with h5py.File(path, "w") as file:
        for i, camera in enumerate(cameras):
            rows = np.zeros((len(EVENTS), 4))
            for k, role in enumerate(order):
                rows[:, k] = {
                    "t": 1_504_645_177 + EVENTS["t"] / 1e6,
                    "p": EVENTS["p"] * 2.0 - 1,
                }.get(role, EVENTS[role])
            rows[:, order.index("x")] += i
            file[f"davis/{camera}/events"] = rows
            file[f"davis/{camera}/imu"] = np.zeros((10, 6))
            file[f"davis/{camera}/image_raw_event_inds"] = np.zeros(10, "i8")
    return path


class TestLayouts:
    @pytest.mark.parametrize(
        "options",
        [{}, {"chunks": (1000,)}, {"chunks": (70_001,), "compression": "gzip"},
         {"chunks": (999,), "compression": "lzf", "shuffle": True, "fletcher32": True}],
    )  # fmt: skip
    def test_dsec_times_count_from_their_offset(self, tmp_path: Path, options: Any) -> None:
        rec = asap.read(dsec(tmp_path / "a.h5", **options))
        chunks = list(rec)
        assert (rec.format, rec.streams) == ("hdf5", ("events",))
        assert_equal_events(np.concatenate(chunks), shifted())
        assert max(map(len, chunks)) <= 1 << 16
        assert_equal_events(asap.load(tmp_path / "a.h5"), shifted())

    def test_metavision(self, tmp_path: Path) -> None:
        with h5py.File(tmp_path / "a.hdf5", "w") as file:
            file.create_dataset("CD/events", data=EVENTS, chunks=(3000,), compression="gzip")
            file["CD/indexes"] = np.zeros(5, [("id", "u8"), ("ts", "i8")])
            file["EXT_TRIGGER/events"] = np.zeros(7, [("p", "i2"), ("t", "i8"), ("id", "i2")])
            file.attrs["geometry"] = "1280x720"
        rec = asap.read(tmp_path / "a.hdf5")
        assert (rec.width, rec.height, rec.streams) == (1280, 720, ("CD/events",))
        assert_equal_events(np.concatenate(list(rec)), EVENTS)

    @pytest.mark.parametrize("order", ["xytp", "txyp", "xypt"])
    def test_matrices_in_the_order_that_the_user_says(self, tmp_path: Path, order: str) -> None:
        events = asap.load(mvsec(tmp_path / "a.hdf5", ("left",), order), order=order)
        expected = EVENTS.copy()
        expected["t"] += 1_504_645_177 * 10**6
        assert_equal_events(events, expected)

    def test_matrices_without_an_order_are_a_question(self, tmp_path: Path) -> None:
        with h5py.File(tmp_path / "a.h5", "w") as file:
            file["events"] = np.array([[1, 0, 0, 1], [1, 1, 0, 1]])
        with pytest.raises(ValueError, match=r"order = None: events in .*a\.h5 does not say"):
            asap.read(tmp_path / "a.h5")
        assert asap.load(tmp_path / "a.h5", order="xytp")["x"].tolist() == [1, 1]
        with pytest.raises(ValueError, match=r"order = 'txy': names 3 columns, events in .* has 4"):
            asap.read(tmp_path / "a.h5", order="txy")

    def test_matlab_7_3_is_hdf5_with_its_matrices_turned(self, tmp_path: Path) -> None:
        with h5py.File(tmp_path / "a.mat", "w", userblock_size=512) as file:
            file["events"] = np.stack([EVENTS[role].astype("f8") for role in "xypt"])
            columns(file.create_group("c"))
            for name in "txyp":
                del file["c"][name]
                file["c"][name] = EVENTS[name].reshape(1, -1)
        content = (tmp_path / "a.mat").read_bytes()
        (tmp_path / "a.mat").write_bytes(b"MATLAB 7.3 MAT-file".ljust(512) + content[512:])
        for stream, order in (("events", "xypt"), ("c", None)):
            events = asap.load(tmp_path / "a.mat", stream=stream, order=order, time_unit="us")
            assert_equal_events(events, EVENTS)

    def test_plural_names_and_a_sensor_in_numbers(self, tmp_path: Path) -> None:
        with h5py.File(tmp_path / "a.h5", "w") as file:
            for name in "txyp":
                file[f"events/{name}s"] = EVENTS[name]
            file.attrs["width"], file.attrs["height"] = 346, 260
        rec = asap.read(tmp_path / "a.h5")
        assert (rec.width, rec.height) == (346, 260)
        assert_equal_events(np.concatenate(list(rec)), EVENTS)


class TestSeveralCameras:
    def test_are_a_question_that_lists_them(self, tmp_path: Path) -> None:
        words = (
            r"stream = None: .*a\.hdf5 holds 2 streams of events \(davis/left/events \(200000 "
            r"events\), davis/right/events .*; choose one, such as stream='davis/left/events'"
        )
        with pytest.raises(ValueError, match=words):
            asap.read(mvsec(tmp_path / "a.hdf5"))
        with pytest.raises(ValueError, match=r"stream = 'events': .* holds 2 streams"):
            asap.read(tmp_path / "a.hdf5", stream="events")
        with pytest.raises(ValueError, match=r"stream = 'middle': .* holds 2 streams"):
            asap.read(tmp_path / "a.hdf5", stream="middle")

    @pytest.mark.parametrize("stream", ["right", "davis/right/events", "/davis/right"])
    def test_are_chosen_by_a_part_of_their_name(self, tmp_path: Path, stream: str) -> None:
        rec = asap.read(mvsec(tmp_path / "a.hdf5"), stream=stream, order="xytp")
        assert rec.streams == ("davis/left/events", "davis/right/events")
        np.testing.assert_array_equal(np.concatenate(list(rec))["x"], EVENTS["x"] + 1)


class TestLibraries:
    def test_dsec_as_it_is_distributed_is_unpacked(self, tmp_path: Path) -> None:
        blosc = pytest.importorskip("hdf5plugin").Blosc(cname="zstd", shuffle=1)
        path = dsec(tmp_path / "a.h5", chunks=(1000,), **blosc)
        code = "import sys, asap; print(asap.load(sys.argv[1])['t'].sum())"
        command = [sys.executable, "-c", code, str(path)]  # here the filter is registered already
        found = subprocess.run(command, capture_output=True, text=True)
        assert found.stdout == f"{shifted()['t'].sum()}\n", found.stderr

    @pytest.mark.parametrize(
        ("code", "words"),
        [
            (0x8ECF, r"Metavision's ECF, 0x8ECF.* hdf5_ecf, or convert .*_file_to_dat$"),
            (32001, r"compressed with filter 32001 .*pip install hdf5plugin"),
        ],
    )  # fmt: skip
    def test_a_filter_that_is_missing_is_named(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: int, words: str
    ) -> None:
        path = dsec(tmp_path / "a.h5", chunks=(1000,))
        with h5py.File(path, "a") as file:
            del file["events/x"]
            properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
            properties.set_chunk((1000,))
            properties.set_filter(code, h5py.h5z.FLAG_OPTIONAL, ())
            space = h5py.h5s.create_simple((len(EVENTS),))
            kind = h5py.h5t.NATIVE_UINT16
            column = h5py.h5d.create(file["events"].id, b"x", kind, space, properties)
            for start in range(0, len(EVENTS), 1000):
                column.write_direct_chunk((start,), bytes(500))
        monkeypatch.setitem(sys.modules, "hdf5plugin", None)
        monkeypatch.setattr(h5py.h5z, "filter_avail", lambda number: number < 256)
        with pytest.raises(RuntimeError, match=words):
            asap.read(path)


class TestWhatIsRefused:
    def test_links_to_other_files_are_not_followed(self, tmp_path: Path) -> None:
        dsec(tmp_path / "other.h5")
        with h5py.File(tmp_path / "a.h5", "w") as file:
            file["events"] = h5py.ExternalLink("other.h5", "/events")
        words = "links that lead elsewhere are not followed: events"
        with pytest.raises(UnsupportedFormat, match=words):
            asap.read(tmp_path / "a.h5")

    def test_columns_in_other_files_are_not_read(self, tmp_path: Path) -> None:
        (tmp_path / "secret").write_bytes(bytes(range(256)) * 100)
        with h5py.File(tmp_path / "a.h5", "w") as file:
            columns(file.create_group("events"), EVENTS[:1000])
            del file["events/x"]
            outside = [(str(tmp_path / "secret"), 0, 2000)]
            file.create_dataset("events/x", (1000,), "u2", external=outside)
        with pytest.raises(UnsupportedFormat, match="/events/x lies in another file"):
            asap.read(tmp_path / "a.h5")

    def test_views_of_other_files_are_not_read(self, tmp_path: Path) -> None:
        dsec(tmp_path / "other.h5")
        layout = h5py.VirtualLayout((1000,), "u2")
        layout[:] = h5py.VirtualSource(str(tmp_path / "other.h5"), "events/x", (200_000,))[:1000]
        with h5py.File(tmp_path / "a.h5", "w") as file:
            columns(file.create_group("events"), EVENTS[:1000])
            del file["events/x"]
            file["events"].create_virtual_dataset("x", layout)
        with pytest.raises(UnsupportedFormat, match="/events/x lies in another file"):
            asap.read(tmp_path / "a.h5")

    def test_groups_in_circles_end(self, tmp_path: Path) -> None:
        path = dsec(tmp_path / "a.h5")
        with h5py.File(path, "a") as file:
            file["events/again"] = file["/"]
        assert asap.read(path).streams == ("events",)

    @pytest.mark.parametrize("rows", [10**7, 10**15])
    def test_sizes_that_nothing_is_behind(self, tmp_path: Path, rows: int) -> None:
        with h5py.File(tmp_path / "a.h5", "w") as file:
            for name in "txyp":
                file.create_dataset(f"events/{name}", (rows,), "i8", chunks=(1000,))
        with pytest.raises(CorruptFile, match=f"{rows} values promised, none stored"):
            asap.read(tmp_path / "a.h5")

    def test_sizes_beyond_any_compression(self, tmp_path: Path) -> None:
        with h5py.File(tmp_path / "a.h5", "w") as file:
            for name in "txyp":
                column = file.create_dataset(
                    f"events/{name}", (10**12,), "i8", chunks=(1000,), compression="gzip"
                )
                column[:1000] = 0
        with pytest.raises(CorruptFile, match=f"decompresses to {8 * 10**12} bytes"):
            asap.read(tmp_path / "a.h5")

    @pytest.mark.parametrize("offset", [np.zeros(2, "i8"), 0.5, np.uint64(2**63)], ids=str)
    def test_an_offset_that_is_none(self, tmp_path: Path, offset: Any) -> None:
        path = dsec(tmp_path / "a.h5")
        with h5py.File(path, "a") as file:
            del file["t_offset"]
            file["t_offset"] = offset
        with pytest.raises(CorruptFile, match="t_offset: one number of us"):
            asap.read(path)


class TestDamage:
    def test_a_file_that_was_cut_says_where(self, tmp_path: Path) -> None:
        path = dsec(tmp_path / "a.h5")
        size = path.stat().st_size
        for there in (size - 1, size // 2, 100):
            corrupt.cut_file(path, there)
            words = f"byte {there}: the file ends, {size} bytes are promised; .* this HDF5 file"
            with pytest.raises(CorruptFile, match=words):
                asap.load(path)
        for there in (63, 9, 8):
            corrupt.cut_file(path, there)
            with pytest.raises(CorruptFile, match=f"byte {there}: the file ends inside its head"):
                asap.load(path)

    def test_what_is_before_a_damaged_chunk_is_kept(self, tmp_path: Path) -> None:
        path = dsec(tmp_path / "a.h5", chunks=(1000,), compression="gzip")
        with h5py.File(path) as file:
            place = file["events/t"].id.get_chunk_info_by_coord((123_000,))
        content = bytearray(path.read_bytes())
        middle = place.byte_offset + place.size // 2
        content[middle : middle + 20] = bytes(20)
        path.write_bytes(content)
        words = f"byte {place.byte_offset}: /events/t: "
        recording = asap.read(path)
        with pytest.warns(TruncatedFileWarning, match=f"{words}.*; what came before was read"):
            events = np.concatenate(list(recording))
        assert_equal_events(events, shifted(EVENTS[:123_000]))
        assert recording.truncated_at == place.byte_offset
        with pytest.raises(CorruptFile, match=words):
            asap.load(path, on_bad="raise")


def test_a_derived_dsec_file_may_be_an_open_group() -> None:
    with h5py.File(recording("derived/office.dsec.h5")) as file:
        events = asap.as_events(file["events"])
    assert_equal_events(events, asap.load(recording("derived/office.dsec.h5")))
