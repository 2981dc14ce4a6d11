"""The native pass over columns of events: the same events and the same refusals as NumPy's."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from asap.events import misfits, pack, pack_good
from event_files import assert_equal_events
from fuzzing import effort

NATIVE = ("?", "u1", "u2", "u4", "u8", "i1", "i2", "i4", "i8", "f8")
OTHERS = ("f4", ">u2", ">i8", ">f8", "M8[us]")
TIMES = ("u1", "i4", "u8", "i8", "f8")
NEAR = (-1, 0, 1, 2, 127, 65535, 65536, 2**31 - 1, 2**31, 2**53 + 1, 2**62, 2**63 - 1)
FLOATS = (*map(float, NEAR), 0.5, 1.5, -2.5, 1e-9, 1504645177.420985, 1e18, 1e300, float("nan"))


@st.composite
def column(draw: st.DrawFn, dtypes: tuple[str, ...]) -> np.ndarray:
    """Three values, often ones at the edge of what an event can hold."""
    dtype = np.dtype(draw(st.sampled_from(dtypes)))
    if dtype.kind == "f":
        values = st.sampled_from(FLOATS) | st.floats(0, 60_000) | st.integers(0, 300).map(float)
    else:
        low, high = (0, 1) if dtype.kind == "b" else (np.iinfo(dtype).min, np.iinfo(dtype).max)
        near = [value for value in (*NEAR, int(low), int(high)) if low <= value <= high]
        values = st.sampled_from(near) | st.integers(0, min(int(high), 300))
    strided = np.zeros(6, dtype)
    strided[::2] = draw(st.lists(values, min_size=3, max_size=3))
    return strided[::2]


@effort(300)
@given(
    t=column(TIMES), x=column(NATIVE), y=column(NATIVE), p=column(NATIVE),
    exponent=st.sampled_from((-3, 0, 3, 6)), normalise=st.booleans(),
)  # fmt: skip
@pytest.mark.filterwarnings("ignore:overflow encountered:RuntimeWarning")
def test_agrees_with_numpy(t: Any, x: Any, y: Any, p: Any, exponent: int, normalise: bool) -> None:
    columns = {"t": t, "x": x, "y": y, "p": p}
    found = pack_good(columns, exponent, normalise=normalise)
    if exponent and t.dtype.kind != "f":
        assert found is None
        return
    masks = (misfits(role, column, exponent) for role, column in columns.items())
    if any(mask is not None and mask.any() for mask in masks):
        assert found is None
    else:
        assert found is not None
        assert_equal_events(found, pack(columns, exponent, normalise=normalise))


@pytest.mark.parametrize("dtype", OTHERS)
def test_leaves_other_types_to_numpy(dtype: str) -> None:
    zeros = np.zeros(3, "u2")
    columns = dict.fromkeys("txyp", zeros)
    assert pack_good(columns) is not None
    for role in "txyp":
        assert pack_good(columns | {role: np.zeros(3, dtype)}) is None


def test_leaves_columns_of_different_lengths_to_numpy() -> None:
    columns = dict.fromkeys("txyp", np.zeros(3, "u2"))
    for role in "txyp":
        assert pack_good(columns | {role: np.zeros(2, "u2")}) is None
        assert pack_good(columns | {role: np.zeros((3, 1), "u2")}) is None


def test_a_column_may_be_read_backwards() -> None:
    t = np.arange(5)
    found = pack_good({"t": t[::-1], "x": t, "y": t})
    assert found is not None
    assert found["t"].tolist() == [4, 3, 2, 1, 0]
    assert found["p"].tolist() == [1] * 5
