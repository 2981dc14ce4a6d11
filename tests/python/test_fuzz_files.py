"""Files that anybody may have damaged: events, or one of three kinds of error, never more memory.

R11 of the reliability goals. What was found like this is an `example` here or a test in test_io_*.
"""

from __future__ import annotations

import io
import struct
import tracemalloc
import warnings
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import asap
from aedat4_files import write_aedat4
from asap.events import Events
from corrupt import clean_events
from event_files import recording
from fuzzing import INTERESTING, damaged, effort
from record_files import FORMATS, PLAIN, SIDE, Format

MAX_MEMORY = 64 << 20  # bytes, for files of a few kilobytes
OPTIONS = st.fixed_dictionaries(
    {},
    optional={
        "order": st.sampled_from(("txyp", "yxt", "xytp")),
        "time_unit": st.sampled_from(("s", "ms", "us", "ns")),
        "on_bad": st.sampled_from(("drop", "clamp", "raise")),
        "width": st.sampled_from((1, 346)),
        "height": st.sampled_from((1, 260)),
    },
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    tracemalloc.start()
    yield tmp_path_factory.mktemp("fuzz")
    tracemalloc.stop()


def check_load(path: Path, content: bytes, options: dict[str, Any]) -> None:
    """Events in order, or an error that the documentation names; and no more memory than that."""
    path.write_bytes(content)
    tracemalloc.reset_peak()
    before, _ = tracemalloc.get_traced_memory()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", asap.io.LossWarning)
            warnings.filterwarnings("ignore", ".* is read as 40-bit events")
            events = asap.load(path, **options)
    except (ValueError, OSError, RuntimeError) as error:
        assert str(error)
    else:
        assert events.dtype == asap.EVENT_DTYPE
        assert (np.diff(events["t"]) >= 0).all()
        assert np.isin(events["p"], (0, 1)).all()
        if options.get("width") == 1 and path.suffix == ".npy":
            assert not events["x"].any()
    _, peak = tracemalloc.get_traced_memory()
    assert peak - before < MAX_MEMORY


# ---- good files, damaged --------------------------------------------------------------------


def write_h5(path: Path, events: Events) -> None:
    pytest.importorskip("h5py")
    asap.convert(events, path, to="dsec")


def write_mat(path: Path, events: Events) -> None:
    columns = {name: events[name] for name in "txyp"}
    pytest.importorskip("scipy.io").savemat(path, columns, do_compression=True)


def write_packets(path: Path, events: Events) -> None:
    write_aedat4(path, [(0, events[:20]), (0, events[20:])])


MORE = {"aedat4": write_packets, "h5": write_h5, "mat": write_mat}
GOOD = FORMATS | PLAIN | {kind: Format(write, kind, f".{kind}") for kind, write in MORE.items()}


@pytest.fixture(scope="module", params=GOOD)
def good(request: pytest.FixtureRequest, folder: Path) -> tuple[str, bytes]:
    form: Format = GOOD[request.param]
    path = folder / f"good{form.suffix}"
    events = clean_events(40)
    events["x"] %= SIDE
    events["y"] %= SIDE
    form.write(path, events)
    return form.suffix, path.read_bytes()


@effort(40)
@given(data=st.data(), options=OPTIONS)
def test_a_damaged_file(
    good: tuple[str, bytes], folder: Path, data: st.DataObject, options: dict[str, Any]
) -> None:
    suffix, content = good
    check_load(folder / f"damaged{suffix}", data.draw(damaged(content)), options)


@effort(25)
@given(data=st.data())
def test_a_damaged_aedat4(folder: Path, data: st.DataObject) -> None:
    pytest.importorskip("lz4")
    content = recording("aedat/cars_davis346.aedat4").read_bytes()[:40_000]
    check_load(folder / "damaged.aedat4", data.draw(damaged(content)), {})


@effort(40)
@given(
    st.sampled_from((b"", b"\x93NUMPY", b"PK\x03\x04", b"PK\x05\x06", b"#!AER-DAT4.0\r\n", b"%",
                     b"% evt 2.0\n", b"% evt 2.1\n", b"% evt 3.0\n", b"% evt 3.0\n% geometry 9x9\n",
                     b"% Data file containing CD events.\n", b"% Version 1\n\x0c\x08",
                     b"Event Stream\x01\0\0", b"Event Stream\x02\0\0\x01\x80\0\x80\0",
                     b"#!AER-DAT2.0\r\n# AEChip: DAVIS240C\r\n", b"#!AER-DAT2.0\r\n",
                     b"#!AER-DAT3.1\r\n#Format: RAW\r\n#!END-HEADER\r\n\x01\0\0\0")),
    st.binary(max_size=300),
    st.sampled_from(("npy", "npz", "txt", "csv", "aedat4", "raw", "dat", "bin", "es", "aedat", "")),
)  # fmt: skip
def test_any_bytes_under_any_name(folder: Path, magic: bytes, rest: bytes, suffix: str) -> None:
    check_load(folder / f"any.{suffix}", magic + rest, {})


# ---- headers that lie -----------------------------------------------------------------------

NUMBERS = st.one_of(
    st.sampled_from((*INTERESTING, 10**30, -1, 10**12)), st.integers(0, 50), st.integers()
)
DESCRIPTIONS = st.one_of(
    st.sampled_from(
        (
            "<f8", "<i8", "|O", "|V0", "<U0", "<U99999999", "|V2147483647", "<M8[s]", "|b1", "<c16",
            "nonsense", "", None, [], {}, 7, ["<i8"], [("t", "<i8")],
            [("t", "|O"), ("x", "<u2"), ("y", "<u2")],
            [("t", "<i8", (2,)), ("x", "<u2"), ("y", "<u2")],
            [("t", "<i8"), ("x", "|S4"), ("y", "<u2")],
            [("t", "<i8"), ("x", "<u2"), ("y", "<u2"), ("p", "<i1"), ("on", "<i1")],
        )
    ),
    st.lists(
        st.tuples(
            st.sampled_from(("t", "x", "y", "p", "ts", "on", "z")),
            st.sampled_from(("<i8", ">u2", "<u2", "|i1", "<f4", "|b1", "<m8[us]", "|V3")),
        ),
        min_size=3,
        max_size=5,
        unique_by=lambda field: field[0],
    ),
)  # fmt: skip


def npy(descr: object, shape: object, fortran: object, body: bytes) -> bytes:
    header = repr({"descr": descr, "fortran_order": fortran, "shape": shape}).encode() + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header + body


HEADERS = st.builds(
    npy,
    DESCRIPTIONS,
    st.one_of(st.lists(NUMBERS, max_size=3).map(tuple), NUMBERS, st.just(("5",))),
    st.sampled_from((False, True, False, None)),
    st.binary(max_size=200),
)


def npz(members: dict[str, bytes], method: int) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", method) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return buffer.getvalue()


def array(values: object) -> bytes:
    buffer = io.BytesIO()
    np.save(buffer, np.asarray(values), allow_pickle=False)
    return buffer.getvalue()


COLUMNS = {f"{name}.npy": array(np.arange(3)) for name in "txyp"}


@effort(60)
@given(
    st.dictionaries(
        st.sampled_from(("t.npy", "x.npy", "y.npy", "p.npy", "width.npy", "events.npy", "a.txt")),
        st.one_of(
            HEADERS,
            st.sampled_from((1.5, np.inf, np.nan, "abc", 1j, -3, 2**40, [1, 2], True)).map(array),
            st.binary(max_size=60),
        ),
        max_size=4,
    ),
    st.booleans(),
    st.sampled_from((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2)),
)
@example({"width.npy": array(np.inf)}, True, zipfile.ZIP_STORED)
@example({"width.npy": array(1j)}, True, zipfile.ZIP_STORED)
@example({"width.npy": array(2**40)}, True, zipfile.ZIP_STORED)
@example({"width.npy": array("7")}, True, zipfile.ZIP_STORED)
def test_an_npz_of_strange_members(
    folder: Path, members: dict[str, bytes], with_columns: bool, method: int
) -> None:
    content = npz((COLUMNS if with_columns else {}) | members, method)
    check_load(folder / "strange.npz", content, {})
