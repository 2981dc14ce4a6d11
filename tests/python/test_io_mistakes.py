"""Mistakes of users: the wrong columns, the wrong sensor, the wrong unit of time."""

from __future__ import annotations

import warnings
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import asap
import corrupt
from aedat4_files import write_aedat4
from asap import cli
from asap.events import Events
from asap.io import CorruptFile, NoGoodEvent, UnsupportedFormat

SENSOR = {"width": corrupt.WIDTH, "height": corrupt.HEIGHT}
EVENTS = corrupt.clean_events(3000)


def write(path: Path, order: str, events: Events = EVENTS) -> Path:
    """Columns of text without a header, in any order."""
    rows = zip(*(events[role].tolist() for role in order), strict=True)
    path.write_text("".join(" ".join(map(str, row)) + "\n" for row in rows))
    return path


def matrix(order: str) -> np.ndarray:
    return np.stack([EVENTS[role] for role in order], axis=1)


# ---- the wrong columns ----------------------------------------------------------------------


@pytest.mark.parametrize("suffix", ["txt", "npy"])
def test_nothing_good_asks_for_what_was_said(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"events.{suffix}"
    if suffix == "npy":
        np.save(path, matrix("xytp"))
    else:
        write(path, "xytp")
    words = rf"^{path}: not one of its 3,000 events is good \(.*\); .*check order, time_unit, width"
    with pytest.raises(NoGoodEvent, match=words):
        asap.load(path, order="txyp", **SENSOR)
    assert len(asap.load(path, order="xytp", **SENSOR)) == len(EVENTS)


def test_nothing_good_is_exit_3(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write(tmp_path / "events.txt", "xytp")
    for verb in (["info"], ["run", "--algorithm", "baf"], ["run", "--cost", "1us+1ns"]):
        code = cli.main([*verb, str(path), "--width", "346", "--height", "260"])
        out, err = capsys.readouterr()
        assert (code, out) == (3, "")
        assert err.endswith("time_unit, width and height\n")


def test_a_sensor_that_holds_no_event(tmp_path: Path) -> None:
    events = EVENTS.copy()
    events["x"] += 50
    np.save(tmp_path / "events.npy", events)
    with pytest.raises(NoGoodEvent, match=r"\(3,000 out_of_bounds\); check .* width and height"):
        asap.load(tmp_path / "events.npy", width=50, height=9)


def test_a_file_of_no_events_at_all_is_no_mistake(tmp_path: Path) -> None:
    np.save(tmp_path / "events.npy", EVENTS[:0])
    assert len(asap.load(tmp_path / "events.npy", **SENSOR)) == 0


@pytest.mark.parametrize(("order", "such"), [("xypt", "xypt"), ("xyt", "txy")])
def test_columns_without_names_are_a_question(tmp_path: Path, order: str, such: str) -> None:
    path = write(tmp_path / "events.txt", order)
    with pytest.raises(ValueError, match=rf"order = None: .*, such as order='{such}'$"):
        asap.read(path)


# ---- the wrong sensor -----------------------------------------------------------------------


@pytest.fixture
def states_its_sensor(tmp_path: Path) -> Path:
    path = tmp_path / "events.npz"
    np.savez(path, events=EVENTS, **SENSOR)
    return path


@pytest.mark.parametrize("side", SENSOR)
def test_a_side_against_that_of_the_file(states_its_sensor: Path, side: str) -> None:
    path, stated = states_its_sensor, SENSOR[side]
    words = rf"^{side} = 640: .*events.npz states {stated}; leave {side} out$"
    cost = asap.LinearCost(1, 1)
    for call in (
        lambda: asap.read(path, **{side: 640}),
        lambda: asap.load(path, **{side: 640}),
        lambda: asap.simulate(path, cost=cost, **{side: 640}),
        lambda: asap.simulate(asap.read(path), cost=cost, **{side: 640}),
        lambda: asap.check(path, **{side: 640}),
        lambda: asap.check(asap.read(path), **{side: 640}),
    ):
        with pytest.raises(ValueError, match=words):
            call()


def test_the_same_side_twice_is_no_contradiction(states_its_sensor: Path) -> None:
    assert len(asap.load(states_its_sensor, **SENSOR)) == len(EVENTS)
    assert asap.read(states_its_sensor, width=0).width == corrupt.WIDTH


def test_a_side_against_that_of_the_file_is_wrong_use(
    states_its_sensor: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["info", str(states_its_sensor), "--width", "640"]) == 2
    assert "error: width = 640: " in capsys.readouterr().err


# ---- numbers that are written in another way ------------------------------------------------


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('"t","x","y","p"\n"5","1","2","1"\n', r"byte 16: numbers in quotes; write them without"),
        ("t;x;y;p\n0,5;1;2;1\n", r"byte 8: numbers with a decimal comma; .* with a point"),
        ("5 1.25 2.5 1\n6 1.25 3.5 0\n", r"the first bad one is at byte 0"),
    ],
)
def test_numbers_as_others_write_them(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "events.csv"
    path.write_text(text)
    with pytest.raises(ValueError, match=words):
        asap.load(path)


def test_quotes_around_names_are_read(tmp_path: Path) -> None:
    path = tmp_path / "events.csv"
    path.write_text('"t","x","y","p"\n5,1,2,1\n')
    assert len(asap.load(path)) == 1


@pytest.mark.parametrize(("size", "told"), [(500, True), (501, False)])
def test_40_bit_events_under_another_name(tmp_path: Path, size: int, told: bool) -> None:
    path = tmp_path / "events.events"
    path.write_bytes(bytes(range(250)) * 2 + b"\0" * (size - 500))
    with pytest.raises(UnsupportedFormat) as error:
        asap.load(path)
    assert str(error.value).endswith("give file_format='atis40'") == told


# ---- the wrong unit -------------------------------------------------------------------------


def in_seconds() -> Events:
    events = np.sort(EVENTS, order="t")
    events["t"] = np.arange(len(events)) // 1000  # 1000 events per second
    return events


@pytest.mark.parametrize("suffix", ["txt", "npy"])
def test_whole_seconds_are_told(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"events.{suffix}"
    if suffix == "npy":
        np.save(path, in_seconds())
    else:
        write(path, "txyp", in_seconds())
    words = rf"{suffix}: 3000 events within 2 us, .* if they are not in us, give time_unit$"
    with pytest.warns(UserWarning, match=words):
        asap.load(path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        asap.load(path, time_unit="us")
        asap.load(path, time_unit="s")


@pytest.mark.parametrize("verb", [["info"], ["run", "--algorithm", "baf"]])
def test_info_and_run_warn_of_seconds(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], verb: list[str]
) -> None:
    path = write(tmp_path / "events.txt", "txyp", in_seconds())
    assert cli.main([*verb, str(path), "--width", "346", "--height", "260"]) == 0
    err = capsys.readouterr().err
    assert f"warning: {path}: 3000 events within 2 us, which is short for a camera" in err
    assert err.endswith("if they are not in us, give time_unit\n")


@pytest.mark.parametrize(
    ("times", "unit", "other"),
    [
        ([str(t) for t in range(0, 2_000_000_000, 1_000_000)], "us", "ns"),
        ([f"{t}.5" for t in range(0, 200_000, 100)], "s", "us"),
        ([f"{t}.5" for t in range(2000)], "s", "ms"),
    ],
)
def test_long_steps_are_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], times: list[str], unit: str, other: str
) -> None:
    path = tmp_path / "events.txt"
    path.write_text("".join(f"{t} 1 2 1\n" for t in times))
    words = rf"the times step by .*, which is long for a camera; if they are not in {unit}, give "
    with pytest.warns(UserWarning, match=f"{words}time_unit"):
        asap.load(path)
    assert cli.main(["info", str(path)]) == 0
    assert "give time_unit\n" in capsys.readouterr().err
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        asap.load(path, time_unit=other)
        asap.load(path, time_unit=unit)


def test_a_unit_that_is_stated_is_not_doubted(tmp_path: Path) -> None:
    path = tmp_path / "events.csv"
    times = range(0, 2_000_000_000, 1_000_000)
    path.write_text("t_us,x,y,p\n" + "".join(f"{t},1,2,1\n" for t in times))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(asap.load(path)) == 2000


def test_nanoseconds_are_told(tmp_path: Path) -> None:
    path = tmp_path / "events.txt"
    path.write_text("1504645177000000000 1 2 1\n1504645177000001000 1 2 0\n")
    with pytest.raises(NoGoodEvent, match="check order, time_unit"):
        asap.load(path)
    assert len(asap.load(path, time_unit="ns")) == 2


def test_a_burst_is_no_second(tmp_path: Path) -> None:
    np.save(tmp_path / "events.npy", corrupt.one_stamp(EVENTS, 500, 600)[500:1100])
    np.save(tmp_path / "more.npy", EVENTS)
    assert len(asap.load(tmp_path / "events.npy")) == 600
    assert len(asap.load(tmp_path / "more.npy")) == len(EVENTS)


# ---- most events are bad --------------------------------------------------------------------


def test_most_events_are_bad(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", EVENTS)
    good = int((EVENTS["x"] < 3).sum())
    assert 0 < good < len(EVENTS) / 2
    rec = asap.read(tmp_path / "a.npy", width=3)
    assert rec.doubt is None
    assert sum(map(len, rec)) == good
    words = f"only {good} of its 3,000 events are good ({3000 - good:,} out_of_bounds); check "
    assert words in str(rec.doubt)
    rec = asap.read(tmp_path / "a.npy", width=corrupt.WIDTH - 20)
    assert len(EVENTS) / 2 < sum(map(len, rec)) < len(EVENTS)
    assert rec.doubt is None


@pytest.mark.parametrize(
    "verb", [["info"], ["run", "--cost", "1us+1ns"], ["convert", "--to", "csv"]], ids=lambda v: v[0]
)
def test_most_events_are_bad_for_the_command_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], verb: list[str]
) -> None:
    np.save(tmp_path / "a.npy", EVENTS)
    out = [str(tmp_path / "out")] if verb[0] == "convert" else []
    code = cli.main([*verb, str(tmp_path / "a.npy"), *out, "--width", "3", "--height", "999"])
    assert code == 0
    assert "asap: warning: " in (err := capsys.readouterr().err)
    assert "of its 3,000 events are good" in err


def test_the_first_bad_line_is_found(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("t,x,y,p\n1,2,3,yes\n2,3,4,no\n")
    with pytest.raises(NoGoodEvent, match="the first bad one is at byte 8"):
        asap.load(path)


@pytest.mark.parametrize("path", [{}, 5, b"a.npz"])
def test_info_of_something_else(path: object) -> None:
    with pytest.raises(TypeError, match=r"path = .*: give a path, or what read\(\) returned"):
        asap.info(path)


def test_the_command_line_names_the_format(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write(tmp_path / "a.bin", "txyp")
    assert cli.main(["info", str(path)]) == 3
    assert "file_format='text' reads it" in capsys.readouterr().err
    assert cli.main(["info", str(path), "--file-format", "text"]) == 0
    assert "format    text" in capsys.readouterr().out


# ---- what is no recording -------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.bin", b"\x7fELF\x02\x01", "a program, no recording of events"),
        ("a.bin", b"\x89PNG\r\n\x1a\n", "a PNG picture, no recording of events"),
        ("a.bs2", b"\xff\xd8\xff\xe0", "a JPEG picture, no recording of events"),
        ("a.txt", b"%PDF-1.7\n", "a PDF document, no recording of events"),
        ("a.csv.gz", b"\x1f\x8b\x08\x00", "packed by gzip; unpack it first"),
        ("a.raw", b"\x1f\x8b\x08\x00", "packed by gzip; unpack it first"),
        ("a.bin", b"BZh9", "packed by bzip2; unpack it first"),
    ],
)
def test_other_files_are_named(tmp_path: Path, name: str, content: bytes, words: str) -> None:
    path = tmp_path / name
    path.write_bytes(content + bytes(4000))
    with pytest.raises(UnsupportedFormat, match=f"^{path}: {words}$"):
        asap.read(path)
    assert cli.main(["info", str(path)]) == 3


def test_a_zip_archive_is_to_be_unpacked(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "a.zip", "w") as archive:
        archive.writestr("flight.raw", "% evt 3.0")
    with pytest.raises(UnsupportedFormat, match=r"a zip archive without arrays; unpack it first"):
        asap.read(tmp_path / "a.zip")


@pytest.mark.parametrize(
    "prose",
    [
        "# Recordings\n\nThese files hold events.\nThey are of one camera.\n",
        '{\n "files": 3,\n "sizes": [\n  120,\n  340\n ]\n}\n',
        "Read me\n",
    ],
)
def test_prose_is_no_question_about_columns(tmp_path: Path, prose: str) -> None:
    path = tmp_path / "a.md"
    path.write_text(prose)
    with pytest.raises(CorruptFile, match="byte 0: text without lines of numbers"):
        asap.read(path)
    assert cli.main(["info", str(path)]) == 3


def test_a_header_without_events_is_no_prose(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("t,x,y,p\n")
    assert len(asap.load(tmp_path / "a.csv")) == 0


# ---- the wrong path -------------------------------------------------------------------------


def test_a_folder_without_the_metadata_of_a_bag(tmp_path: Path) -> None:
    (tmp_path / "b_0.db3").touch()
    with pytest.raises(IsADirectoryError, match=r"without metadata.yaml, .*; give b_0.db3 in it"):
        asap.read(tmp_path)
    (tmp_path / "b_0.db3").unlink()
    with pytest.raises(IsADirectoryError, match="Is a directory; give a file in it"):
        asap.read(tmp_path)


def test_a_folder_that_cannot_be_listed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(path: Path) -> None:
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr("os.listdir", refuse)
    monkeypatch.setattr("os.scandir", refuse)
    with pytest.raises(PermissionError) as caught:
        asap.read(tmp_path)
    assert caught.value.filename == str(tmp_path)


def test_no_path_is_not_the_current_folder(capsys: pytest.CaptureFixture[str]) -> None:
    for call in (asap.load, asap.info, asap.check):
        with pytest.raises(ValueError, match="path = '': give a path"):
            call("")
    assert cli.main(["info", ""]) == 2
    with pytest.raises(TypeError, match=r"path = 5: give a path, as text or pathlib\.Path"):
        asap.load(5)  # type: ignore[arg-type]


# ---- options that the file does not need ----------------------------------------------------


@pytest.mark.parametrize("name", ["evt3", "es", "aedat4"])
@pytest.mark.parametrize("option", [{"order": "xytp"}, {"time_unit": "s"}])
def test_what_the_format_states_is_not_said_again(
    tmp_path: Path, name: str, option: dict[str, str]
) -> None:
    path = tmp_path / f"a.{name}"
    if name == "aedat4":
        write_aedat4(path, [(0, EVENTS)])
    else:
        asap.convert(EVENTS, path, to=name, **SENSOR)
    ((field, value),) = option.items()
    words = f"^{field} = '{value}': {path} is {name}, which states it; leave {field} out$"
    with pytest.raises(ValueError, match=words):
        asap.read(path, **option)  # type: ignore[arg-type]


def test_a_format_that_the_content_denies(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", events=EVENTS)
    for name in ("evt3", "atis40", "text", "hdf5"):
        with pytest.raises(CorruptFile, match=f"this is npz, not {name}; leave file_format out"):
            asap.read(tmp_path / "a.npz", file_format=name)
    assert len(asap.load(tmp_path / "a.npz", file_format="npz")) == len(EVENTS)


@pytest.mark.parametrize("side", SENSOR)
@pytest.mark.parametrize("verb", [asap.read, asap.check])
def test_a_side_that_no_sensor_has(tmp_path: Path, side: str, verb: Callable[..., object]) -> None:
    np.save(tmp_path / "a.npy", EVENTS)
    for value in (-1, 65537):
        words = rf"{side} = {value}: give the sensor's {side} in pixels, at most 65536, or 0 for"
        with pytest.raises(ValueError, match=words):
            verb(tmp_path / "a.npy", **{side: value})


def test_raw_without_an_encoding_asks_for_it(tmp_path: Path) -> None:
    path = tmp_path / "a.raw"
    asap.convert(EVENTS, path, to="evt2", **SENSOR)
    words = path.read_bytes().partition(b"% end\n")[2]
    remedy = r"; name the encoding, such as file_format='evt3' \(or evt2, evt21\)$"
    for header, lack in (
        (b"% date today\n% end\n", "its header has no line '% evt'"),
        (b"", "it has no header"),
    ):
        path.write_bytes(header + words)
        with pytest.raises(CorruptFile, match=f"{lack}.*{remedy}"):
            asap.read(path)
        assert len(asap.load(path, file_format="evt2")) == len(EVENTS)


def test_a_dat_file_that_ends_in_its_header_is_no_empty_text(tmp_path: Path) -> None:
    path = tmp_path / "a.dat"
    asap.convert(EVENTS, path, **SENSOR)
    whole = path.read_bytes()
    for length in range(1, whole.rindex(b"\n", 0, 100) + 1):
        path.write_bytes(whole[:length])
        with pytest.raises(CorruptFile, match=r"ends inside its header|no header of text lines"):
            asap.load(path)
