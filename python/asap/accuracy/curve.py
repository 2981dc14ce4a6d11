"""keep_curve: what discarding costs an algorithm: every score against the kept fraction gamma."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from asap import checks
from asap._result import Result
from asap.accuracy.scene import Scene, check_scene
from asap.accuracy.scoring import can_be_told, score

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["GAMMAS", "KeepCurve", "KeepRow", "Scored", "keep_curve", "scores_of"]

GAMMAS = (1.0, 0.5, 0.2, 0.1, 0.05)
SCHEMA_VERSION = 1


@dataclass(frozen=True)
class Scored:
    """One score of one seed; told is None at gamma = 1, where there is nothing to tell."""

    gamma: float
    told: bool | None
    seed: int
    figures: dict[str, float]


@dataclass(frozen=True)
class KeepRow:
    """All seeds at one gamma.

    Attributes
    ----------
    gamma : float
        Fraction of the events that was kept.
    told : bool or None
        Whether the algorithm knew it; None at gamma = 1.
    seeds : int
        Runs behind the figures.
    mean, spread : dict of str to float
        Of every figure of `score`; the spread is the standard deviation over the seeds (n - 1), NaN
        with one seed.
    """

    gamma: float
    told: bool | None
    seeds: int
    mean: dict[str, float]
    spread: dict[str, float]


@dataclass(frozen=True, eq=False, repr=False)
class KeepCurve(Result):
    """A table: one row for each gamma, told and not told.

    Attributes
    ----------
    algorithm, scene : str
        What was scored on what.
    before : str or None
        The filter in front, which sees every event.
    scored : list of Scored
        Every run.
    """

    algorithm: str
    scene: str
    before: str | None
    scored: list[Scored]

    @property
    def rows(self) -> list[KeepRow]:
        """Largest gamma first, told before not told."""
        kinds = {(one.gamma, one.told) for one in self.scored}
        order = sorted(kinds, key=lambda kind: (-kind[0], not kind[1]))
        return [self._row(gamma, told) for gamma, told in order]

    def _row(self, gamma: float, told: bool | None) -> KeepRow:
        runs = [one.figures for one in self.scored if (one.gamma, one.told) == (gamma, told)]
        values = {name: np.array([run[name] for run in runs], np.float64) for name in runs[0]}
        return KeepRow(
            gamma,
            told,
            len(runs),
            {name: float(of.mean()) for name, of in values.items()},
            {name: _spread(of) for name, of in values.items()},
        )

    def __iter__(self) -> Iterator[KeepRow]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def summary(self) -> dict[str, Any]:
        """Return one JSON object; what does not exist (NaN) is None."""
        return {
            "schema_version": SCHEMA_VERSION,
            "algorithm": self.algorithm,
            "scene": self.scene,
            "before": self.before,
            "rows": [
                {
                    "gamma": row.gamma,
                    "told": row.told,
                    "seeds": row.seeds,
                    "mean": _without_nan(row.mean),
                    "spread": _without_nan(row.spread),
                }
                for row in self.rows
            ],
        }

    def plot(self) -> Figure:
        """Draw the main scores over gamma, told and not told, with the spread over the seeds."""
        from asap.report import accuracy_figures

        return accuracy_figures.figure([self])

    def report(self, path: str | os.PathLike[str]) -> Path:
        """Write one self-contained HTML page and return its path; needs matplotlib."""
        from asap.report import accuracy_report

        return accuracy_report.write(self, path)

    def to_dict(self) -> dict[str, Any]:
        """Return the `summary`, by its old name."""
        warnings.warn("to_dict() is now summary()", DeprecationWarning, stacklevel=2)
        return self.summary()

    def _repr_html_(self) -> str:
        from asap.report import notebook

        return notebook.keep_curve_html(self)

    def __repr__(self) -> str:
        rows = ", ".join(f"{row.gamma:g}" for row in self.rows)
        return f"<KeepCurve: {self.algorithm} on {self.scene}: gamma {rows}>"

    def __str__(self) -> str:
        from asap.report import accuracy_table

        return accuracy_table.format_keep_curve(self)


def keep_curve(
    algorithm: Callable[[int, int], Any],
    scene: Callable[[int], Scene] | Scene,
    *,
    gammas: Sequence[float] = GAMMAS,
    seeds: Sequence[int] = (0, 1, 2),
    before: Callable[[int, int], Any] | None = None,
    active: str = "produced",
) -> KeepCurve:
    """Score an algorithm with less and less of the events, told and not told how many are kept.

    Parameters
    ----------
    algorithm : callable
        A class or function of (width, height) that makes a fresh tracker or corner detector.
    scene : callable or Scene
        A function of a seed, such as ``asap.scenes.A``; a single scene is the same for all seeds.
    gammas : sequence of float
        Fractions to keep, in (0, 1].
    seeds : sequence of int
        Each makes a scene and a thinning of its own.
    before : callable, optional
        A class or function of (width, height) that makes the filter in front. It sees every event:
        the thinning is behind it.
    active : {"produced", "kept"}
        As in `score`.

    Returns
    -------
    KeepCurve
        ``print`` it for a table; ``.rows``, ``.summary()``, ``.plot()``, ``.report(path)``.

    Raises
    ------
    TypeError
        The algorithm or the filter is an object instead of what makes one.
    ValueError
        A gamma outside (0, 1], or no gamma or seed.

    Notes
    -----
    Uniform and independent thinning (`asap.GammaFilter`). An algorithm without ``set_keep`` is not
    told.
    """
    gammas = [
        checks.number("gammas", gamma, math.ulp(0.0), 1, "must be in (0, 1]")
        for gamma in checks.listed("gammas", gammas)
    ]
    for seed in checks.listed("seeds", seeds):
        checks.whole("seeds", seed, 0, 2**64 - 1, "must be at least 0 and below 2**64")
    for name, make in (("algorithm", algorithm), ("before", before)):
        if name == "before" and make is None:
            continue
        if not callable(make) or _is_an_object(make):
            raise TypeError(
                checks.named(
                    name,
                    make,
                    "give its class or a function of (width, height), as every run needs a fresh "
                    "one",
                )
            )
    scored: list[Scored] = []
    scenes: list[Scene] = []
    for seed in seeds:
        scenes.append(scene(seed) if callable(scene) else scene)
        check_scene(scenes[-1])
        scored += scores_of(
            algorithm, scenes[-1], gammas=gammas, seed=seed, before=before, active=active
        )
    size = scenes[0].width, scenes[0].height
    return KeepCurve(
        _name(algorithm, *size),
        _scene_name(scene, scenes[0]),
        _name(before, *size) if before is not None else None,
        scored,
    )


def scores_of(
    algorithm: Callable[[int, int], Any],
    scene: Scene,
    *,
    gammas: Sequence[float],
    seed: int,
    before: Callable[[int, int], Any] | None = None,
    active: str = "produced",
) -> list[Scored]:
    """Score on one scene at every gamma, told (where the algorithm can be) and not told."""

    def run(gamma: float, told: bool | None) -> Scored:
        found = score(
            algorithm(scene.width, scene.height),
            scene,
            before=before(scene.width, scene.height) if before is not None else None,
            gamma=gamma,
            told=bool(told),
            seed=seed,
            active=active,
        )
        return Scored(gamma, told, seed, found)

    can = can_be_told(algorithm(scene.width, scene.height))
    ways: tuple[bool, ...] = (True, False) if can else (False,)
    return [run(gamma, told) for gamma in gammas for told in (ways if gamma < 1 else (None,))]


def _is_an_object(make: Any) -> bool:
    return not isinstance(make, type) and hasattr(make, "process")


def _name(make: Callable[[int, int], Any], width: int, height: int) -> str:
    """Name what is made; a lambda has no name of its own."""
    name = getattr(make, "__name__", "<lambda>")
    if name != "<lambda>":
        return name
    made = make(width, height)
    return str(getattr(made, "name", None) or type(made).__name__)


def _scene_name(make: Any, made: Scene) -> str:
    name = getattr(make, "__name__", "<lambda>")
    return str(getattr(made, "name", type(made).__name__)) if name == "<lambda>" else name


def _spread(values: Any) -> float:
    return float(values.std(ddof=1)) if values.size > 1 else math.nan


def _without_nan(figures: dict[str, float]) -> dict[str, float | None]:
    return {name: value if math.isfinite(value) else None for name, value in figures.items()}
