"""The figure of the rivals: accuracy and processor time of every tracker, input by input.

Needs matplotlib: ``asap-events[report]``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from asap import plots  # first: it says which extra is missing
from asap_laboratory.page import Row
from asap_laboratory.rivals.trackers import OURS

import matplotlib  # isort: skip
from matplotlib.layout_engine import ConstrainedLayoutEngine  # isort: skip

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MIN = -1.0  # MOTA: what is below stands at the edge
_LOOKS: dict[str, tuple[str, str, bool]] = {  # colour, marker, filled
    "frames 10 ms": (plots.AMBER, "s", True),
    "frames 20 ms": (plots.VERMILION, "s", True),
    "published": (plots.PURPLE, "^", False),
    "BAF + published, steady": (plots.PURPLE, "^", True),
    "jAER-type core": (plots.GREEN, "v", False),
    "BAF + jAER-type core": (plots.GREEN, "v", True),
    OURS: (plots.BLUE, "o", True),  # last: on top
}


def draw(lines: Mapping[str, Mapping[str, Row]]) -> plots.NotebookFigure:
    """Draw one line for each scene and recording: MOTA left, ns per event right, a dot for each."""
    with matplotlib.rc_context({**plots.STYLE, "font.size": 10, "ytick.labelsize": 9}):
        room = ConstrainedLayoutEngine(w_pad=0.12, h_pad=0.1)
        size_inches = (4.4, 2.4 + 0.24 * len(lines))
        figure = plots.NotebookFigure(figsize=size_inches, layout=room)
        panels: Any = figure.subplots(1, 2, sharey=True, width_ratios=(1.7, 1.0))
        accuracy, cost = panels
        for label, (colour, marker, filled) in _LOOKS.items():
            look = {
                "color": colour,
                "marker": marker,
                "markersize": 6.5 if label == OURS else 4.5,
                "markerfacecolor": colour if filled else "none",
                "linestyle": "none",
                "clip_on": False,
                "label": label,
            }
            _dots(accuracy, [line.get(label, {}).get("mota") for line in lines.values()], look)
            _dots(cost, [line.get(label, {}).get("ns_per_event") for line in lines.values()], look)
        accuracy.set(title="MOTA", xlim=(_MIN, 1.0), ylim=(len(lines) - 0.5, -0.5))
        accuracy.set_xticks((-1, -0.5, 0, 0.5, 1), ("≤ -1", "-.5", "0", ".5", "1"))
        accuracy.set_yticks(range(len(lines)), list(lines))
        cost.set(title="ns per event", xscale="log")
        least, most = cost.get_xlim()
        usual = (10, 100, 1000) if most > 20 * least else (20, 50, 100, 200)
        ticks = [tick for tick in usual if least <= tick <= most]
        cost.set_xticks(ticks, [f"{tick}" for tick in ticks])
        cost.set_xticks((), minor=True)
        for axes in panels:
            axes.tick_params(length=0)
        handles, labels = accuracy.get_legend_handles_labels()
        figure.legend(handles[::-1], labels[::-1], loc="outside lower left", ncols=2, fontsize=9)
    return figure


def _dots(axes: Axes, values: Sequence[float | None], look: dict[str, Any]) -> None:
    known = [(value, place) for place, value in enumerate(values) if value is not None]
    if known:
        x = [max(value, _MIN) for value, _ in known]
        axes.plot(x, [place for _, place in known], **look)
