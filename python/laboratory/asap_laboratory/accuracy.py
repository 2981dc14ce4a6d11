"""The accuracy study: every algorithm with a score over scenes and the kept fraction gamma.

"quick" takes two scenes and two gammas, "default" the scenes A to E with three seeds, "full" adds F
and G and takes ten seeds.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from asap import _core
from asap_laboratory.page import Rows, Tables, Writer, distinct, figure, only, over_seeds
from asap_laboratory.scoring import Scene
from asap_laboratory.scoring.columns import CELLS, CORNERS, TRACKER
from asap_laboratory.scoring.curve import GAMMAS, scores_of
from asap_laboratory.study import Batch, Study

Maker = Callable[[int, int], Any]


class HasSize(Protocol):
    """A scene or a recording."""

    @property
    def width(self) -> int: ...  # noqa: D102
    @property
    def height(self) -> int: ...  # noqa: D102


class Rung(NamedTuple):
    """An algorithm that is scored, and the filter in front of it."""

    make: Maker
    before: Maker | None = None
    corners: bool = False

    def made_for(self, scene: HasSize) -> tuple[Any, Any | None]:
        """Make the algorithm and the filter anew."""
        before = self.before(scene.width, scene.height) if self.before else None
        return self.make(scene.width, scene.height), before


# The constructor's defaults are the published launch file; "steady" is the preset for rigid scenes.
_STEADY = partial(
    _core.PublishedClusterTracker, window=2000, radius=20.0, probes=0, weight=0.05, min_size=15
)

RUNGS = {
    "ClusterTracker": Rung(_core.ClusterTracker),
    "BAF + ClusterTracker": Rung(_core.ClusterTracker, _core.BackgroundActivityFilter),
    "published": Rung(_core.PublishedClusterTracker),
    "published, steady": Rung(_STEADY),
    "BAF + published, steady": Rung(_STEADY, _core.BackgroundActivityFilter),
    "EFast": Rung(_core.EFast, corners=True),
    "ArcStar": Rung(_core.ArcStar, corners=True),
    "EHarris": Rung(_core.EHarris, corners=True),
    "FAHarris": Rung(_core.FAHarris, corners=True),
}
"""Every algorithm with a score, by the label of the tables."""

_EVENTS = {"A": 442_961, "B": 908_251, "C": 370_249, "D": 1_050_519, "E": 370_206}
_USUAL_EVENTS = 500_000


@dataclass(frozen=True)
class AccuracyCase:
    """One algorithm on one scene with one seed."""

    rung: str
    scene: str
    seed: int = 0
    gammas: tuple[float, ...] = GAMMAS

    def weight(self) -> float:
        """Events to be processed, about."""
        thinned = sum(2 * gamma if gamma < 1 else 1 for gamma in self.gammas)
        return _EVENTS.get(self.scene, _USUAL_EVENTS) * thinned

    def measure(self) -> Rows:
        """Run it."""
        rung = RUNGS[self.rung]
        scored = scores_of(
            rung.make,
            scene_of(self.scene, self.seed),
            gammas=self.gammas,
            seed=self.seed,
            before=rung.before,
        )
        return [{"algorithm": self.rung, "scene": self.scene, **row} for row in scored]


class _Form(NamedTuple):
    scenes: tuple[str, ...]
    corner_scenes: tuple[str, ...]
    seeds: tuple[int, ...]
    gammas: tuple[float, ...]


_CORNERS = ("corners_slow", "corners_noisy")
_FORMS = {
    "quick": _Form(("A", "E"), _CORNERS[:1], (0,), (1.0, 0.2)),
    "default": _Form(tuple("ABCDE"), _CORNERS, (0, 1, 2), GAMMAS),
    "full": _Form(tuple("ABCDEFG"), _CORNERS, tuple(range(10)), GAMMAS),
}


def _batches(form: str) -> Generator[Batch, Rows, None]:
    chosen = _FORMS[form]
    yield Batch(
        [
            AccuracyCase(label, scene, seed, chosen.gammas)
            for seed in chosen.seeds
            for label, rung in RUNGS.items()
            for scene in (chosen.corner_scenes if rung.corners else chosen.scenes)
        ]
    )


def scene_of(name: str, seed: int) -> Scene:
    """Make one of the `scenes` by its name, such as "A", "H_bars" or "corners_slow"."""
    scenes: Any = importlib.import_module("asap_laboratory.scenes")
    make, _, kind = name.partition("_")
    scene: Scene = getattr(scenes, make)(seed=seed, **({"kind": kind} if kind else {}))
    return scene


_COST = "ns_per_event_p50"


def _summary(rows: Rows) -> Tables:
    keys = ("algorithm", "gamma", "told", "scene")
    return {"accuracy": over_seeds(rows, keys, (*TRACKER, *CORNERS, _COST))}


def _figures(tables: Tables) -> Mapping[str, Any]:
    from asap_laboratory.scoring.figure import figure as draw

    drawn = {}
    for scene in distinct(tables["accuracy"], "scene"):
        rows = only(tables["accuracy"], scene=scene)
        curves = {one: only(rows, algorithm=one) for one in distinct(rows, "algorithm")}
        drawn[f"accuracy_{scene}"] = draw(curves, title=f"scene {scene}")
    return drawn


def _parts(tables: Tables) -> dict[str, Any]:
    """Return the rows of trackers and of corner detectors, each with the columns they have."""
    rows = tables["accuracy"]
    detectors = tuple(label for label, rung in RUNGS.items() if rung.corners)
    trackers = tuple(label for label in RUNGS if label not in detectors)
    parts = [(only(rows, algorithm=trackers), TRACKER), (only(rows, algorithm=detectors), CORNERS)]
    return {"parts": [part for part in parts if part[0]], "seeds": rows[0]["seeds"]}


_DOWN = {"algorithm": "", "gamma": "gamma", "told": ""}


def _shown(tables: Tables, writer: Writer) -> str:
    return "\n\n".join(
        f"{columns[name][0]}\n\n{writer.pivot(rows, _DOWN, 'scene', name)}"
        for rows, columns in _parts(tables)["parts"]
        for name in ("mota", "f_measure")
        if name in columns
    )


ACCURACY = Study(
    name="accuracy",
    command="asap-study --accuracy",
    template=Path(__file__).with_suffix(".md"),
    batches=_batches,
    summary=_summary,
    tables=("accuracy",),
    cells={**CELLS, _COST: figure(_COST, lambda value: f"{value:.0f}")},
    figures=_figures,
    facts=_parts,
    shown=_shown,
)
