"""RivalsCase, RecordingCase: the cluster tracker and its rivals on one input, scored and timed.

All of them in one task, so that their costs are of the same minutes on the same machine.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from asap import _core
from asap_laboratory import _native
from asap_laboratory.accuracy.cases import RUNGS, Rung, scene_of
from asap_laboratory.real import following
from asap_laboratory.rivals.cost import costs_ns
from asap_laboratory.scenes import labelled
from asap_laboratory.scoring import Scene
from asap_laboratory.scoring.matching import match
from asap_laboratory.scoring.measures import mota
from asap_laboratory.scoring.trace import follow

OURS = "fast"


def _frames(period_us: int, neighbours: int) -> Rung:
    def make(width: int, height: int) -> Any:
        from asap_laboratory.rivals.frames import FrameTracker  # needs scipy

        return FrameTracker(width, height, period_us=period_us, neighbours=neighbours)

    return Rung(f"frames {period_us // 1000} ms", make)


_BAF = _core.BackgroundActivityFilter
RIVALS = {
    OURS: RUNGS[OURS],
    "frames 10 ms": _frames(10_000, neighbours=2),
    "frames 20 ms": _frames(20_000, neighbours=3),
    "compat": RUNGS["compat"],
    "BAF + compat steady": RUNGS["BAF + compat steady"],
    "jAER-type core": Rung("jAER-type core", _native.JaerClusterTracker),
    "BAF + jAER-type core": Rung("jAER-type core", _native.JaerClusterTracker, _BAF),
}
"""Ours with nothing in front, and every rival, by the label of the tables."""

COLUMNS = ("mota", "id_switches", "position_rms", "velocity_rms", "ns_per_event")
SCENES = (*"ABCDEFG", "H_bars", "H_angles", "H_rings", *"IJK")
_FIRST_SEED = 1000  # nothing was chosen on it and those after it
_SEEDS = {"quick": 1, "default": 20, "full": 40}
_SECONDS = {"A": 3, "C": 3, "E": 3, "G": 15}
_USUAL_SECONDS = 6


@dataclass(frozen=True)
class Rivalry:
    """What a case has found: the columns of its table, by label."""

    rivals: dict[str, dict[str, float]]


@dataclass(frozen=True)
class RivalsCase:
    """All trackers on one scene with one seed."""

    scene: str
    seed: int
    labels: tuple[str, ...] = tuple(RIVALS)

    @property
    def name(self) -> str:
        """How it is called on the screen."""
        return f"{len(self.labels)} trackers on {self.scene}"

    def weight(self) -> float:
        """Seconds, about, by the million."""
        return 1e6 * _SECONDS.get(self.scene, _USUAL_SECONDS)

    def measure(self) -> Rivalry:
        """Run it."""
        scene = scene_of(self.scene, self.seed)
        rungs = {label: RIVALS[label] for label in self.labels}
        figures = {label: _scored(rung, scene) for label, rung in rungs.items()}
        for label, ns in costs_ns(rungs, scene).items():
            figures[label]["ns_per_event"] = ns
        return Rivalry(
            {label: {name: one[name] for name in COLUMNS} for label, one in figures.items()}
        )


@dataclass(frozen=True)
class RecordingCase:
    """All trackers on one recording with boxes."""

    folder: str
    labels: tuple[str, ...] = tuple(RIVALS)

    @property
    def recording(self) -> str:
        """Its name."""
        return Path(self.folder).name

    @property
    def name(self) -> str:
        """How it is called on the screen."""
        return f"{len(self.labels)} trackers on {self.recording}"

    def weight(self) -> float:
        """Seconds, about, by the million."""
        return 1e6 * _USUAL_SECONDS

    def measure(self) -> Rivalry:
        """Run it."""
        rungs = {label: RIVALS[label] for label in self.labels}
        found = following.follow(rungs, labelled(self.folder))
        return Rivalry({label: one.figures for label, one in found.items()})


def rivals_cases(form: str) -> Iterator[RivalsCase]:
    """Yield the scenes of a form of the study: "quick", "default" or "full".

    Raises
    ------
    KeyError
        There is no such form.
    """
    for scene in "AE" if form == "quick" else SCENES:
        for seed in range(_FIRST_SEED, _FIRST_SEED + _SEEDS[form]):
            yield RivalsCase(scene, seed)


def _scored(rung: Rung, scene: Scene) -> dict[str, float]:
    """Return the figures of the table; all figures of `score` would take twice as long."""
    tracker, before = rung.made_for(scene)
    return mota(match(follow(tracker, scene, before=before).samples))._asdict()
