"""MATLAB 5 files: columns, matrices, structures and event buffers; damage."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
import corrupt
from asap.io import CorruptFile, TruncatedFileWarning
from event_files import assert_equal_events

scipy_io = pytest.importorskip("scipy.io")

EVENTS = corrupt.clean_events(100_000)


def save(path: Path, compress: bool = True, **variables: Any) -> Path:
    scipy_io.savemat(path, variables, do_compression=compress)
    return path


def matrix(order: str, dtype: str = "f8") -> Any:
    return np.stack([EVENTS[role] for role in order], axis=1).astype(dtype)


class TestLayouts:
    @pytest.mark.parametrize("names", ["txyp", ("ts", "x", "y", "pol"), ("TIME", "X", "Y", "ON")])
    @pytest.mark.parametrize("dtype", ["f8", "u4"])
    def test_columns(self, tmp_path: Path, names: Any, dtype: str) -> None:
        columns = {
            name: EVENTS[role].astype(dtype) for name, role in zip(names, "txyp", strict=True)
        }
        rec = asap.read(save(tmp_path / "a.mat", **columns, fps=30.0))
        assert (rec.format, rec.streams) == ("matlab", ("variables",))
        assert_equal_events(np.concatenate(list(rec)), EVENTS)

    @pytest.mark.parametrize("order", ["xypt", "txyp", "xytp"])
    @pytest.mark.parametrize("turned", [False, True])
    def test_matrices(self, tmp_path: Path, order: str, turned: bool) -> None:
        rows = matrix(order)
        path = save(tmp_path / "a.mat", events=rows.T if turned else rows)
        assert_equal_events(asap.load(path, order=order), EVENTS)
        with pytest.raises(ValueError, match=r"order = None: events in .* does not say"):
            asap.load(path)

    def test_a_matrix_under_any_name_if_it_is_the_only_one(self, tmp_path: Path) -> None:
        path = save(tmp_path / "a.mat", recording=matrix("xypt"), image=np.zeros((9, 9)))
        assert_equal_events(asap.load(path, order="xypt"), EVENTS)

    def test_a_structure(self, tmp_path: Path) -> None:
        fields = {"x": EVENTS["x"], "y": EVENTS["y"], "p": EVENTS["p"], "ts": EVENTS["t"]}
        path = save(tmp_path / "a.mat", TD=fields, info={"name": "nothing"})
        rec = asap.read(path)
        assert rec.streams == ("TD",)
        assert_equal_events(np.concatenate(list(rec)), EVENTS)

    def test_last_events_of_each_pixel(self, tmp_path: Path) -> None:
        times, polarity = np.zeros((4, 3, 2), "u4"), np.zeros((4, 3, 2), "u1")
        times[3, 1, 0], times[0, 2, 1], times[2, 2, 0] = 50, 20, 20
        polarity[3, 1, 0] = 1
        path = save(tmp_path / "a.mat", eventBuffer=times, polarityBuffer=polarity)
        events = asap.load(path)
        assert events[["t", "x", "y", "p"]].tolist() == [
            (20, 0, 2, 0),
            (20, 2, 2, 0),
            (50, 3, 1, 1),
        ]
        with pytest.raises(ValueError, match=r"order = 'txyp': .* has no columns; leave order out"):
            asap.read(path, order="txyp")

    def test_several_are_a_question(self, tmp_path: Path) -> None:
        path = save(tmp_path / "a.mat", left_events=matrix("xypt"), right_events=matrix("txyp"))
        with pytest.raises(ValueError, match=r"2 streams of events \(left_events, right_events\)"):
            asap.read(path)
        assert_equal_events(asap.load(path, stream="right_events", order="txyp"), EVENTS)


class TestBadInput:
    def test_sizes_beyond_any_compression(self, tmp_path: Path) -> None:
        path = save(tmp_path / "a.mat", compress=False, events=np.zeros((100, 4)))
        content = bytearray(path.read_bytes())
        at = content.index((100).to_bytes(4, "little") + (4).to_bytes(4, "little"))
        content[at : at + 4] = (2**31 - 1).to_bytes(4, "little")
        path.write_bytes(content)
        with pytest.raises(CorruptFile, match=f"events decompresses to {(2**31 - 1) * 32} bytes"):
            asap.read(path)

    @pytest.mark.parametrize("compress", [False, True])
    def test_a_cut_file_says_where(self, tmp_path: Path, compress: bool) -> None:
        path = save(tmp_path / "a.mat", compress, events=matrix("xypt"))
        size = path.stat().st_size
        for there in (size - 1, size // 2, 200, 130):
            corrupt.cut_file(path, there)
            with pytest.raises(CorruptFile, match=f"byte 128: .*the {there} bytes .* MATLAB file"):
                asap.load(path)
        corrupt.cut_file(path, 100)
        with pytest.raises(CorruptFile, match="byte 100: the file ends inside its header"):
            asap.load(path)

    @pytest.mark.parametrize("compress", [False, True])
    def test_what_comes_before_the_cut_is_read(self, tmp_path: Path, compress: bool) -> None:
        path = save(tmp_path / "a.mat", compress, events=matrix("xypt"), image=np.eye(500))
        whole = path.stat().st_size
        save(tmp_path / "b.mat", compress, events=matrix("xypt"))
        cut = (tmp_path / "b.mat").stat().st_size
        for there in (whole - 1, whole - 100):
            corrupt.cut_file(path, there)
            with pytest.warns(TruncatedFileWarning, match=f"byte {cut}: .* bytes promised"):
                assert_equal_events(asap.load(path, order="xypt"), EVENTS)
