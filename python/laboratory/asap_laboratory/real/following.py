"""Followed: what a tracker said about a recording with boxes, and what it was worth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from asap.results.data import without_nan
from asap_laboratory.accuracy.cases import Rung
from asap_laboratory.rivals.cost import costs_ns
from asap_laboratory.scenes import LabelledScene
from asap_laboratory.scoring.boxes import BoxMatch, box_matches, box_score, frames
from asap_laboratory.scoring.trace import snapshots_at


@dataclass(frozen=True)
class Followed:
    """A tracker on a recording with boxes.

    Attributes
    ----------
    scene : LabelledScene
    figures : dict of str to float
        hit, precision, switches, longest, error, mota as of `score`, and ns_per_event.
    matches : list of BoxMatch
        At each labelled time.
    clusters : list of ndarray
        The clusters of each of them, as the tracker tells them.
    """

    scene: LabelledScene
    figures: dict[str, float]
    matches: list[BoxMatch]
    clusters: list[NDArray[np.void]]

    @property
    def times_s(self) -> NDArray[np.float64]:
        """The labelled times, s from the first event."""
        stamps = np.array([one.frame["t_us"][0] for one in self.matches], np.int64)
        return np.asarray((stamps - self.scene.events["t"][0]) * 1e-6)

    def summary(self) -> dict[str, Any]:
        """Name and figures as JSON holds them; None where a figure does not exist."""
        return {"set": self.scene.name, **without_nan(self.figures)}


class _Witness:
    """A tracker whose clusters are noted whenever they are read."""

    def __init__(self, tracker: Any) -> None:
        self._tracker = tracker
        self.clusters: list[NDArray[np.void]] = []

    def process(self, events: NDArray[np.void]) -> None:
        self._tracker.process(events, labels=False)

    def clusters_at(self, t_us: int) -> NDArray[np.void]:
        self.clusters.append(self._tracker.clusters_at(t_us))
        return self.clusters[-1]


def follow(rungs: dict[str, Rung], scene: LabelledScene) -> dict[str, Followed]:
    """Let trackers follow a recording; score them, and time them in turns."""
    costs = costs_ns(rungs, scene)
    return {label: _followed(rung, scene, costs[label]) for label, rung in rungs.items()}


def _followed(rung: Rung, scene: LabelledScene, ns_per_event: float) -> Followed:
    tracker, before = rung.made_for(scene)
    witness = _Witness(tracker)
    times = [int(frame["t_us"][0]) for frame in frames(scene.boxes)]
    snapshots, _ = snapshots_at(witness, scene, times, before=before)
    matches = box_matches(scene, snapshots)
    figures = {**box_score(scene, matches)._asdict(), "ns_per_event": ns_per_event}
    return Followed(scene, figures, matches, witness.clusters)
