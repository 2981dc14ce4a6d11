"""The table of the recordings: one row for each."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from asap_laboratory import writer
from asap_laboratory.real.following import Followed
from asap_laboratory.real.mistakes import mistakes
from asap_laboratory.tables import markdown

HEAD = ("set", "hit", "precision", "switches", "longest", "error px", "MOTA", "ns per event")

_OPENING = """\
`asap.ClusterTracker` as it comes on recordings with hand-made boxes. A box is hit when the centre
of a cluster lies inside it or up to 2 px beyond; clusters and boxes go together one to one. Longest
is the share of an object's boxes that its best id hit, mean over the objects; error is the median
distance of the centres; ns is processor time per event, median of three turns. The recordings
belong to third parties and are not distributed."""


def write(path: Path, sets: Sequence[Followed], *, command: str, seconds: float) -> list[Path]:
    """Write the table, what went wrong, and the data; return the paths."""
    sections = [
        table(sets),
        "## What went wrong",
    ]
    for one in sets:
        wrong = mistakes(one) or ["Nothing."]
        sections.append(f"**{one.scene.name}**\n\n" + "\n".join(f"- {words}" for words in wrong))
    title, data = "The cluster tracker on recordings", [_row(one) for one in sets]
    return writer.write(path, title, _OPENING, sections, data, command=command, seconds=seconds)


def _row(one: Followed) -> dict[str, Any]:
    return {"set": one.scene.name, **one.figures}


def table(sets: Sequence[Followed]) -> str:
    """Write one row for each recording, as Markdown."""
    return markdown(HEAD, [cells(one) for one in sets])


def cells(followed: Followed) -> tuple[str, ...]:
    """Write the row of one recording, in the order of `HEAD`."""
    judged = followed.scene.background_labelled
    return (followed.scene.name, *figure_cells(followed.figures, judged=judged))


def figure_cells(figures: Mapping[str, float], *, judged: bool) -> tuple[str, ...]:
    """Write hit, precision and the others; judged: whether the background is labelled."""
    return (
        _share(figures["hit"]),
        _share(figures["precision"]) if judged else "not judged",
        f"{figures['switches']:.0f}",
        _share(figures["longest"]),
        "-" if math.isnan(figures["error"]) else f"{figures['error']:.1f}",
        _share(figures["mota"]) if judged else "not judged",
        f"{figures['ns_per_event']:.0f}",
    )


def _share(value: float) -> str:
    return "-" if math.isnan(value) else re.sub(r"^(-?)0\.", r"\1.", f"{value:.3f}")
