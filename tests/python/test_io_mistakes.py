"""Mistakes of users: the wrong columns, the wrong sensor, the wrong unit of time."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

import asap
import corrupt
from aedat4_files import write_aedat4
from asap import cli
from asap.events import Events
from asap.io import CorruptFile, NoGoodEvent

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


# ---- most events are bad --------------------------------------------------------------------


def test_most_events_are_bad(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", EVENTS)
    good = int((EVENTS["x"] < 3).sum())
    assert 0 < good < len(EVENTS) / 2
    rec = asap.read(tmp_path / "a.npy", width=3)
    assert rec._doubt is None
    assert sum(map(len, rec)) == good
    words = f"only {good} of its 3,000 events are good ({3000 - good:,} out_of_bounds); check "
    assert words in str(rec._doubt)
    rec = asap.read(tmp_path / "a.npy", width=corrupt.WIDTH - 20)
    assert len(EVENTS) / 2 < sum(map(len, rec)) < len(EVENTS)
    assert rec._doubt is None


# ---- the wrong path -------------------------------------------------------------------------


def test_no_path_is_not_the_current_folder() -> None:
    for call in (asap.load, asap.info, asap.check):
        with pytest.raises(ValueError, match="path = ''"):
            call("")
    assert cli.main(["info", ""]) == 2


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
