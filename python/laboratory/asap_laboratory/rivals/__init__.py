"""The rivals' study: the cluster tracker beside its rivals, on scenes and on recordings.

All trackers on one input are one task, so that their costs are of the same minutes on the same
machine. "quick" takes A and E with one seed, "default" A to O with the seeds 1000 to 1019 and the
labelled recordings that are here, "full" twice as many seeds.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from asap_laboratory.accuracy import Rung, scene_of
from asap_laboratory.page import (
    Row,
    Rows,
    Tables,
    Writer,
    fixed,
    only,
    over_seeds,
)
from asap_laboratory.rivals import recordings
from asap_laboratory.rivals.recordings import HEAD, RecordingCase
from asap_laboratory.rivals.trackers import OURS, RIVALS, costs_ns
from asap_laboratory.scoring import Scene
from asap_laboratory.scoring import columns as scores
from asap_laboratory.scoring.matching import match
from asap_laboratory.scoring.measures import mota
from asap_laboratory.scoring.trace import follow
from asap_laboratory.study import Batch, Study

__all__ = ["RIVALS_STUDY", "RivalsCase"]

_FIGURES = ("mota", "id_switches", "position_rms", "velocity_rms", "ns_per_event")
SCENES = (*"ABCDEFG", "H_bars", "H_angles", "H_rings", *"IJKLMNO")
_FIRST_SEED = 1000  # nothing was chosen on it and those after it
_SEEDS = {"quick": 1, "default": 20, "full": 40}
_SECONDS = {"A": 3, "C": 3, "E": 3, "G": 15}
_USUAL_SECONDS = 6


@dataclass(frozen=True)
class RivalsCase:
    """All trackers on one scene with one seed."""

    scene: str
    seed: int
    labels: tuple[str, ...] = tuple(RIVALS)

    def weight(self) -> float:
        """Seconds, about, by the million."""
        return 1e6 * _SECONDS.get(self.scene, _USUAL_SECONDS)

    def measure(self) -> Rows:
        """Run it."""
        scene = scene_of(self.scene, self.seed)
        rungs = {label: RIVALS[label] for label in self.labels}
        figures = {label: _scored(rung, scene) for label, rung in rungs.items()}
        costs = costs_ns(rungs, scene)
        what = {"kind": "scene", "scene": self.scene, "seed": self.seed}
        return [
            {**what, "tracker": label, **one, "ns_per_event": costs[label]}
            for label, one in figures.items()
        ]


def _scored(rung: Rung, scene: Scene) -> dict[str, float]:
    """Return the figures of the table; all figures of `score` would take twice as long."""
    tracker, before = rung.made_for(scene)
    found = mota(match(follow(tracker, scene, before=before).samples))
    return {name: getattr(found, name) for name in _FIGURES[:-1]}


def _batches(form: str) -> Generator[Batch, Rows, None]:
    seeds = range(_FIRST_SEED, _FIRST_SEED + _SEEDS[form])
    chosen = "AE" if form == "quick" else SCENES
    folders = [] if form == "quick" else recordings.at_hand()
    on_recordings = [RecordingCase(str(folder.resolve())) for folder in folders]
    yield Batch([*(RivalsCase(one, seed) for one in chosen for seed in seeds), *on_recordings])


def _summary(rows: Rows) -> Tables:
    scored = only(rows, kind="scene")
    table = over_seeds(scored, ("scene", "tracker"), _FIGURES)
    for row in table:
        here = only(scored, scene=row["scene"])
        theirs = {one["seed"]: one["mota"] for one in only(here, tracker=row["tracker"])}
        by = [one["mota"] - theirs[one["seed"]] for one in only(here, tracker=OURS)]
        counts = (sum(d > 0 for d in by), sum(d == 0 for d in by), sum(d < 0 for d in by))
        row["ahead"] = None if row["tracker"] == OURS else " / ".join(map(str, counts))
    names = ("set", "tracker", "hit", "precision", "switches", "longest", "error", "iou", "mota")
    found = [{one: row[one] for one in (*names, "ns_per_event")} for row in rows if "set" in row]
    return {"rivals": table, "recordings": found}


def _facts(tables: Tables) -> dict[str, Any]:
    rows = tables["rivals"]
    best = {row["scene"]: row["mota"] for row in sorted(rows, key=lambda row: float(row["mota"]))}
    for row in rows:
        row["best"] = best[row["scene"]] - row["mota"] < 0.0005
    seeds = rows[0]["seeds"]
    of = f"{_FIRST_SEED} to {_FIRST_SEED + seeds - 1}" if seeds > 1 else f"{_FIRST_SEED}"
    return {
        "verdict": _verdict(_by_place(tables)),
        "seeds": f"seed{'s' * (seeds > 1)} {of}",
        "head": {"tracker": "", **HEAD},
    }


def _by_place(tables: Tables) -> dict[str, dict[str, Row]]:
    """Put the rows together by the scene or recording, as it is shown, and the tracker."""
    places: dict[str, dict[str, Row]] = {}
    for row in tables["rivals"]:
        places.setdefault(_scene(row), {})[row["tracker"]] = row
    for row in tables["recordings"]:
        places.setdefault(row["set"].partition("_")[0], {})[row["tracker"]] = row
    return places


def _verdict(places: Mapping[str, Mapping[str, Row]]) -> str:
    """Say, in a sentence, where a rival has the higher MOTA (mean of the seeds): the best there."""
    lost = []
    for place, here in places.items():
        best = max(here.values(), key=lambda row: float(row["mota"]))
        by = best["mota"] - here[OURS]["mota"]
        if by > 0:
            lost.append(f"{best['tracker']} on {place} (by {fixed(by, 2)})")
    if not lost:
        return "No rival has a higher MOTA anywhere."
    return f"Higher MOTA than `{OURS}`, the best at each place: {', '.join(lost)}."


def _scene(row: Row) -> str:
    return str(row["scene"].replace("_", " "))


def _draw(tables: Tables) -> Mapping[str, Any]:
    from asap_laboratory.rivals import figures

    return {"rivals": figures.draw(_by_place(tables))}


def _shown(tables: Tables, writer: Writer) -> str:
    rows = _facts(tables)["verdict"]
    parts = [
        rows,
        "MOTA",
        writer.pivot(tables["rivals"], {"scene name": "scene"}, "tracker", "mean mota"),
        "ns of processor time per event",
        writer.pivot(tables["rivals"], {"scene name": "scene"}, "tracker", "ns_per_event"),
        writer.listing(tables["recordings"], {"tracker": "", **HEAD}),
    ]
    return "\n\n".join(parts)


def _mean_mota(row: Row) -> str:
    return f"**{fixed(row['mota'])}**" if row["best"] else fixed(row["mota"])


RIVALS_STUDY = Study(
    name="rivals",
    command="asap-study --rivals",
    template=Path(__file__).with_name("page.md"),
    batches=_batches,
    summary=_summary,
    tables=("rivals", "recordings"),
    cells={
        **scores.CELLS,
        **recordings.CELLS,
        "scene name": _scene,
        "mean mota": _mean_mota,
    },
    figures=_draw,
    facts=_facts,
    shown=_shown,
)
