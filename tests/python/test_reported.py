"""What people ran into with other tools, a file for each: the right events, or the right words."""

from __future__ import annotations

import json
import shutil
import sqlite3
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
import raw_files
from asap.cli import main
from asap.events import Events
from corrupt import clean_events
from event_files import assert_equal_events, recording
from record_files import aedat3

EVENTS = clean_events(1000)
LIBRARIES = {
    **{".h5": "h5py", ".mat": "scipy", ".aedat4": "lz4", ".mcap": "mcap"},
    **{"lost_bag": "rosbags", "message_db3.db3": "zstandard"},
}


def reported(name: str) -> Path:
    """Path of a reported file; skips the test where it, or what reads it, is absent."""
    for end, library in LIBRARIES.items():
        if name.endswith(end):
            pytest.importorskip(library)
    return recording(f"reported/{name}")


def written(path: Path, events: Events, **sensor: int) -> None:
    """Write a file of that suffix; ``.raw`` is EVT2."""
    if path.suffix in (".raw", ".dat"):
        raw_files.WRITERS["dat" if path.suffix == ".dat" else "evt2"](path, events, **sensor)
    else:
        asap.convert(events, path, **sensor)


def truth(name: str = "scene.npz") -> Events:
    """Return the events that are in the file."""
    with np.load(recording(f"reported/{name}")) as columns:
        return asap.as_events({role: columns[role] for role in "txyp"})


@pytest.fixture(autouse=True)
def _quiet() -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        yield


ROWS: list[tuple[str, dict[str, Any]]] = [
    ("wal_half/bag_0.db3", {}),
    ("padded.raw", {}),
    ("swapped.csv", {"reorder_tolerance_us": 20_000}),
    ("message_db3/message_db3.db3", {}),
    ("long_comment_xypt.csv", {"order": "xypt"}),
    ("celex.csv", {"order": "yx-pt"}),
    ("stereo.aedat4", {"stream": "Left"}),
    ("matrix_called_data.h5", {"order": "txyp"}),
    ("matrix_called_data.h5", {"stream": "data", "order": "txyp"}),
    ("geometry.csv", {"order": "xypt"}),
    ("four_rows.npy", {"order": "txyp"}),
    ("nested.mat", {}),
]


@pytest.mark.parametrize(("name", "options"), ROWS, ids=lambda value: str(value))
def test_the_scene_comes_out(
    name: str, options: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    path = reported(name)
    assert_equal_events(asap.load(path, **options), truth())
    words = [f"--{key.replace('_', '-')}={value}" for key, value in options.items()]
    words = [word.replace("-us=20000", "=20ms") for word in words]
    assert main(["info", str(path), "--json", *words]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["events"] == len(truth()) and sum(facts["rejected"].values()) == 0
    if "tolerance" not in str(options):
        assert main(["check", str(path), *words]) == 0


def test_a_log_beside_a_database_is_read_and_nothing_is_written(tmp_path: Path) -> None:
    folder = tmp_path / "bag"
    shutil.copytree(reported("wal_half/bag_0.db3").parent, folder)
    for file in folder.iterdir():
        file.chmod(0o444)
    before = {file.name: file.read_bytes() for file in folder.iterdir()}
    for path in (folder / "bag_0.db3", folder):
        assert_equal_events(asap.load(path), truth())
    assert {file.name: file.read_bytes() for file in folder.iterdir()} == before


def test_a_journal_beside_a_database_is_rolled_back(tmp_path: Path) -> None:
    path = shutil.copyfile(reported("split/rosbag2_0.db3"), tmp_path / "bag.db3")
    killed = sqlite3.connect(path, isolation_level=None)
    killed.execute("PRAGMA cache_size = 1")
    killed.execute("BEGIN")
    killed.execute("DELETE FROM messages")
    half = tmp_path / "half.db3"
    shutil.copyfile(path, half)
    shutil.copyfile(f"{path}-journal", f"{half}-journal")
    killed.close()
    assert_equal_events(asap.load(half), truth()[:1000])


def test_nothing_is_decoded_across_a_gap(capsys: pytest.CaptureFixture[str]) -> None:
    path = reported("lost_bag")
    bag = asap.read(path)
    with pytest.warns(asap.io.LossWarning, match="7 packets are missing"):
        events = np.concatenate(list(bag))
    arrived = set(truth("lost_bag.truth.npz").tolist())
    assert len(arrived) > len(events) > 0.8 * len(arrived)
    assert set(events.tolist()) <= arrived
    assert bag.lost_packets == asap.info(path)["lost_packets"] == 7
    assert main(["check", str(path)]) == 1
    assert "7 packets never arrived" in capsys.readouterr().out


def test_the_layout_of_aedat_2_is_known_or_asked() -> None:
    path = reported("v2e_640.aedat")
    with pytest.raises(asap.io.UnsupportedFormat, match="640 x 480"):
        asap.read(path)
    assert_equal_events(asap.load(path, width=640, height=480), truth("v2e_640.aedat.truth.npz"))


@pytest.mark.parametrize("named", ["", "#Source 1: DAVIS346\r\n"])
def test_cameras_that_no_header_of_aedat_3_names_are_streams(named: str, tmp_path: Path) -> None:
    events, others = EVENTS[:400], EVENTS[400:]
    lines = f"#Format: RAW\r\n{named}"
    content = (
        aedat3(events, lines, source=1)
        + aedat3(others, lines, source=2).partition(b"HEADER\r\n")[2]
    )
    path = tmp_path / "cameras.aedat"
    path.write_bytes(content)
    with pytest.raises(ValueError, match="2 streams of events"):
        asap.read(path)
    assert_equal_events(asap.load(path, stream="1"), events)
    second = asap.read(path, stream="2")
    assert second.width is None
    assert_equal_events(np.concatenate(list(second)), others)


def test_several_cameras_of_one_aedat_are_streams() -> None:
    path = reported("four.aedat")
    with pytest.raises(ValueError, match=r"4 streams of events \(0, 1, 2, 3\)"):
        asap.read(path)
    assert [len(asap.load(path, stream=str(number))) for number in range(4)] == [1000] * 4


def test_rows_of_an_event_stream_count_from_the_bottom() -> None:
    assert asap.load(reported("top_row.es"))["y"].tolist() == [0, 0, 0]


def test_disorder_is_measured_and_its_remedy_works() -> None:
    path = reported("swapped.csv")
    finding = asap.check(path).findings["back_steps"]
    assert "largest 20 ms" in finding.detail
    tolerance_us = int(finding.remedy.partition("reorder_tolerance_us=")[2].partition(")")[0])
    in_order = asap.read(path, reorder_tolerance_us=tolerance_us)
    assert_equal_events(np.concatenate(list(in_order)), truth())
    assert in_order.repaired["sorted_stamps"] > 0


@pytest.mark.parametrize("suffix", [".npz", ".csv"])
def test_pixels_between_pixels_are_named_and_rounded(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"undistorted{suffix}"
    x, y = EVENTS["x"] + 0.25, EVENTS["y"] - 0.25
    if suffix == ".npz":
        np.savez(path, t=EVENTS["t"], x=x, y=y, p=EVENTS["p"])
    else:
        lines = zip(EVENTS["t"].tolist(), x, y, EVENTS["p"].tolist(), strict=True)
        path.write_text("".join(f"{t} {x} {y} {p}\n" for t, x, y, p in lines))
    with pytest.raises(asap.io.NoGoodEvent, match="x and y lie between pixels"):
        asap.load(path)
    assert_equal_events(asap.load(path, on_bad="clamp"), EVENTS)
    assert "--on-bad clamp" in asap.check(path).findings["bad_records"].remedy


def test_a_folder_of_parts_is_one_recording() -> None:
    first = reported("split/rosbag2_0.db3")
    parts = [first.with_name(f"rosbag2_{number}.db3") for number in range(3)]
    assert_equal_events(asap.load(first.parent), truth()[:3000])
    assert_equal_events(asap.load(parts[1:]), truth()[1000:3000])
    with pytest.warns(UserWarning, match="one of 3 parts"):
        asap.load(first)


@pytest.mark.parametrize("metadata", ["", "rosbag2_bagfile_information:\n  version: 9\n"])
def test_metadata_that_a_killed_recorder_left_are_none(metadata: str, tmp_path: Path) -> None:
    shutil.copytree(reported("split/rosbag2_0.db3").parent, tmp_path / "bag")
    (tmp_path / "bag" / "metadata.yaml").write_text(metadata)
    assert_equal_events(asap.load(tmp_path / "bag"), truth()[:3000])


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n", "git lfs pull"),
        (b"\n<!DOCTYPE html><html></html>", "a web page"),
        (b"<HTML><body>404</body></HTML>", "a web page"),
    ],
)
@pytest.mark.parametrize("suffix", [".raw", ".csv", ".aedat4", ".h5", ".bin"])
def test_what_stands_for_a_recording_is_named(
    content: bytes, words: str, suffix: str, tmp_path: Path
) -> None:
    path = tmp_path / f"events{suffix}"
    path.write_bytes(content)
    with pytest.raises(asap.io.UnsupportedFormat, match=words):
        asap.read(path)


def test_without_order_long_comments_lead_to_the_right_question() -> None:
    with pytest.raises(ValueError, match=r"fourth column .* order='xypt'"):
        asap.read(reported("long_comment_xypt.csv"))


@pytest.mark.parametrize("order", ["xytp", "yxtp"])
def test_columns_of_text_that_begin_with_no_time_are_asked(order: str, tmp_path: Path) -> None:
    path = write(tmp_path / "events.txt", {role: EVENTS[role] for role in order})
    with pytest.raises(ValueError, match=r"third column of .* order='xytp'"):
        asap.read(path)
    assert_equal_events(asap.load(path, order=order), EVENTS)


def test_messages_of_ros_1_in_mcap() -> None:
    events = asap.load(reported("ros1_dvs.mcap"))
    expected = truth()
    expected["t"] += 100_000_000
    assert_equal_events(events, expected)


def test_matrices_of_an_archive_are_streams(tmp_path: Path) -> None:
    matrix = np.column_stack([EVENTS[role] for role in "txyp"])
    path = tmp_path / "events.npz"
    np.savez(path, left=matrix, right=matrix[:9], labels=np.arange(5), names=np.array([None]))
    with pytest.raises(ValueError, match=r"2 streams of events \(left, right\)"):
        asap.read(path)
    assert_equal_events(asap.load(path, stream="left", order="txyp"), EVENTS)
    assert_equal_events(asap.load(path, stream="right", order="txyp"), EVENTS[:9])
    np.savez(path, data=matrix, labels=np.arange(5))
    assert_equal_events(asap.load(path, order="txyp"), EVENTS)


def test_streams_have_the_names_of_the_file() -> None:
    path = reported("stereo.aedat4")
    assert asap.read(path, stream="Right").streams == ("Left", "Right")
    assert_equal_events(asap.load(path, stream="4"), asap.load(path, stream="Right"))


@pytest.mark.parametrize("place", ["events", "/"])
@pytest.mark.parametrize("offset", [7_000, 7_000.0, [7_000]], ids=str)
@pytest.mark.parametrize("is_attribute", [False, True])
def test_the_offset_of_the_times_is_added_wherever_it_stands(
    place: str, offset: Any, is_attribute: bool, tmp_path: Path
) -> None:
    path = write(tmp_path / "events.h5", {role: EVENTS[role] for role in "txyp"})
    with pytest.importorskip("h5py").File(path, "a") as file:
        (file[place].attrs if is_attribute else file[place])["t_offset"] = offset
    expected = EVENTS.copy()
    expected["t"] += 7_000
    assert_equal_events(asap.load(path), expected)


# ---- siblings of the rows ------------------------------------------------------------------------


def write(path: Path, columns: dict[str, Any]) -> Path:
    """Write columns in the format that the suffix names."""
    if path.suffix == ".npz":
        np.savez(path, **columns)
    elif path.suffix == ".npy":
        np.save(path, np.rec.fromarrays(list(columns.values()), names=list(columns)))
    elif path.suffix == ".h5":
        with pytest.importorskip("h5py").File(path, "w") as file:
            for name, column in columns.items():
                file[f"events/{name}"] = column
    elif path.suffix == ".mat":
        pytest.importorskip("scipy.io").savemat(path, columns)
    else:
        separator = "," if path.suffix == ".csv" else " "
        np.savetxt(path, np.column_stack(list(columns.values())), fmt="%d", delimiter=separator)
    return path


CONTAINERS = (".npz", ".npy", ".h5", ".mat", ".txt")


@pytest.mark.parametrize("suffix", CONTAINERS)
@pytest.mark.parametrize(("off_on", "dtype"), [((-1, 1), "i1"), ((-1, 1), "i8"), ((0, 1), "u1")])
@pytest.mark.parametrize("rare", [None, 0, 1])
def test_plain_polarity_is_taken(
    suffix: str, dtype: str, off_on: tuple[int, int], rare: int | None, tmp_path: Path
) -> None:
    expected = EVENTS.copy()
    if rare is not None:
        expected["p"] = np.where(np.arange(len(EVENTS)) % 20, 1 - rare, rare)
    p = np.where(expected["p"], off_on[1], off_on[0]).astype(dtype)
    columns = {role: EVENTS[role] for role in "txy"} | {"p": p}
    assert_equal_events(asap.load(write(tmp_path / f"events{suffix}", columns)), expected)


@pytest.mark.parametrize("suffix", CONTAINERS)
@pytest.mark.parametrize(
    "off_on", [(0, 255), (0, 2), (3, 7), (-1, 0), (2, 2), (1, 2), (255, 1)], ids=str
)
def test_other_polarity_is_asked(suffix: str, off_on: tuple[int, int], tmp_path: Path) -> None:
    p = np.where(EVENTS["p"], off_on[1], off_on[0]).astype(np.int32)
    columns = {role: EVENTS[role] for role in "txy"} | {"p": p}
    with pytest.raises(ValueError, match="does not say which number is ON"):
        asap.load(write(tmp_path / f"events{suffix}", columns))


def test_polarity_of_three_numbers_is_asked(tmp_path: Path) -> None:
    p = np.arange(len(EVENTS)) % 3 - 1
    columns = {role: EVENTS[role] for role in "txy"} | {"p": p}
    with pytest.raises(ValueError, match=r"p = -1, 0, 1: .* does not say which number is ON"):
        asap.load(write(tmp_path / "events.npz", columns))


@pytest.mark.parametrize("off_on", [(255, 1), (1, 2)], ids=str)
def test_polarity_that_shows_late_is_asked(off_on: tuple[int, int], tmp_path: Path) -> None:
    events = clean_events(70_000)
    on = np.full(len(events), off_on[1] == 1)  # until the last events
    on[-4_000:] = np.arange(4_000) % 2
    p = np.where(on, off_on[1], off_on[0])
    path = write(tmp_path / "events.npz", {role: events[role] for role in "txy"} | {"p": p})
    with pytest.raises(ValueError, match="does not say which number is ON"):
        asap.load(path)


def test_a_few_damaged_polarities_do_not_change_the_others(tmp_path: Path) -> None:
    p = EVENTS["p"].astype(np.uint8)
    p[::50] = 77
    columns = {role: EVENTS[role] for role in "txy"} | {"p": p}
    opened = asap.read(write(tmp_path / "events.npz", columns))
    assert np.array_equal(np.concatenate(list(opened))["p"], p > 0)
    assert opened.repaired["normalised_polarity"] == 20


@pytest.mark.parametrize("seed", range(5))
def test_sorting_within_a_tolerance_puts_every_event_in_its_place(
    seed: int, tmp_path: Path
) -> None:
    late = np.random.default_rng(seed).integers(0, 300, len(EVENTS))
    shuffled = EVENTS[np.argsort(EVENTS["t"] + late, kind="stable")]
    np.save(tmp_path / "events.npy", shuffled)
    opened = asap.read(tmp_path / "events.npy", reorder_tolerance_us=300)
    found = np.concatenate(list(opened))
    assert np.array_equal(found["t"], EVENTS["t"])
    assert set(found.tolist()) == set(EVENTS.tolist())
    assert opened.repaired["sorted_stamps"] > 0 and not sum(opened.rejected.values())


@pytest.mark.parametrize("suffix", [".npy", ".csv", ".raw", ".dat", ".h5", ".aedat4"])
def test_a_window_of_time_is_that_of_the_whole(suffix: str, tmp_path: Path) -> None:
    if suffix in LIBRARIES:
        pytest.importorskip(LIBRARIES[suffix])
    events = clean_events(300_000)
    path = tmp_path / f"events{suffix}"
    if suffix == ".h5":
        write(path, {role: events[role] for role in "txyp"})
    else:
        written(path, events, width=1000, height=1000)
    span_s = (events["t"][-1] - events["t"][0]) / 1e6
    elapsed_s = (events["t"] - events["t"][0]) / 1e6
    for start, stop in ((0.4, 0.6), (0.0, 0.01), (0.99, None), (None, 0.3), (0.5, 0.5001)):
        low, high = (None if side is None else round(side * span_s, 6) for side in (start, stop))
        inside = (elapsed_s >= (low or 0.0)) & (elapsed_s < (high or np.inf))
        assert_equal_events(asap.load(path, start=low, stop=high), events[inside])


@pytest.mark.parametrize("suffix", [".npy", ".csv", ".raw", ".h5"])
def test_a_window_of_a_clock_that_was_set_back_is_that_of_the_whole(
    suffix: str, tmp_path: Path
) -> None:
    first = clean_events(300_000)
    second = first.copy()
    first["t"] += 5_000_000
    path = tmp_path / f"events{suffix}"
    if suffix == ".raw":
        written(path, first)
        with path.open("ab") as file:
            file.write(raw_files.evt2_words(second).tobytes())
    else:
        events = np.concatenate([first, second])
        write(path, {role: events[role] for role in "txyp"})
    whole = asap.load(path)
    assert len(whole) == 600_000
    elapsed_us = whole["t"] - whole["t"][0]
    for begin_us, end_us in elapsed_us[[[9, 99_999], [320_000, 400_000], [550_000, -1]]].tolist():
        inside = (elapsed_us >= begin_us) & (elapsed_us < end_us)
        window = {"start": begin_us / 1e6, "stop": end_us / 1e6}
        assert_equal_events(asap.load(path, **window), whole[inside])


@pytest.mark.parametrize("suffix", [".npy", ".npz", ".csv", ".raw", ".dat", ".h5", ".aedat4"])
@pytest.mark.parametrize("options", [{}, {"start": 0.2, "stop": 0.7}, {"reorder_tolerance_us": 9}])
def test_loading_gives_what_iterating_gives(
    suffix: str, options: dict[str, Any], tmp_path: Path
) -> None:
    if suffix in LIBRARIES:
        pytest.importorskip(LIBRARIES[suffix])
    events = clean_events(200_000)
    events["x"][::999] = 900  # dropped from every chunk
    path = tmp_path / f"events{suffix}"
    stated = {"width": 1000, "height": 1000} if suffix in (".aedat4", ".raw", ".dat") else {}
    written(path, events, **stated)
    size = {} if stated else {"width": 800, "height": 600}
    opened = asap.read(path, **options, **size)
    expected = np.concatenate([chunk.copy() for chunk in opened])
    assert_equal_events(asap.load(path, **options, **size), expected)
    assert_equal_events(np.concatenate(list(opened)), expected)


def test_the_index_of_dsec_is_as_its_loader_reads_it(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    events = clean_events(200_000)
    events["t"][100_000:] += 5_000  # a pause
    asap.convert(np.array_split(events, 7), tmp_path / "events.h5")
    with h5py.File(tmp_path / "events.h5") as file:
        t, first = file["events/t"][()].astype(np.int64), file["ms_to_idx"][()]
        assert file["t_offset"][()] == events["t"][0]
        kinds = [file["events"][role].dtype.str for role in "xypt"]
        assert kinds == ["<u2", "<u2", "|u1", "<u4"] and first.dtype == np.uint64
        filters = {file["events"][role].compression for role in "xypt"}
    assert filters == {"gzip"}
    assert first.tolist() == np.searchsorted(t, 1000 * np.arange(len(first))).tolist()
    assert 1000 * (len(first) - 1) > t[-1]


def test_every_verb_takes_several_files_and_a_window(tmp_path: Path) -> None:
    cost = asap.LinearCost(10, 10)
    parts = [tmp_path / "part_0.npy", tmp_path / "part_1.npy"]
    for part, events in zip(parts, np.array_split(EVENTS, 2), strict=True):
        np.save(part, events)
    elapsed_us = EVENTS["t"] - EVENTS["t"][0]
    inside = EVENTS[(elapsed_us >= 1_000) & (elapsed_us < 3_000)]
    window = {"start": 0.001, "stop": 0.003}
    for source in (parts, tmp_path):
        assert_equal_events(asap.load(source, **window), inside)
        run = asap.simulate(source, cost=cost, width=346, height=260, **window)
        assert run.ledger.received == len(inside)
        comparison = asap.compare(source, cost=cost, width=346, height=260, **window)
        assert comparison.summary()["source"]["events"] == len(inside)
        assert asap.info(source)["events"] == asap.check(source).events == len(EVENTS)
        run = asap.run(source, algorithm=len, speed=100, **window)
        assert run.ledger.received == len(inside)
    assert asap.convert(parts, tmp_path / "out.csv", **window) == len(inside)
    with pytest.raises(ValueError, match="start = 1: give a path"):
        asap.simulate(EVENTS, cost=cost, start=1)


def test_a_sensor_is_read_wherever_it_stands(tmp_path: Path) -> None:
    columns = {role: EVENTS[role] for role in "txyp"}
    for name, size in (
        ("a.npz", {"width": 346, "height": np.array([260])}),
        ("b.npz", {"resolution": [260, 346]}),
        ("c.h5", {"width": 346, "height": 260}),
        ("d.mat", {"width": 346, "height": 260}),
        ("e.npz", {"image_width": 346, "image_height": 260}),
        ("f.npz", {"Width": "346", "Height": "260"}),
        ("g.npz", {"img_size": "(346, 260)"}),
    ):
        path = write(tmp_path / name, columns | size)
        opened = asap.read(path)
        assert (opened.width, opened.height) == (346, 260)
        assert_equal_events(np.concatenate(list(opened)), EVENTS)
    lines = "".join(f"{t},{x},{y},{p}\n" for x, y, p, t in EVENTS.tolist())
    for comment in (
        *("# geometry: 346x260", "# width: 346, height: 260", "% resolution 346 260"),
        *("# height=260 width=346", "# 346 x 260", "# sensor: 346 x 260", "346,260"),
    ):
        path = tmp_path / "e.csv"
        path.write_text(f"{comment}\nt,x,y,p\n{lines}")
        assert (asap.read(path).width, asap.read(path).height) == (346, 260)


@pytest.mark.parametrize("p", [(1, 2), (0.3, 0.7)], ids=str)
@pytest.mark.parametrize("dtype", [asap.EVENT_DTYPE, None], ids=["ours", "columns"])
def test_a_polarity_that_would_be_all_on_is_asked(
    p: tuple[float, float], dtype: np.dtype[Any] | None, tmp_path: Path
) -> None:
    values = np.where(EVENTS["p"], p[1], p[0])
    source: Any = {role: EVENTS[role] for role in "txy"} | {"p": values}
    if dtype is not None:
        if p[1] < 1:
            pytest.skip("our type holds whole numbers")
        source = EVENTS.copy()
        source["p"] = values
        np.save(tmp_path / "events.npy", source)
        with pytest.raises(ValueError, match="does not say which number is ON"):
            asap.load(tmp_path / "events.npy")
    with pytest.raises(ValueError, match="both above 0, which is ON"):
        asap.as_events(source)


@pytest.mark.parametrize("suffix", CONTAINERS)
def test_whole_stamps_that_may_be_ns_are_asked(suffix: str, tmp_path: Path) -> None:
    columns = {role: EVENTS[role] * (1000 if role == "t" else 1) for role in "txyp"}
    path = write(tmp_path / f"events{suffix}", columns)
    for source in (path, columns):
        way = asap.load if source is path else asap.as_events
        with pytest.raises(ValueError, match=r"time_unit = None: .* multiples of 1000"):
            way(source)
        assert_equal_events(way(source, time_unit="ns"), EVENTS)
