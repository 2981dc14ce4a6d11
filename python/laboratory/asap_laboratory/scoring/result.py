"""KeepCurve: every score of an algorithm against the kept fraction gamma."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from asap.results import text
from asap.results.data import Result, without_nan
from asap_laboratory.scoring import table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
            "rows": [without_nan(asdict(row)) for row in self.rows],
        }

    def plot(self) -> Figure:
        """Draw the main scores over gamma, told and not told, with the spread over the seeds."""
        from asap_laboratory.scoring import report

        return report.figure([self])

    def report(self, path: str | os.PathLike[str]) -> Path:
        """Write one self-contained HTML page and return its path; needs matplotlib."""
        from asap_laboratory.scoring import report

        return report.write(self, path)

    def _repr_html_(self) -> str:
        head, *rows = table.cells(self)
        return text.heading(table.title(self)) + text.table(head, rows)

    def __repr__(self) -> str:
        rows = ", ".join(f"{row.gamma:g}" for row in self.rows)
        return f"<KeepCurve: {self.algorithm} on {self.scene}: gamma {rows}>"

    def __str__(self) -> str:
        return table.format_keep_curve(self)


def _spread(values: Any) -> float:
    return float(values.std(ddof=1)) if values.size > 1 else math.nan
