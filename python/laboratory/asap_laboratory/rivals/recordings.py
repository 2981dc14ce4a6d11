"""Recordings with boxes: where they lie, and what a tracker said about one and was worth."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from asap_laboratory.accuracy import Rung
from asap_laboratory.page import Cell, Row, Rows, figure, fixed
from asap_laboratory.rivals.trackers import RIVALS, costs_ns
from asap_laboratory.scenes import LabelledScene, labelled
from asap_laboratory.scoring.boxes import BoxMatch, box_matches, box_score, frames
from asap_laboratory.scoring.trace import snapshots_at

_FILES = ("events.npz", "truth.csv", "ignore.csv", "sensor.json")
_NOWHERE = (
    "no labelled recording here: give their folders, or set ASAP_TEST_DATA to the folder whose "
    "sub-folder labelled holds them"
)


class Opened(NamedTuple):
    """Recordings, and why others were left out."""

    scenes: dict[Path, LabelledScene]
    left_out: list[str]


def opened(folders: Sequence[Path] = ()) -> Opened:
    """Open labelled recordings.

    `folders`: each a labelled recording, or a folder of such; by default ``labelled`` in the folder
    that ASAP_TEST_DATA names, or in ``../shared/data``. A recording that is found in a folder of
    such and refused is left out, with the reason; one that was given and is refused, or none at
    all, is a ValueError or an OSError.
    """
    scenes: dict[Path, LabelledScene] = {}
    left_out: list[str] = []
    for folder in folders or _usual():
        inside = [] if _holds_any(folder, _FILES) else _sets_inside(folder)
        if not inside:
            scenes[folder] = labelled(folder)
        for path in inside:
            try:
                scenes[path] = labelled(path)
            except (ValueError, OSError) as error:
                left_out.append(str(error).replace(f"{folder}{os.sep}", ""))
    if not scenes:
        raise ValueError("; ".join(left_out))
    return Opened(scenes, left_out)


def at_hand() -> list[Path]:
    """Return the recordings where `opened` looks by default; none where there are none."""
    try:
        return list(opened().scenes)
    except ValueError:
        return []


def data_folder() -> Path:
    """Return the folder that ASAP_TEST_DATA names, or where a checkout has it beside it."""
    return Path(os.environ.get("ASAP_TEST_DATA") or Path.cwd().parent / "shared" / "data")


def _usual() -> list[Path]:
    folder = data_folder() / "labelled"
    if not _sets_inside(folder):
        raise ValueError(_NOWHERE)
    return [folder]


def _sets_inside(folder: Path) -> list[Path]:
    if not folder.is_dir():
        return []
    return sorted(path for path in folder.iterdir() if _holds_any(path, ("truth.csv",)))


def _holds_any(folder: Path, names: Sequence[str]) -> bool:
    return any((folder / name).is_file() for name in names)


@dataclass(frozen=True)
class Followed:
    """A tracker on a recording with boxes.

    `figures`: those of `score` and ns_per_event; `matches`: at each labelled time.
    """

    scene: LabelledScene
    figures: dict[str, float]
    matches: list[BoxMatch]

    @property
    def times_s(self) -> NDArray[np.float64]:
        """The labelled times, s from the first event."""
        stamps = np.array([one.frame["t_us"][0] for one in self.matches], np.int64)
        return np.asarray((stamps - self.scene.events["t"][0]) * 1e-6)


def follow(rungs: dict[str, Rung], recording: str) -> dict[str, Followed]:
    """Let trackers follow a recording; score them, and time them in turns."""
    scene = labelled(recording)
    costs = costs_ns(rungs, scene)
    return {label: followed(rung, scene, costs[label]) for label, rung in rungs.items()}


def followed(rung: Rung, scene: LabelledScene, ns_per_event: float = math.nan) -> Followed:
    """Let a tracker follow a recording, and score it."""
    tracker, before = rung.made_for(scene)
    times = [int(frame["t_us"][0]) for frame in frames(scene.boxes)]
    snapshots, _ = snapshots_at(tracker, scene, times, before=before)
    matches = box_matches(scene, snapshots)
    figures = {**box_score(scene, matches)._asdict(), "ns_per_event": ns_per_event}
    return Followed(scene, figures, matches)


@dataclass(frozen=True)
class RecordingCase:
    """All trackers on one recording with boxes."""

    folder: str
    labels: tuple[str, ...] = tuple(RIVALS)

    def weight(self) -> float:
        """Seconds, about, by the million."""
        return 6e6

    def measure(self) -> Rows:
        """Run it."""
        return self.rows(follow({label: RIVALS[label] for label in self.labels}, self.folder))

    def rows(self, found: dict[str, Followed]) -> Rows:
        """Return the figures of every tracker."""
        return [
            {"kind": "recording", "set": one.scene.name, "tracker": label, **one.figures}
            for label, one in found.items()
        ]


def _judged(name: str) -> Cell:
    """Write what is judged only where everything that moves has a box."""

    def cell(row: Row) -> str:
        return "not judged" if row["mota"] is None else fixed(row[name])

    return cell


HEAD = {
    "set": "set",
    "hit": "hit",
    "box_precision": "precision",
    "switches": "switches",
    "longest": "longest",
    "error": "error px",
    "iou": "IoU",
    "box_mota": "MOTA",
    "ns_per_event": "ns per event",
}
CELLS = {
    "hit": figure("hit"),
    "box_precision": _judged("precision"),
    "box_mota": _judged("mota"),
    "longest": figure("longest"),
    "error": lambda row: "-" if row["error"] is None else f"{row['error']:.1f}",
    "iou": lambda row: "-" if row["iou"] is None else fixed(row["iou"]),
    "ns_per_event": figure("ns_per_event", lambda value: f"{value:.0f}"),
}
"""Heading and cells of a recording's row."""
