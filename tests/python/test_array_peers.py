"""Real objects of other libraries into `as_events` and back: extra array-peers.

Events come in exactly, or are refused with a remedy that works. A missing library is skipped.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import pytest

import asap
import raw_files

Make = Callable[[Any], Any]

N = 5000
NAMES = "txyp"


def stream() -> Any:
    random = np.random.default_rng(1)
    events = np.zeros(N, asap.EVENT_DTYPE)
    events["t"] = np.sort(random.integers(1_000_000, 1_200_000, N))
    events["x"], events["y"] = random.integers(0, 346, N), random.integers(0, 260, N)
    events["p"] = random.integers(0, 2, N)
    return events


EVENTS = stream()
COLUMNS = {name: np.ascontiguousarray(EVENTS[name]) for name in NAMES}
HALVES = [EVENTS[: N // 2], EVENTS[N // 2 :]]


def lib(name: str) -> Any:
    """Import it late, so that one that is missing skips one test."""
    return pytest.importorskip(name)


def columns(events: Any = EVENTS) -> dict[str, Any]:
    return {name: np.ascontiguousarray(events[name]) for name in NAMES}


class Tuple(NamedTuple):
    x: Any
    y: Any
    t: Any
    p: Any


class Own:
    def __init__(self, timestamps: Any, x: Any, y: Any, polarity: Any) -> None:
        self.timestamps, self.x, self.y, self.polarity = timestamps, x, y, polarity


def arrow(**changes: Any) -> Any:
    return lib("pyarrow").table(columns() | changes)


def polars(**changes: Any) -> Any:
    return lib("polars").DataFrame(columns() | changes)


def pandas(**changes: Any) -> Any:
    return lib("pandas").DataFrame(columns() | changes)


def duck() -> Any:
    table = arrow()
    return lib("duckdb").connect().from_arrow(table)


def dask() -> Any:
    return lib("dask.dataframe").from_pandas(pandas(), npartitions=3)


def written(suffix: str, folder: Path) -> str:
    path = folder / f"events{suffix}"
    if suffix == ".dat":
        raw_files.write_dat(path, EVENTS)
    else:
        asap.convert(EVENTS, path, width=346, height=260)
    return str(path)


def dv_store() -> Any:
    store = lib("dv_processing").EventStore()
    for t, x, y, p in zip(*columns().values(), strict=True):
        store.push_back(int(t), int(x), int(y), bool(p))
    return store


def eventcv(events: Any = EVENTS) -> Any:
    array = np.stack([events[name] for name in "xytp"], 1)
    return lib("eventcv").from_numpy(array, order="xytp", time_unit="us")


def of_dtype(*fields: tuple[str, str], names: str = NAMES) -> Any:
    array = np.zeros(N, list(fields))
    for name, role in zip(array.dtype.names, names, strict=True):
        array[name] = EVENTS[role]
    return array


def mapped(folder: Path) -> Any:
    np.save(folder / "events.npy", EVENTS)
    return np.load(folder / "events.npy", mmap_mode="r")


def h5() -> Any:
    file = lib("h5py").File(io.BytesIO(), "w")
    for name, column in columns().items():
        file[f"events/{name}"] = column
    file["array"] = EVENTS
    return file


def rows_down(packet: Any) -> Any:
    packet["y"] = 259 - packet["y"]
    return packet


def seconds(kind: str = "f8") -> Any:
    return (EVENTS["t"] / 1e6).astype(kind)


def tx(*roles: str) -> tuple[Any, ...]:
    return tuple(np.ascontiguousarray(EVENTS[role]) for role in roles)


EXACT: dict[str, Make] = {
    # NumPy and Python
    "structured": lambda _: of_dtype(("t", "<u8"), ("x", "<u2"), ("y", "<u2"), ("on", "?")),
    "recarray": lambda _: EVENTS.view(np.recarray),
    "strided": lambda _: np.repeat(EVENTS, 2)[::2],
    "dict": lambda _: columns(),
    "dict of lists": lambda _: {name: column.tolist() for name, column in columns().items()},
    "four columns": lambda _: tx(*NAMES),
    "list of arrays": lambda _: HALVES,
    "tuple of 4 arrays": lambda _: tuple(np.array_split(EVENTS, 4)),
    "list of tuples of columns": lambda _: [tuple(columns(half).values()) for half in HALVES],
    "list of named tuples": lambda _: [Tuple(*(h[n] for n in "xytp")) for h in HALVES],
    "own class": lambda _: Own(*tx(*NAMES)),
    "read-only": lambda _: EVENTS[:],
    "not aligned": lambda _: np.frombuffer(b"0" + EVENTS.tobytes(), asap.EVENT_DTYPE, offset=1),
    "big endian": lambda _: of_dtype(("t", ">i8"), ("x", ">u2"), ("y", ">u2"), ("p", ">i2")),
    "event_camera_py": lambda _: of_dtype(
        ("x", "<u2"), ("y", "<u2"), ("p", "i1"), ("t", "<i4"), names="xypt"
    ),
    "ptyx, other names": lambda _: of_dtype(
        ("pol", "<i4"), ("time", "<u4"), ("y", "<u4"), ("x", "<i4"), names="ptyx"
    ),
    "half floats": lambda _: of_dtype(("t", "<i8"), ("x", "<f2"), ("y", "<f2"), ("p", "<f2")),
    "titles": lambda _: of_dtype(
        (("time", "t"), "<i8"), ("x", "<i2"), ("y", "<i2"), (("polarity", "p"), "i1")
    ),
    "other fields too": lambda _: columns() | {"id": np.arange(N), "exposure": np.zeros(N, "?")},
    "polarity -1, 1": lambda _: columns() | {"p": EVENTS["p"] * 2 - 1},
    "polarity 0, 255": lambda _: columns() | {"p": (EVENTS["p"] * 255).astype("u1")},
    "floating pixels": lambda _: columns() | {"x": EVENTS["x"].astype("f4")},
    "timedelta": lambda _: columns() | {"t": EVENTS["t"].astype("m8[us]")},
    "datetime": lambda _: columns() | {"t": EVENTS["t"].astype("M8[us]")},
    "datetime in ns": lambda _: columns() | {"t": (EVENTS["t"] * 1000).astype("M8[ns]")},
    "t_offset of DSEC": lambda _: columns() | {"t": EVENTS["t"] - 7, "t_offset": 7},
    "tuple of four lists": lambda _: tuple(column.tolist() for column in tx(*NAMES)),
    "list with an empty one": lambda _: [EVENTS[:0], EVENTS],
    "list of mixed kinds": lambda _: [HALVES[0], columns(HALVES[1])],
    "memory map": lambda path: mapped(path),
    "npz": lambda path: np.load(written(".npz", path)),
    "masked, nothing hidden": lambda _: np.ma.MaskedArray(EVENTS),
    # Arrow
    "arrow table": lambda _: arrow(),
    "arrow batch": lambda _: arrow().to_batches()[0],
    "arrow reader": lambda _: arrow().to_reader(max_chunksize=999),
    "arrow struct": lambda _: arrow().to_struct_array().chunk(0),
    "arrow batches": lambda _: arrow().to_batches(max_chunksize=999),
    "arrow dictionary": lambda _: arrow().set_column(3, "p", arrow()["p"].dictionary_encode()),
    "arrow chunked": lambda _: lib("pyarrow").concat_tables(
        [arrow().slice(0, 9), arrow().slice(9)]
    ),
    "arrow duration": lambda _: arrow(t=EVENTS["t"].astype("m8[us]")),
    "arrow boolean": lambda _: arrow(p=EVENTS["p"] > 0),
    # polars
    "polars": lambda _: polars(),
    "polars struct": lambda _: polars().to_struct("events"),
    "polars list of 4": lambda _: list(polars().iter_slices(N // 4)),
    "polars boolean": lambda _: polars(p=EVENTS["p"] > 0),
    "polars duration": lambda _: polars(t=EVENTS["t"].astype("m8[us]")),
    "polars chunked": lambda _: lib("polars").concat([polars()[:9], polars()[9:]], rechunk=False),
    "evlib": lambda path: lib("evlib").load_events(written(".raw", path)).collect(),
    # pandas
    "pandas": lambda _: pandas(),
    "pandas nullable": lambda _: pandas().convert_dtypes(),
    "pandas of arrow": lambda _: pandas().convert_dtypes(dtype_backend="pyarrow"),
    "pandas list of 4": lambda _: [pandas().iloc[i : i + N // 4] for i in range(0, N, N // 4)],
    "pandas timedelta": lambda _: pandas(t=EVENTS["t"].astype("m8[us]")),
    "pandas datetime with a zone": lambda _: pandas(
        t=lib("pandas").to_datetime(EVENTS["t"], unit="us", utc=True).tz_convert("Asia/Tokyo")
    ),
    "t as index": lambda _: pandas().set_index("t"),
    "t as index of two": lambda _: pandas().set_index(["t", "x"]),
    "pandas boolean": lambda _: pandas(p=EVENTS["p"] > 0),
    # duckdb, dask, xarray, h5py
    "h5py group": lambda _: h5()["events"],
    "duckdb relation": lambda _: duck(),
    "duckdb reader": lambda _: duck().arrow(),
    "dask arrays": lambda _: {
        name: lib("dask.array").from_array(column) for name, column in columns().items()
    },
    "xarray": lambda _: lib("xarray").Dataset({k: ("n", v) for k, v in columns().items()}),
    "xarray, t as index": lambda _: lib("xarray").Dataset(
        {name: ("t", COLUMNS[name]) for name in "xyp"}, coords={"t": COLUMNS["t"]}
    ),
    # event libraries
    "neuromorphic-drivers": lambda _: SimpleNamespace(
        polarity_events=of_dtype(("t", "<u8"), ("x", "<u2"), ("y", "<u2"), ("on", "?"))
    ),
    "faery": lambda path: lib("faery").events_stream_from_file(written(".es", path)).to_array(),
    "event_stream": lambda path: [
        rows_down(packet) for packet in lib("event_stream").Decoder(written(".es", path))
    ],
    "evt3": lambda path: lib("evt3").decode_file(written(".raw", path)),
    "expelliarmus": lambda path: lib("expelliarmus").Wizard(encoding="dat").read(
        written(".dat", path)
    ),
    "tonic": lambda _: of_dtype(
        ("x", "<i2"), ("y", "<i2"), ("t", "<i8"), ("p", "?"), names="xytp"
    ),
    "evt3 batches": lambda path: [*lib("evt3").decode_file_batches(written(".raw", path))],
    "expelliarmus chunks": lambda path: [
        *lib("expelliarmus").Wizard(
            fpath=written(".dat", path), encoding="dat", chunk_size=999
        ).read_chunk()
    ],
    "faery stream": lambda path: [*lib("faery").events_stream_from_file(written(".es", path))],
    "neuromorphic-drivers packets": lambda _: [
        SimpleNamespace(polarity_events=None), SimpleNamespace(polarity_events=EVENTS)
    ],
    "dv-processing": lambda _: dv_store(),
    "eventcv": lambda _: eventcv(),
    "aedat": lambda path: [
        packet["events"] for packet in lib("aedat").Decoder(written(".aedat4", path))
    ],
}  # fmt: skip

OPTIONS: dict[str, tuple[Make, dict[str, Any]]] = {
    "rows": (lambda _: np.stack([EVENTS[role] for role in "txyp"], 1), {"order": "txyp"}),
    "rows in big endian, by columns": (
        lambda _: np.stack([EVENTS[n] for n in "xytp"], 1).astype(">f8", "F"),
        {"order": "xytp", "time_unit": "us"},
    ),
    "rows of xarray": (
        lambda _: lib("xarray").DataArray(np.stack([EVENTS[role] for role in "xytp"], 1)),
        {"order": "xytp"},
    ),
    "list of rows": (
        lambda _: [np.stack([half[role] for role in "ytxp"], 1) for half in HALVES],
        {"order": "ytxp"},
    ),
    "columns in order": (lambda _: tx("x", "y", "t", "p"), {"order": "xytp"}),
    "s": (lambda _: columns() | {"t": seconds()}, {"time_unit": "s"}),
    "ns": (lambda _: columns() | {"t": EVENTS["t"] * 1000}, {"time_unit": "ns"}),
    "floating us": (lambda _: columns() | {"t": seconds() * 1e6}, {"time_unit": "us"}),
    "float32 s, short": (
        lambda _: columns() | {"t": seconds("f4")},
        {"time_unit": "s"},
    ),
    "ms": (lambda _: columns() | {"t": EVENTS["t"] / 1e3}, {"time_unit": "ms"}),
    "floating rows, s": (
        lambda _: np.stack([seconds(), *(EVENTS[n] for n in "xyp")], 1),
        {"order": "txyp", "time_unit": "s"},
    ),
    "rows of pandas": (
        lambda _: pandas().set_axis([0, 1, 2, 3], axis=1),
        {"order": "txyp"},
    ),
    "bimvee": (
        lambda _: {"ts": seconds(), "x": EVENTS["x"], "y": EVENTS["y"], "pol": EVENTS["p"] > 0},
        {"time_unit": "s"},
    ),
    "eventcv array": (lambda _: eventcv().numpy(), {"order": "xytp"}),
}

# Refused objects, with the words that help.
REFUSED: dict[str, tuple[Make, dict[str, Any], str]] = {
    "a path": (lambda _: "events.raw", {}, r"asap\.load"),
    "rows without order": (lambda _: np.stack(tx(*NAMES), 1), {}, "give order"),
    "x first": (lambda _: tx("x", "y", "t", "p"), {}, "order='xytp'"),
    "order and names": (lambda _: Tuple(*tx("x", "y", "t", "p")), {"order": "txyp"}, "leave order"),
    "floating s": (lambda _: columns() | {"t": seconds()}, {}, "time_unit='s'"),
    "float32 s": (
        lambda _: columns() | {"t": seconds("f4") + np.float32(1000)},
        {"time_unit": "s"},
        "float32.* 61 us; give float64",
    ),
    "polarity 1, 2": (lambda _: columns() | {"p": EVENTS["p"] + 1}, {}, "p = 1: .*give p == 2"),
    "exposure": (
        lambda _: columns() | {"exposure": np.arange(N) % 2 > 0},
        {},
        r"~events\['exposure'\]",
    ),
    "a packet of aedat": (lambda _: {"events": EVENTS, "stream_id": 0}, {}, r"source\['events'\]"),
    "with a target": (lambda _: (EVENTS, 3), {}, "source is a tuple of 2"),
    "capital names": (lambda _: polars().rename(str.upper), {}, "no field for t"),
    "struct column": (
        lambda _: lib("polars").DataFrame({"events": polars().to_struct("events")}),
        {},
        r"source\['events'\]",
    ),
    "order and pandas": (lambda _: pandas(), {"order": "txyp"}, "leave order out"),
    "order and rows of 3": (lambda _: np.zeros((9, 3)), {"order": "txyp"}, "names 4 columns"),
    "two fields for t": (lambda _: columns() | {"ts": EVENTS["t"]}, {}, r"two fields \(t, ts\)"),
    "a container of bimvee": (
        lambda _: {"data": {"left": {"dvs": columns()}}, "info": {}},
        {},
        "no field for t",
    ),
    "an image": (lambda _: np.zeros((3, 10, 10)), {}, "shape"),
    "some without polarity": (lambda _: [columns(), columns() | {"p": None}], {}, "no polarity"),
    "a function": (lambda _: eventcv, {}, "call it"),
    "mask": (lambda _: np.ma.MaskedArray(EVENTS, mask=True), {}, "masked"),
}


@pytest.mark.parametrize("name", EXACT)
def test_it_enters_as_it_is(name: str, tmp_path: Path) -> None:
    events = asap.as_events(EXACT[name](tmp_path))
    assert np.array_equal(events, EVENTS)


@pytest.mark.parametrize("name", OPTIONS)
def test_it_enters_with_what_it_does_not_say(name: str, tmp_path: Path) -> None:
    make, options = OPTIONS[name]
    assert np.array_equal(asap.as_events(make(tmp_path), **options), EVENTS)


@pytest.mark.parametrize("name", EXACT)
def test_it_enters_simulate_and_push(name: str, tmp_path: Path) -> None:
    source = EXACT[name](tmp_path)
    run = asap.simulate(source, cost=asap.LinearCost(1, 1), width=346, height=260)
    assert run.ledger.delivered == N
    pipeline = asap.Pipeline()
    pipeline.push(EXACT[name](tmp_path))
    assert pipeline.ledger.received == N


@pytest.mark.parametrize("name", REFUSED)
def test_it_is_refused_with_the_words_that_help(name: str, tmp_path: Path) -> None:
    make, options, words = REFUSED[name]
    with pytest.raises((TypeError, ValueError), match=words):
        asap.as_events(make(tmp_path), **options)


def test_whole_times_in_another_unit_are_doubted() -> None:
    with pytest.warns(UserWarning, match="give time_unit"):
        asap.as_events(columns() | {"t": (EVENTS["t"] * 1e-6).astype(np.int64)})


def test_a_lazy_frame_is_computed_by_its_owner() -> None:
    with pytest.raises(TypeError, match=r"call its compute\(\) first"):
        asap.as_events(dask())


# ---- the way back ---------------------------------------------------------------------------

DTYPES: dict[str, Callable[[], Any]] = {
    "faery": lambda: lib("faery").EVENTS_DTYPE,
    "event_stream": lambda: lib("event_stream").dvs_dtype,
    "event_stream, atis": lambda: lib("event_stream").atis_dtype,
    "evutils": lambda: lib("evutils").Event_dtype,
    "dv-processing": lambda: dv_store().numpy().dtype,
    "tonic": lambda: lib("tonic").io.events_struct,
    "expelliarmus": lambda: [("t", "<i8"), ("x", "<i2"), ("y", "<i2"), ("p", "u1")],
    "neuromorphic-drivers": lambda: [("t", "<u8"), ("x", "<u2"), ("y", "<u2"), ("on", "?")],
    "big endian": lambda: [("polarity", ">i4"), ("y", ">u2"), ("ts", ">u8"), ("x", ">u4")],
    "own": lambda: asap.EVENT_DTYPE,
}


@pytest.mark.parametrize("name", DTYPES)
def test_there_and_back(name: str) -> None:
    dtype = np.dtype(DTYPES[name]())
    there = asap.to_dtype(EVENTS, dtype)
    assert there.dtype == dtype
    assert np.array_equal(asap.as_events(there), EVENTS)


def test_the_libraries_take_what_comes_back(tmp_path: Path) -> None:
    event_stream = lib("event_stream")
    path = tmp_path / "back.es"
    with event_stream.Encoder(str(path), "dvs", 346, 260) as encoder:
        encoder.write(asap.to_dtype(EVENTS, event_stream.dvs_dtype))
    with event_stream.Decoder(str(path)) as decoder:
        assert np.array_equal(asap.as_events(list(decoder)), EVENTS)


@pytest.mark.parametrize(
    ("dtype", "words"),
    [
        ([("t", "<u2"), ("x", "<u2"), ("y", "<u2"), ("p", "?")], r"t = \d+ \(event 0\): does not"),
        ([("t", "<i8"), ("x", "i1"), ("y", "<u2"), ("p", "?")], "x = .* does not fit"),
        ([("t", "<f8"), ("x", "<u2"), ("y", "<u2"), ("p", "?")], "t needs a field of whole"),
        ([("t", "<i8"), ("x", "<u2"), ("y", "<u2")], "no field for p"),
        ("<i8", "no field for t"),
    ],
)
def test_a_layout_that_cannot_hold_them(dtype: Any, words: str) -> None:
    with pytest.raises((TypeError, ValueError), match=words):
        asap.to_dtype(EVENTS, dtype)
