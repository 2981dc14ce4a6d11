"""view: a run in Rerun, or its curves as text on the terminal.

A process of its own draws, see `rerun` and `monitor`. A thread hands it snapshots, at most 15 a
second: if that process is stalled or killed, only this thread waits or ends.
"""

from __future__ import annotations

import io
import os
import subprocess
import sys
import threading
from collections import deque
from contextlib import nullcontext, suppress
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from asap import _checks
from asap._process import begun
from asap.events import EVENT_DTYPE
from asap.experiment.pipeline import Pipeline
from asap.experiment.telemetry import TELEMETRY_DTYPE, Rows, as_rows
from asap.io.errors import library
from asap.results import Run
from asap.viewer import monitor, rerun
from asap.viewer.pictures import found_by, frames
from asap.viewer.rerun import PORT

__all__ = ["View", "view"]

_FRAME_S = 1 / 15
_SHOWN_S = 0.02  # of events in a picture
_PATIENCE_S = 10.0
_HEAD, _PARTS = 8, 4  # of a frame: bytes of its size, arrays


def view(
    pipeline_or_run: Pipeline | Run,
    target: str | os.PathLike[str] = "spawn",
    *,
    algorithm: Any = None,
) -> View:
    """Show a pipeline while it works, or what a finished run has left behind.

    Parameters
    ----------
    pipeline_or_run : Pipeline or Run
        A run shows its curves and, if its algorithm was an `asap.Tracks`, clusters and events.
    target : "spawn", "connect", "terminal" or path
        A new window of Rerun on this machine; one that listens on port 9876 of this machine, which
        may be the end of an ssh tunnel; the curves alone, as text; or a ``.rrd`` file to write.
    algorithm : optional
        Whose ``.objects`` or ``.clusters`` are shown; another thread reads them. Default: that of
        the pipeline.

    Returns
    -------
    View
        ``close()``, or leaving its ``with`` block, ends it.

    Raises
    ------
    MissingLibrary
        rerun-sdk is not installed: extra ``view``; for "terminal" rich: extra ``monitor``.

    Examples
    --------
    ::

        with asap.Pipeline(tracker, camera=camera, latency_ms=10) as pipeline:
            with asap.view(pipeline):
                pipeline.run()
    """
    if isinstance(pipeline_or_run, Pipeline):
        shown = View(target)
        shown.attach(pipeline_or_run, algorithm)
        return shown
    if not isinstance(pipeline_or_run, Run):
        remedy = "give an asap.Pipeline or a run of asap.run or asap.simulate"
        raise TypeError(_checks.named("pipeline_or_run", pipeline_or_run, remedy))
    run = pipeline_or_run
    sensor = run.source["width"], run.source["height"]
    rows = as_rows(run.packages, run.latency_bound_us)
    for name in ("stale", "overflow"):
        rows[f"all_{name}"] = np.cumsum(rows[name])
    rows["all_discarded"] = np.cumsum(np.rint(rows["size"] / rows["gamma"]) - rows["size"])
    with View(target) as shown:
        for _, part, events, found in frames(run, rows):
            if not shown.send(part, sensor, events, found):
                break
    return shown


def draw(target: str) -> None:
    """Be the process that shows what comes in by its standard input, until it ends."""
    os.nice(19)
    with suppress(OSError, AttributeError):  # as on Linux: at once, where one of the run wakes up
        os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
    is_text = target == "terminal"
    opened: Any = monitor.shown("asap run") if is_text else rerun.shown(target)
    with opened as show:
        while head := sys.stdin.buffer.read(_HEAD):
            size = int.from_bytes(head, "little")
            frame = io.BytesIO(sys.stdin.buffer.read(size))
            if len(frame.getbuffer()) < size:
                break  # cut: the run was killed
            show(*(np.load(frame, allow_pickle=False) for _ in range(_PARTS)))


def _has_screen() -> bool:
    names = ("DISPLAY", "WAYLAND_DISPLAY")
    return sys.platform != "linux" or any(map(os.environ.get, names))


class View:
    """A process that shows frames, and the thread that takes them from a pipeline."""

    def __init__(self, target: str | os.PathLike[str]) -> None:
        if target == "spawn" and not _has_screen():
            raise RuntimeError(
                "view: no screen, DISPLAY is not set; give a file, such as run.rrd, or 'connect' "
                f"after ssh -R {PORT}:localhost:{PORT} from a machine where rerun is open"
            )
        self._is_text = target == "terminal"
        self._file: Path | None = None
        if self._is_text:
            monitor.need_terminal()
        elif find_spec("rerun") is None:
            library("rerun", "a view", "view")
        if target not in ("spawn", "connect", "terminal"):
            path = _checks.new_file("target", target)
            remedy = "give 'spawn', 'connect', 'terminal' or a .rrd file"
            _checks.ending("target", path, (".rrd",), remedy)
            target = str(path.absolute())
            self._file = path
        self._process = begun(draw, target)
        self._pipe: Any = self._process.stdin
        self._closing = threading.Event()
        self._thread: threading.Thread | None = None

    def attach(self, pipeline: Any, algorithm: Any = None) -> None:
        """Show this pipeline from now on."""
        if self._thread is None:
            shown = pipeline.algorithm if algorithm is None else algorithm
            self._thread = threading.Thread(
                target=self._watch, args=(pipeline, shown), name="asap view", daemon=True
            )
            self._thread.start()

    def _watch(self, pipeline: Pipeline, algorithm: Any) -> None:
        came: deque[Rows] = deque(maxlen=100)
        look = came.append
        pipeline._log.watchers.append(look)
        is_over, events, found = False, np.empty(0, EVENT_DTYPE), found_by(None)
        while not is_over:
            is_over = self._closing.wait(monitor.EVERY_S if self._is_text else _FRAME_S)
            if not self._is_text:
                pipeline._native.glimpse(more=True)
                self._closing.wait(_SHOWN_S)
                events, found = pipeline._native.glimpse(more=False), found_by(algorithm)
            parts = [came.popleft() for _ in range(len(came))]
            rows = np.concatenate([np.empty(0, TELEMETRY_DTYPE), *parts])
            if not self.send(rows, pipeline._sensor, events, found):
                break
        pipeline._log.watchers.remove(look)

    def send(self, rows: Rows, sensor: Any, events: Any, found: Any) -> bool:
        """Hand a frame over; False: that process has ended."""
        whole = io.BytesIO()
        for part in (rows, np.array([side or 0 for side in sensor]), events, found):
            np.save(whole, part, allow_pickle=False)
        try:
            self._pipe.write(whole.tell().to_bytes(_HEAD, "little"))
            self._pipe.write(whole.getbuffer())  # no copy
            self._pipe.flush()
        except OSError:
            return False
        return True

    def close(self) -> None:
        """Show the last frame and end; a file is waited for, a viewer that takes none is not.

        Raises
        ------
        RuntimeError
            The file could not be written.
        """
        patience_s = _PATIENCE_S if self._file is None else None
        self._closing.set()
        if self._thread is not None:
            self._thread.join(patience_s)
            if self._thread.is_alive():  # in a write that ends with the process
                self._process.kill()
                self._thread.join()
        with suppress(OSError):  # what that process did not take
            self._pipe.close()
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(patience_s)
        self._process.kill()  # where it has not ended
        code = self._process.wait()
        if self._file is not None and (code or not self._file.exists()):
            raise RuntimeError(f"{self._file}: not written: what writes it ended with code {code}")

    def __enter__(self) -> View:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        with nullcontext() if kind is None else suppress(RuntimeError):
            self.close()
