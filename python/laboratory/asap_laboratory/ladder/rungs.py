"""The ladder: every consumer of the library, from a filter to a clusterer without an index.

The stream that all of them get lasts 0.3 s, 9 Mev/s from 100 objects at up to 800 px/s on 1280 x
720 px. In virtual time the computer is taken to be `SLOWDOWN` times slower than the one that
measures; in real time the stream is replayed so many times as fast, which is the same load.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, Literal, NamedTuple

from asap import _core
from asap_laboratory import scenes
from asap_laboratory.scoring import Scene

LATENCY_MS = 3.0  #: the bound
SLOWDOWN = 8.0

Maker = Callable[[int, int], Any]


class LadderRung(NamedTuple):
    """A consumer.

    `score`: how its accuracy is told; `stated`: alpha in us and beta in ns, taken from elsewhere,
    not measured.
    """

    make: Maker
    score: Literal["tracker", "corners"] | None = None
    stated: tuple[float, float] | None = None


_ours = _core.ClusterTracker


def _published(width: int, height: int) -> Any:
    """Make one for this stream: a window of 8000 events lasts about a millisecond of it."""
    return _core.PublishedClusterTracker(
        width, height, window=8000, radius=20.0, probes=0, weight=0.05, min_size=15
    )


RUNGS: dict[str, LadderRung] = {
    "HotPixelMask": LadderRung(_core.HotPixelMask),
    "BAF": LadderRung(_core.BackgroundActivityFilter),
    "TOS": LadderRung(_core.ThresholdOrdinalSurface),
    "ArcStar": LadderRung(_core.ArcStar, "corners"),
    "FeatureTracker": LadderRung(_core.FeatureTracker),
    "SITS": LadderRung(_core.SpeedInvariantTimeSurface),
    "FAHarris": LadderRung(_core.FAHarris, "corners"),
    "ClusterTracker": LadderRung(_ours, "tracker"),
    "EFast": LadderRung(_core.EFast, "corners"),
    "published": LadderRung(_published, "tracker"),
    "EHarris": LadderRung(_core.EHarris, "corners"),
    "PlaneFlow": LadderRung(_core.PlaneFlow),
    # A smaller computer; the rule without an index; the authors' class.
    "ClusterTracker, 300 ns": LadderRung(_ours, "tracker", (5.0, 300.0)),
    "published, 450 ns": LadderRung(_published, "tracker", (1.0, 450.0)),
    "published, 2 us": LadderRung(_published, "tracker", (1.0, 2000.0)),
}
"""By label, about in the order of their cost."""


@lru_cache(maxsize=1)  # the tasks of a seed follow each other
def stream(size: str, seed: int) -> Scene:
    """Make the stream of a seed: "whole", or "small" for the quick form."""
    if size == "small":
        return scenes.timing(40, 640, 480, 800.0, (8.0, 14.0), seed, duration_s=0.15)
    return scenes.timing(100, 1280, 720, 800.0, (8.0, 14.0), seed, duration_s=0.3)
