"""keep_curve: what discarding costs an algorithm: every score against the kept fraction gamma."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from asap import _checks, _units
from asap_laboratory.page import Row, Rows, over_seeds
from asap_laboratory.scoring.columns import CELLS, columns_of
from asap_laboratory.scoring.scene import Scene, check_scene
from asap_laboratory.scoring.scoring import can_be_told, score

GAMMAS = (1.0, 0.5, 0.2, 0.1, 0.05)

_KEYS = ("gamma", "told")


@dataclass(frozen=True, eq=False, repr=False)
class KeepCurve:
    """A table: one row for each gamma, told and not told.

    Attributes
    ----------
    algorithm, scene : str
        What was scored on what.
    before : str or None
        The filter in front, which sees every event.
    scored : list of dict
        Every run: gamma, told (None at gamma = 1, where there is nothing to tell), seed, and the
        figures of `score`.
    """

    algorithm: str
    scene: str
    before: str | None
    scored: Rows

    @property
    def rows(self) -> Rows:
        """gamma, told, seeds, and of every figure mean and deviation (``<figure>_sd``).

        Largest gamma first, told before not told. What does not exist is None.
        """
        figures = [name for name in self.scored[0] if name not in (*_KEYS, "seed")]
        rows = over_seeds(self.scored, _KEYS, figures)
        return sorted(rows, key=lambda row: (-row["gamma"], not row["told"]))

    @property
    def _title(self) -> str:
        behind = f" behind {self.before}" if self.before else ""
        count = self.rows[0]["seeds"]
        seeds = "1 seed" if count == 1 else f"{count} seeds: mean ± standard deviation"
        return f"{self.algorithm}{behind} on {self.scene}, {seeds}"

    def __str__(self) -> str:
        columns = columns_of(self.rows[0])
        cells = [
            ("gamma", "", *(heading for heading, _ in columns.values())),
            *(
                (f"{row['gamma']:g}", *(CELLS[name](row) for name in ("told", *columns)))
                for row in self.rows
            ),
        ]
        (head, *lines), rule = _units.aligned(cells, left=2)
        return "\n".join([self._title, "", head, rule, *lines])


def keep_curve(
    algorithm: Callable[[int, int], Any],
    scene: Callable[[int], Scene] | Scene,
    *,
    gammas: Sequence[float] = GAMMAS,
    seeds: Sequence[int] = (0, 1, 2),
    before: Callable[[int, int], Any] | None = None,
) -> KeepCurve:
    """Score an algorithm with less and less of the events, told and not told how many are kept.

    Parameters
    ----------
    algorithm : callable
        A class or function of (width, height) that makes a fresh tracker or corner detector.
    scene : callable or Scene
        A function of a seed, such as ``scenes.A``; a single scene is the same for all seeds.
    gammas : sequence of float
        Fractions to keep, in (0, 1].
    seeds : sequence of int
        Each makes a scene and a thinning of its own.
    before : callable, optional
        A class or function of (width, height) that makes the filter in front. It sees every event:
        the thinning is behind it.

    Returns
    -------
    KeepCurve
        ``print`` it for a table; ``.rows``.

    Raises
    ------
    TypeError
        The algorithm or the filter is an object instead of what makes one.
    ValueError
        A gamma outside (0, 1], or no gamma or seed.

    Notes
    -----
    Uniform and independent thinning (`asap.GammaFilter`). An algorithm without ``set_gamma`` is not
    told.
    """
    gammas = [
        _checks.number("gammas", gamma, math.ulp(0.0), 1, "must be in (0, 1]")
        for gamma in _checks.listed("gammas", gammas)
    ]
    for seed in _checks.listed("seeds", seeds):
        _checks.whole("seeds", seed, 0, 2**64 - 1, "must be at least 0 and below 2**64")
    for name, make in (("algorithm", algorithm), ("before", before)):
        if name == "before" and make is None:
            continue
        if not callable(make) or _is_an_object(make):
            raise TypeError(
                _checks.named(
                    name,
                    make,
                    "give its class or a function of (width, height), as every run needs a fresh "
                    "one",
                )
            )
    scored: Rows = []
    scenes: list[Scene] = []
    for seed in seeds:
        scenes.append(scene(seed) if callable(scene) else scene)
        check_scene(scenes[-1])
        scored += scores_of(algorithm, scenes[-1], gammas=gammas, seed=seed, before=before)
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
) -> Rows:
    """Score on one scene at every gamma, told (where the algorithm can be) and not told."""

    def run(gamma: float, told: bool | None) -> Row:
        found = score(
            algorithm(scene.width, scene.height),
            scene,
            before=before(scene.width, scene.height) if before is not None else None,
            gamma=gamma,
            told=bool(told),
            seed=seed,
        )
        return {"gamma": gamma, "told": told, "seed": seed, **found}

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
