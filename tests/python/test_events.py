"""asap.as_events: every layout by field name, nothing scrambled, nothing wrapped."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import asap
from asap.events import Events
from event_files import assert_equal_events

# Values that land in the wrong column if anything is taken by position.
T = np.array([1_000_000, 1_000_001, 1_000_001, 2_000_000])
X = np.array([7, 300, 0, 345])
Y = np.array([9, 2, 259, 1])
P = np.array([1, 0, 1, 0])


def expected(t: Any = T, x: Any = X, y: Any = Y, p: Any = P) -> Events:
    events = np.zeros(len(t), asap.EVENT_DTYPE)
    events["t"], events["x"], events["y"], events["p"] = t, x, y, p
    return events


def fake(dtype: Any, roles: str = "txyp") -> np.ndarray:
    """The four events in the dtype of a producer; roles: what its fields are, in order."""
    array = np.zeros(4, dtype)
    for name, role in zip(array.dtype.names, roles, strict=True):
        array[name] = {"t": T, "x": X, "y": Y, "p": P}[role]
    return array


ALIGNED_XYPT = np.dtype([("x", "<u2"), ("y", "<u2"), ("p", "<i2"), ("t", "<i8")], align=True)
ALIGNED_TXYP = np.dtype([("t", "<i8"), ("x", "<i2"), ("y", "<i2"), ("p", "u1")], align=True)


class TestWithoutACopy:
    def test_own_dtype_is_passed_through(self) -> None:
        events = expected()
        assert asap.as_events(events) is events
        assert asap.as_events(events, copy=False) is events
        assert asap.as_events(fake(ALIGNED_XYPT, "xypt"), copy=False).dtype == asap.EVENT_DTYPE

    def test_recarray_and_memmap_lose_their_class_not_their_memory(self, tmp_path: Path) -> None:
        events = expected()
        record = events.view(np.recarray)
        taken = asap.as_events(record)
        assert type(taken) is np.ndarray
        assert taken.dtype == asap.EVENT_DTYPE
        assert np.shares_memory(taken, events)
        np.save(tmp_path / "events.npy", events)
        mapped = np.load(tmp_path / "events.npy", mmap_mode="r")
        assert type(asap.as_events(mapped)) is np.ndarray
        assert np.shares_memory(asap.as_events(mapped), mapped)

    @pytest.mark.parametrize("why", ["stride", "layout", "polarity", "misaligned", "columns"])
    def test_copy_false_raises_where_a_copy_is_needed(self, why: str) -> None:
        events = expected()
        odd = expected(p=[1, -1, 1, 0])
        source = {
            "stride": events[::2],
            "layout": fake(ALIGNED_TXYP),
            "polarity": odd,
            "misaligned": misaligned(),
            "columns": (T, X, Y, P),
        }[why]
        with pytest.raises(ValueError, match="copy = False"):
            asap.as_events(source, copy=False)

    @pytest.mark.parametrize("by", [1, 4])
    def test_misaligned_memory_is_copied(self, by: int) -> None:
        source = misaligned(by)
        taken = asap.as_events(source)
        assert not np.shares_memory(taken, source)
        assert taken.ctypes.data % 8 == 0
        assert_equal_events(taken, expected())

    def test_other_polarity_is_copied_and_normalised(self) -> None:
        source = expected(p=[2, -1, 1, -300])
        assert_equal_events(asap.as_events(source), expected(p=[1, 0, 1, 0]))
        assert source["p"][0] == 2


def misaligned(by: int = 1) -> np.ndarray:
    memory = np.zeros(4 * 16 + 8, np.uint8)
    begin = (by - memory.ctypes.data) % 8
    source = memory[begin : begin + 4 * 16].view(asap.EVENT_DTYPE)
    source[:] = expected()
    return source


class FakeFrame:
    """Like a data frame of pandas or Polars."""

    def __init__(self, **columns: Any) -> None:
        self._data = columns
        self.columns = list(columns)

    def __getitem__(self, name: str) -> Any:
        return SimpleNamespace(to_numpy=lambda: self._data[name])

    def to_numpy(self) -> np.ndarray:
        return np.stack([np.asarray(column) for column in self._data.values()], axis=1)


class FakeArrow(FakeFrame):
    """Like a table of Arrow, whose .columns are the data."""

    def __init__(self, **columns: Any) -> None:
        super().__init__(**columns)
        self.column_names = self.columns
        self.columns = list(columns.values())


class TestColumns:
    @pytest.mark.parametrize("kind", [dict, FakeFrame, FakeArrow])
    def test_by_name_from_mappings_and_frames(self, kind: Any) -> None:
        assert_equal_events(asap.as_events(kind(y=Y, polarity=P, timestamp=T, x=X)), expected())


class TestTime:
    @pytest.mark.parametrize(
        ("t", "dtype"),
        [(2**53, "m8[s]"), (-(2**53), "m8[s]"), (2**62, "m8[Y]"), ("300000-01-01", "M8[D]")],
    )
    def test_numpy_stamps_beyond_64_bit_us_are_refused(self, t: Any, dtype: str) -> None:
        columns = (np.array([0, t], dtype), [1, 1], [2, 2], None)
        with pytest.raises(ValueError, match=rf"^t = {t}.* \(event 1\): no time in 64-bit us"):
            asap.as_events(columns)


class OpenGroup(dict[str, Any]):
    """Like a group of HDF5: a mapping that knows the one around it."""

    parent: Any = None


class TestAnOffsetOfTheTimes:
    COLUMNS = {"t": T.astype("u4"), "x": X, "y": Y, "p": P}  # noqa: RUF012

    @pytest.mark.parametrize("offset", [59_001_000_000, np.int64(-5), np.array([2**40])])
    def test_in_the_mapping_is_added(self, offset: Any) -> None:
        shifted = expected(T + np.asarray(offset).item())
        assert_equal_events(asap.as_events(self.COLUMNS | {"t_offset": offset}), shifted)

    def test_beside_the_group_is_added(self) -> None:
        group = OpenGroup(self.COLUMNS)
        group.parent = OpenGroup(events=group, t_offset=np.int64(10**12))
        assert_equal_events(asap.as_events(group), expected(T + 10**12))

    @pytest.mark.parametrize("offset", [[1, 2], 0.5, "1", 2**63 - 1], ids=str)
    def test_that_is_none_is_refused(self, offset: Any) -> None:
        with pytest.raises(ValueError, match="t_offset = "):
            asap.as_events(self.COLUMNS | {"t_offset": offset})


class TestValuesThatDoNotFit:
    def test_none_among_the_numbers(self) -> None:
        with pytest.raises(ValueError, match=r"x = None \(event 1\)"):
            asap.as_events((T, [1, None, 3, 4], Y, P))

    def test_masked_arrays(self) -> None:
        x = np.ma.masked_array(X, [False, True, False, False])
        with pytest.raises(
            ValueError, match=r"^x = masked array: take out or repair .* give array.data"
        ):
            asap.as_events((T, x, Y, P))

    @pytest.mark.parametrize(
        "dtype", [asap.EVENT_DTYPE, [("t", "f8"), ("x", "u1"), ("y", "u1"), ("p", "?")]], ids=len
    )
    def test_events_with_a_masked_field(self, dtype: Any) -> None:
        events = np.ma.masked_array(np.zeros(3, dtype))
        assert len(asap.as_events(events, time_unit="ms")) == 3
        events["p"][1] = np.ma.masked
        with pytest.raises(ValueError, match=r"^source = masked array: take out"):
            asap.as_events(events, time_unit="ms")
        valid = events[~events.mask["p"]].data
        assert len(asap.as_events(valid, time_unit="ms")) == 2

    def test_polarity_of_a_signed_bit_is_asked(self) -> None:
        one_bit = np.array([-1, 0, -1], np.int8)
        with pytest.raises(ValueError, match="p = -1: is below 0, which is OFF, as 0 is"):
            asap.as_events({"t": [1, 2, 3], "x": [1, 1, 1], "y": [1, 1, 1], "p": one_bit})

    def test_polarity_nan(self) -> None:
        with pytest.raises(ValueError, match=r"p = nan \(event 2\)"):
            asap.as_events((T, X, Y, [1, 0, np.nan, 1]))


def test_needs_numpy_alone() -> None:
    code = (
        "import sys, asap, numpy as np; asap.as_events(np.zeros(3, asap.EVENT_DTYPE)); "
        "sys.exit(any(name in sys.modules for name in ('pandas', 'polars', 'pyarrow', 'aedat')))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
