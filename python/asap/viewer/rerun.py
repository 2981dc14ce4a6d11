"""A run in Rerun, as the process of `viewer` shows it.

Whatever it starts is told by the environment to send no usage statistics, and listens and talks on
127.0.0.1 alone.
"""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from asap.events import Events
from asap.experiment.telemetry import Rows, summed
from asap.viewer.pictures import BRIGHT, COLOURS, outlines_of, painted

PORT = 9876

_POINT_US = 66_000  # of a curve
_CURVES_S = 15.0
_TRAIL_S = 0.7

# The first switches usage statistics off, without a file of its own. The others refuse a window of
# Rerun its look at whether there is a newer version.
_PRIVATE = {
    "CI": "1",
    **dict.fromkeys(("HTTP_PROXY", "HTTPS_PROXY", "ALL_PROXY"), "http://127.0.0.1:9"),
}

_RED = (255, 92, 92)
_CURVES = {  # panel: its title, and its lines: colour, figure of `summed`, and of its unit
    "size": ("package size [events]", {"mean": ((92, 220, 255), "size", 1.0)}),
    "rate": (
        "event rate [Mev/s]",
        {"entering": ((150, 160, 170), "rate", 1e-6), "lost": (_RED, "lost", 1e-6)},
    ),
    "gamma": ("gamma", {"gamma": ((255, 209, 82), "gamma", 1.0)}),
    "latency": (
        "latency [ms]",
        {"bound": (_RED, "bound", 1e-3), "worst": ((94, 230, 166), "latency", 1e-3)},
    ),
    "ring": ("waiting in the ring [events]", {"most": ((94, 173, 255), "waiting", 1.0)}),
}
_LINES = [
    (f"loop/{name}/{line}", *how) for name, (_, all) in _CURVES.items() for line, how in all.items()
]


@contextmanager
def shown(target: str) -> Iterator[Callable[..., None]]:
    """Open the target, and give what draws a frame."""
    os.environ.update(_PRIVATE)
    import rerun as rr

    recording = rr.RecordingStream("asap")
    if target == "spawn":
        _open_window()
    is_file = target not in ("spawn", "connect")
    if is_file:
        recording.save(target)
    else:
        recording.connect_grpc(f"rerun+http://127.0.0.1:{PORT}/proxy")
    yield _Picture(recording).log
    recording.flush(timeout_sec=1e6 if is_file else 2.0)
    recording.disconnect()


def _open_window() -> None:
    with socket.socket() as listener:
        if listener.connect_ex(("127.0.0.1", PORT)) == 0:
            return  # one is open
    command = [sys.executable, "-m", "rerun_cli", "--bind", "127.0.0.1", "--port", str(PORT)]
    subprocess.Popen([*command, "--hide-welcome-screen"])


class _Picture:
    def __init__(self, recording: Any) -> None:
        import rerun as rr
        import rerun.blueprint as rrb

        self._rr, self._recording = rr, recording
        self._trails: dict[int, deque[tuple[float, float, float]]] = {}
        self._first_us: int | None = None
        self._lost = self._now_s = self._curves_s = 0.0

        classes = [rr.AnnotationInfo(id=n, color=colour) for n, colour in enumerate(COLOURS)]
        self._log("scene", rr.AnnotationContext(classes), static=True)
        for path, colour, *_ in _LINES:
            name = path.rpartition("/")[2]
            style = rr.SeriesLines(colors=[colour], names=[name], widths=[1.5])
            self._log(path, style, static=True)

        newest = rr.TimeRangeBoundary.cursor_relative(seconds=0)
        oldest = rr.TimeRangeBoundary.cursor_relative(seconds=-_CURVES_S)
        shown = [rr.VisibleTimeRange("time", start=oldest, end=newest)]
        curves = [
            rrb.TimeSeriesView(
                origin=f"loop/{name}",
                name=title,
                time_ranges=shown,
                axis_y=rrb.ScalarAxis(range=(0.0, 1.05)) if name == "gamma" else None,
                plot_legend=rrb.PlotLegend(visible=len(lines) > 1),
            )
            for name, (title, lines) in _CURVES.items()
        ]
        scene = rrb.Spatial2DView(origin="scene", name="events and clusters", background=COLOURS[0])
        blueprint = rrb.Blueprint(
            rrb.Horizontal(scene, rrb.Vertical(*curves), column_shares=[5, 3]),
            rrb.TimePanel(state="collapsed", timeline="time", play_state="following"),
            collapse_panels=True,
        )
        recording.send_blueprint(blueprint)

    def _log(self, *what: Any, static: bool = False) -> None:
        self._rr.log(*what, static=static, recording=self._recording)

    def log(self, rows: Rows, sensor: Any, events: Events, found: NDArray[np.void]) -> None:
        """Log a frame: points of the curves, the image, what was found with its trails."""
        cuts = np.flatnonzero(np.diff(rows["t_last"] // _POINT_US)) + 1
        for part in np.split(rows, cuts) if len(rows) else ():
            self._turn_to(part["t_first"][0], part["t_last"][-1])
            self._log_curves(part)
        if len(events):
            self._turn_to(events["t"][0], events["t"][-1])
            image = painted(events, (sensor[1], sensor[0]))
            self._log("scene/events", self._rr.SegmentationImage(image, opacity=1.0))
            self._log_found(outlines_of(found))

    def _turn_to(self, first_us: int, last_us: int) -> None:
        self._first_us = int(first_us) if self._first_us is None else self._first_us
        self._now_s = (int(last_us) - self._first_us) * 1e-6
        self._recording.set_time("time", duration=self._now_s)

    def _log_found(self, found: NDArray[np.void]) -> None:
        colours = [BRIGHT[int(one) % len(BRIGHT)] for one in found["id"]]
        outlines = self._rr.LineStrips2D(
            found["outline"],
            colors=colours,
            radii=-1.5,
            labels=[str(one) for one in found["id"]],
            show_labels=True,
        )
        self._log("scene/found", outlines)
        for one in found:
            trail = self._trails.setdefault(int(one["id"]), deque())
            trail.append((self._now_s, float(one["x"]), float(one["y"])))
        for trail in self._trails.values():
            while trail and trail[0][0] < self._now_s - _TRAIL_S:
                trail.popleft()
        self._trails = {name: trail for name, trail in self._trails.items() if trail}
        faint = [(*BRIGHT[name % len(BRIGHT)], 140) for name in self._trails]
        ways = [[(x, y) for _, x, y in trail] for trail in self._trails.values()]
        self._log("scene/tracks", self._rr.LineStrips2D(ways, colors=faint, radii=-1.0))

    def _log_curves(self, rows: Rows) -> None:
        seconds, self._curves_s = self._now_s - self._curves_s, self._now_s
        figures = summed(rows, self._lost)
        self._lost += figures["lost"]
        figures["lost"] /= max(seconds, 1e-3)
        figures["bound"] = float(rows["latency_bound_us"][-1])
        for path, _, name, unit in _LINES:
            self._log(path, self._rr.Scalars(figures[name] * unit))
