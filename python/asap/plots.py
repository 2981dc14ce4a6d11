"""Figures of runs and events.

Pixels with y down, time in s from the first event, ON red, OFF blue. Every function draws into the
axes (or figure) that it is given, makes its own otherwise, and returns them; pyplot and the global
style stay untouched. Needs matplotlib: ``asap-events[report]``.
"""

from asap.results.figures import (
    AMBER,
    BLUE,
    FAINT,
    GREEN,
    INK,
    PURPLE,
    STYLE,
    VERMILION,
    NotebookFigure,
    clusters,
    control,
    figure,
    frame,
    rate,
    svg,
    tracks,
)

__all__ = [
    "AMBER",
    "BLUE",
    "FAINT",
    "GREEN",
    "INK",
    "PURPLE",
    "STYLE",
    "VERMILION",
    "NotebookFigure",
    "clusters",
    "control",
    "figure",
    "frame",
    "rate",
    "svg",
    "tracks",
]
