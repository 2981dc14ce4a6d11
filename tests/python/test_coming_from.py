"""The page for users of other libraries: each row beside the real library, which may be missing."""

from __future__ import annotations

import importlib
import re
from datetime import timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
from asap.events import Events
from event_files import assert_equal_events
from house import ROOT

PAGE = (ROOT / "notebooks" / "coming_from.md").read_text()
LIBRARIES = {"dv-processing": "dv_processing", "tonic": "tonic", "EventCV": "eventcv"}
LIBRARIES |= {"faery": "faery"}
# Only shown to work.
OTHER_RESULT = ("Noise", "Denoise", "ToVoxelGrid", "ToFrame", "ToTimesurface", "DropEvent", "efast")
OTHER_RESULT += ("background_activity_filter",)


def rows() -> list[tuple[str, str, str]]:
    """Read library, their call and ours from the tables of the page."""
    found, title = [], ""
    for line in PAGE.splitlines():
        title = line.removeprefix("## ") if line.startswith("## ") else title
        if title in LIBRARIES and (cells := re.findall(r"^\| `(.*?)` \| (.*?) \|", line)):
            found.append((title, *cells[0]))
    return found


def pieces(result: Any) -> list[Events]:
    """Bring what either call returns to a list of events: one array, or one for each slice."""
    is_stream = "Regular" in type(result).__name__ or hasattr(result, "dt_ms")
    if is_stream or hasattr(result, "__next__") or isinstance(result, list):
        return [asap.as_events(getattr(one, "events", one)) for one in result]
    return [asap.as_events(result)]


@pytest.fixture
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Events:
    """Files of one stream in the current folder, and its events."""
    pytest.importorskip("lz4", reason="events.aedat4 is packed by it")
    monkeypatch.chdir(tmp_path)
    scene = asap.synthetic.FlightOverChairs(duration_s=0.1)
    events = scene.events()
    for suffix in ("es", "raw", "aedat4"):
        asap.convert(events, f"events.{suffix}", width=scene.width, height=scene.height)
    return events


def test_every_library_of_the_page_has_rows() -> None:
    assert {library for library, *_ in rows()} == set(LIBRARIES)


@pytest.mark.parametrize(("library", "theirs", "ours"), rows())
def test_a_row_gives_the_same_events(library: str, theirs: str, ours: str, files: Events) -> None:
    names: dict[str, Any] = {"asap": asap, "events": files, "timedelta": timedelta}
    module = pytest.importorskip(LIBRARIES[library])
    names["dv" if library == "dv-processing" else LIBRARIES[library]] = module
    if library == "tonic":
        importlib.import_module("tonic.slicers")
    found: list[Any] = []
    if library == "EventCV":
        names["stream"] = module.load("events.raw")
    if library == "dv-processing":
        store, recording = module.EventStore(), module.io.MonoCameraRecording("events.aedat4")
        while (batch := recording.getNextEventBatch()) is not None:
            store.add(batch)
        names |= {"store": store, "slicer": module.EventStreamSlicer(), "t0": int(files["t"][0])}
        names["f"] = lambda slice_: found.append(slice_.numpy().copy())
    result = eval(theirs, names)
    if theirs.startswith("slicer."):
        names["slicer"].accept(names["store"])
        result = found
    if any(word in theirs for word in OTHER_RESULT):
        assert ours == "the recipe below" or eval(ours.strip("`"), names) is not None
        return
    want, got = pieces(result), pieces(eval(ours.strip("`"), names))
    assert len(got) - len(want) in (0, 1), "theirs may lack the last slice"
    assert sum(map(len, got)) > 0.05 * len(files)
    for one, other in zip(want, got, strict=False):
        assert_equal_events(other, one)


@pytest.mark.parametrize("bins", [2, 5])
def test_the_voxel_grid_of_the_recipe_is_that_of_tonic(bins: int, files: Events) -> None:
    tonic = pytest.importorskip("tonic")
    (recipe,) = re.findall(r"^def voxel_grid.*?^    return grid\n", PAGE, re.M | re.S)
    names: dict[str, Any] = {"np": np}
    exec(recipe, names)
    first_us, last_us = int(files["t"][0]), int(files["t"][-1])
    ours = names["voxel_grid"](files, first_us, last_us, bins + 1, 346, 260)[:bins]
    theirs = tonic.transforms.ToVoxelGrid(sensor_size=(346, 260, 2), n_time_bins=bins)(files)
    np.testing.assert_allclose(ours, theirs[:, 0], atol=1e-3)
