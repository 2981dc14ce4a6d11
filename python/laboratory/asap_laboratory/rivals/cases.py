"""RivalsCase: the cluster tracker and its rivals on one scene with one seed, scored and timed.

All of them in one task, so that their costs are of the same minutes on the same machine.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from asap import _core
from asap.accuracy import Scene
from asap.accuracy.matching import match
from asap.accuracy.mota import mota
from asap.accuracy.trace import follow
from asap_laboratory import _native
from asap_laboratory.accuracy.cases import RUNGS, Rung, scene_of
from asap_laboratory.rivals.cost import costs_ns

__all__ = ["OURS", "RIVALS", "Rivalry", "RivalsCase", "rivals_cases"]

OURS = "fast"


_BAF = _core.BackgroundActivityFilter
RIVALS = {
    OURS: RUNGS[OURS],
    "jAER-type core": Rung("jAER-type core", _native.JaerClusterTracker),
    "BAF + jAER-type core": Rung("jAER-type core", _native.JaerClusterTracker, _BAF),
    "BAF + compat steady": RUNGS["BAF + compat steady"],
}
"""Ours with nothing in front, and every rival, by the label of the tables."""

COLUMNS = ("mota", "id_switches", "position_rms", "velocity_rms", "ns_per_event")
_SECONDS = {"A": 9, "B": 11, "D": 12, "G": 15}
_USUAL_SECONDS = 6


@dataclass(frozen=True)
class Rivalry:
    """What a `RivalsCase` has found: the columns of the table, by label."""

    rivals: dict[str, dict[str, float]]


@dataclass(frozen=True)
class RivalsCase:
    """Everybody on one scene with one seed."""

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


_SEEDS = {"quick": (200, 201), "default": (200, 210), "full": (200, 220)}
_SEEDS_OF_FG = {"quick": (200, 200), "default": (200, 206), "full": (200, 212)}


def rivals_cases(form: str) -> Iterator[RivalsCase]:
    """Yield the cases of a form of the study: "quick", "default" or "full".

    Raises
    ------
    KeyError
        There is no such form.
    """
    for scenes, seeds in (("AE" if form == "quick" else "ABCDE", _SEEDS), ("FG", _SEEDS_OF_FG)):
        for scene in scenes:
            for seed in range(*seeds[form]):
                yield RivalsCase(scene, seed)


def _scored(rung: Rung, scene: Scene) -> dict[str, float]:
    """Of the figures of `asap.score`, those of the table: the others take twice as long."""
    tracker, before = rung.made_for(scene)
    return mota(match(follow(tracker, scene, before=before).samples))._asdict()
