"""AccuracyCase: an algorithm on a scene with one seed, scored at every gamma, told and not told.

"quick" takes two scenes and two gammas, "default" the scenes A to E with three seeds, "full" adds F
and G and takes ten seeds.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

from asap import _core
from asap_laboratory.scoring import Scene
from asap_laboratory.scoring.curve import GAMMAS, scores_of
from asap_laboratory.scoring.result import Scored

Maker = Callable[[int, int], Any]


class HasSize(Protocol):
    """A scene or a recording."""

    @property
    def width(self) -> int: ...  # noqa: D102
    @property
    def height(self) -> int: ...  # noqa: D102


class Rung(NamedTuple):
    """An algorithm that is scored, and the filter in front of it."""

    algorithm: str
    make: Maker
    before: Maker | None = None
    corners: bool = False

    def made_for(self, scene: HasSize) -> tuple[Any, Any | None]:
        """Make the algorithm and the filter anew."""
        before = self.before(scene.width, scene.height) if self.before else None
        return self.make(scene.width, scene.height), before


def _compat(**parameters: Any) -> Maker:
    return lambda width, height: _core.ClusterTracker(width, height, engine="compat", **parameters)


def _fast(width: int, height: int) -> Any:
    return _core.ClusterTracker(width, height, engine="fast")


# The constructor's defaults are the published launch file; "steady" is the preset for rigid scenes.
_STEADY = _compat(window=2000, radius=20.0, probes=0, weight=0.05, min_size=15)

RUNGS = {
    "fast": Rung("fast", _fast),
    "BAF + fast": Rung("fast", _fast, _core.BackgroundActivityFilter),
    "compat": Rung("compat", _compat()),
    "compat steady": Rung("compat steady", _STEADY),
    "BAF + compat steady": Rung("compat steady", _STEADY, _core.BackgroundActivityFilter),
    "EFast": Rung("EFast", _core.EFast, corners=True),
    "ArcStar": Rung("ArcStar", _core.ArcStar, corners=True),
    "EHarris": Rung("EHarris", _core.EHarris, corners=True),
    "FAHarris": Rung("FAHarris", _core.FAHarris, corners=True),
}
"""Every algorithm with a score, by the label of the tables."""

_EVENTS = {"A": 442_961, "B": 908_251, "C": 370_249, "D": 1_050_519, "E": 370_206}
_USUAL_EVENTS = 500_000


@dataclass(frozen=True)
class Accuracy:
    """What an `AccuracyCase` has found."""

    scored: list[Scored]

    @classmethod
    def restored(cls, fields: dict[str, Any]) -> Accuracy:
        """Make it again of what the state file holds."""
        return cls([Scored(**one) for one in fields["scored"]])


@dataclass(frozen=True)
class AccuracyCase:
    """One algorithm on one scene with one seed."""

    rung: str
    scene: str
    seed: int = 0
    gammas: tuple[float, ...] = GAMMAS

    @property
    def name(self) -> str:
        """How it is called on the screen."""
        return f"{self.rung} on {self.scene}"

    def weight(self) -> float:
        """Events to be processed, about."""
        thinned = sum(2 * gamma if gamma < 1 else 1 for gamma in self.gammas)
        return _EVENTS.get(self.scene, _USUAL_EVENTS) * thinned

    def measure(self) -> Accuracy:
        """Run it."""
        rung = RUNGS[self.rung]
        scored = scores_of(
            rung.make,
            scene_of(self.scene, self.seed),
            gammas=self.gammas,
            seed=self.seed,
            before=rung.before,
        )
        return Accuracy(scored)


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


def accuracy_cases(form: str) -> Iterator[AccuracyCase]:
    """Yield the cases of a form of the study: "quick", "default" or "full".

    Raises
    ------
    KeyError
        There is no such form.
    """
    chosen = _FORMS[form]
    missing = missing_rungs()
    for seed in chosen.seeds:
        for label, rung in RUNGS.items():
            if label not in missing:
                for scene in chosen.corner_scenes if rung.corners else chosen.scenes:
                    yield AccuracyCase(label, scene, seed, chosen.gammas)


def missing_rungs() -> list[str]:
    """Labels of algorithms that this build of the library cannot make."""
    return [label for label, rung in RUNGS.items() if not _exists(rung)]


def _exists(rung: Rung) -> bool:
    try:
        rung.make(64, 64)
    except ValueError:
        return False
    return True


def scene_of(name: str, seed: int) -> Scene:
    """Make one of the `scenes` by its name, such as "A", "H_bars" or "corners_slow"."""
    scenes: Any = importlib.import_module("asap_laboratory.scenes")
    make, _, kind = name.partition("_")
    scene: Scene = getattr(scenes, make)(seed=seed, **({"kind": kind} if kind else {}))
    return scene
