"""Accuracy against gamma as tables and a document: algorithms and gammas by scenes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from asap_laboratory import writer
from asap_laboratory.scoring import KeepCurve, KeepRow
from asap_laboratory.scoring import table as accuracy_table
from asap_laboratory.tables import markdown

_OPENING = """\
How much accuracy does an algorithm lose when only a fraction gamma of the events is kept? Each was
run on scenes with exact truth, at gamma from 1 to 0.05, told the fraction (`set_keep`) and not
told. Told, `ClusterTracker` keeps most of its accuracy down to a fifth of the events; not told, it
takes thinned objects for noise. Corner detectors lose nearly all corners at a tenth. The figure
shows scene A, the tables every scene and measure. MOTA 1 means no error; higher is better."""

_HOW_TO_READ = """\
Every 5 ms from 100 ms on, clusters are matched greedily to active objects less than 12 px away;
position and velocity are of the matches, velocity as a share of the rms speed. A cell is the mean
over the seeds with the standard deviation. gamma is the fraction of the events that was kept,
uniformly and independently, behind the filter where there is one (BAF: 5 ms); "told": the algorithm
knew it. All scenes are synthetic: motion in steps of 0.25 ms, no lens or bandwidth model, no moving
background, edges of one contrast. True corners are events within 3.5 px of a vertex of their own
object."""

_COST = "ns_per_event_p50"


def write(
    path: Path,
    curves: Sequence[KeepCurve],
    *,
    command: str,
    seconds: float,
    figures: Iterable[Path] = (),
    missing: Sequence[str] = (),
) -> list[Path]:
    """Write the document and its data; return their paths.

    Parameters
    ----------
    path, command, seconds
        As in `writer.write`.
    curves : sequence of KeepCurve
        What was measured.
    figures : iterable of Path
        Beside the document.
    missing : sequence of str
        Algorithms that this build does not have.
    """
    seeds = max((row.seeds for curve in curves for row in curve.rows), default=0)
    pictures = writer.pictures(figures)
    sections = [
        _HOW_TO_READ,
        *([f"Not in this build: {', '.join(missing)}."] if missing else []),
        *pictures[1:],
    ]
    for columns in (accuracy_table.TRACKER_COLUMNS, accuracy_table.CORNER_COLUMNS):
        some = [curve for curve in curves if accuracy_table.columns_of(curve.rows[0]) is columns]
        for column, (heading, words) in columns.items() if some else ():
            sections += [f"## {heading}", f"{words[0].upper()}{words[1:]}.", by_scene(some, column)]
    sections += [
        "## Cost",
        "ns per event of filter and algorithm, median over the packages of 5 ms of these runs.",
    ]
    sections.append(by_scene(curves, _COST))
    return writer.write(
        path,
        "Accuracy against the kept fraction",
        _OPENING,
        sections,
        rows_of(curves),
        command=command,
        seconds=seconds,
        notes=f"; {seeds} seed{'s' * (seeds != 1)} of scene and thinning",
        lead=pictures[:1],
    )


def rows_of(curves: Iterable[KeepCurve]) -> Iterator[dict[str, Any]]:
    """Yield every score, with what was scored on what."""
    for curve in curves:
        what = {"algorithm": curve.algorithm, "before": curve.before, "scene": curve.scene}
        for one in curve.scored:
            how = {"gamma": one.gamma, "told": one.told, "seed": one.seed}
            yield {**what, **how, **one.figures}


def by_scene(curves: Sequence[KeepCurve], column: str) -> str:
    """Write one figure of `asap_laboratory.score` as Markdown: algorithms and gammas by scenes.

    Parameters
    ----------
    curves : sequence of KeepCurve
        In any order.
    column : str
        The figure.
    """
    scenes = list(dict.fromkeys(curve.scene for curve in curves))
    rows: dict[tuple[str, float, str], dict[str, str]] = {}
    for curve in curves:
        for row in curve.rows:
            key = (label_of(curve), row.gamma, accuracy_table.told(row))
            rows.setdefault(key, {})[curve.scene] = _cell(row, column)
    return markdown(
        ("", "gamma", "", *scenes),
        [
            (label, f"{gamma:g}", told, *(cells.get(scene, "") for scene in scenes))
            for (label, gamma, told), cells in rows.items()
        ],
    )


def label_of(curve: KeepCurve) -> str:
    """Name the algorithm with the filter in front of it."""
    return f"{curve.before} + {curve.algorithm}" if curve.before else curve.algorithm


def _cell(row: KeepRow, column: str) -> str:
    if column != _COST:
        return accuracy_table.cell(row, column)
    mean = row.mean[column]
    return "-" if math.isnan(mean) else f"{mean:.0f}"
