"""Telemetry: one row a package, from the log of a live pipeline to those that watch it."""

from __future__ import annotations

import os
import queue
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from asap import _checks, _core
from asap.results.run import LEDGER_FIELDS

Rows = NDArray[np.void]
Watcher = Callable[[Rows], object]

# The columns of `run.packages`, and what the pipeline said when it was looked at next, after 250 ms
# at most: the bound, the ledger, in even steps from look to look, what driver and file have lost.
TELEMETRY_DTYPE = np.dtype(
    [
        *_core.PACKAGE_DTYPE.descr,
        ("latency_bound_us", "<f8"),
        *((f"all_{name}", "<i8") for name in LEDGER_FIELDS),
        ("upstream_lost", "<i8"),
        ("rows_lost", "<i8"),
    ]
)
_ENDS = LEDGER_FIELDS[1:]  # which sum up to `received`
HEAD = (",".join(TELEMETRY_DTYPE.names or ()) + "\n").encode()
_FORMATS = {"i": "%d", "f": "%.16g"}
_KINDS = [TELEMETRY_DTYPE[name].kind for name in TELEMETRY_DTYPE.names or ()]
_LINE = ",".join(_FORMATS[kind] for kind in _KINDS) + "\n"

# Each look and each writing delays a package or two; 10 of 1000 would move the 99th percentile.
_EVERY_S = 0.25
_WRITE_S = 1.0
_WAITING = 20  # looks that wait for the disk, thus 5 s
_MAX_ROWS = 500_000  # in a file of 100 MB; then it becomes FILE.1, and a new one begins
_PATIENCE_S = 1.0  # for the disk, at the end


def summed(rows: Rows, lost_before: float) -> dict[str, float]:
    """Sum up a stretch of time, before which so many events were lost; none without rows."""
    size = float(rows["size"].sum())
    return {
        "packages": len(rows),
        "size": size / max(len(rows), 1),
        "gamma": size / max(float((rows["size"] / rows["gamma"]).sum()), 1.0),
        "rate": float(rows["event_rate"].max(initial=0.0)),
        "latency": float(rows["latency_max_us"].max(initial=0.0)),
        "waiting": float(rows["all_pending"].max(initial=0)),
        "lost": lost(rows[-1]) - lost_before if len(rows) else 0.0,
    }


def lost(row: Any) -> float:
    """Count the events that were thinned away or lost before this row, the driver's marks too."""
    names = ("all_discarded", "all_stale", "all_overflow", "upstream_lost")
    return float(sum(row[name] for name in names))


def as_rows(log: Rows, latency_bound_us: float) -> Rows:
    """Return the rows of a log with more columns, which are 0 but for the bound."""
    rows = np.zeros(len(log), TELEMETRY_DTYPE)
    for name in log.dtype.names or ():
        rows[name] = log[name]
    rows["latency_bound_us"] = latency_bound_us
    return rows


class Log:
    """The log of a live pipeline, looked at on the consumer's thread between two packages."""

    def __init__(self, native: _core.LivePipeline) -> None:
        self._native = native
        self.watchers: list[Watcher] = []
        self.begin()

    def begin(self) -> None:
        """Begin with row 0, as the log does."""
        self._next, self._due_s = 0, 0.0
        self._ledger = dict.fromkeys(_ENDS, 0)

    def look(self, now: bool = False) -> None:
        """Give the rows since the look before to the watchers, if that was 250 ms ago."""
        if not self.watchers or (time.monotonic() < self._due_s and not now):
            return
        self._due_s = time.monotonic() + _EVERY_S
        if not len(log := self._native.rows(self._next)):
            return
        self._next = int(log["index"][-1]) + 1
        stats = self._native.stats()
        rows = as_rows(log, stats.latency_bound_us)
        share = np.arange(1, len(rows) + 1) / len(rows)
        for name in _ENDS:
            before, now_is = self._ledger[name], stats.ledger[name]
            rows[f"all_{name}"] = before + (now_is - before) * share
            rows["all_received"] += rows[f"all_{name}"]
            self._ledger[name] = now_is
        rows["upstream_lost"] = stats.upstream_marks + stats.upstream_packets
        for watch in tuple(self.watchers):
            watch(rows)


class TelemetryFile:
    """A thread that writes rows as CSV; what the disk is too slow for is lost, and counted."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = _checks.new_file("telemetry", path)
        _checks.ending("telemetry", self.path, (".csv",), "give a name that ends in .csv")
        self._written = self._failed = self._in_file = 0  # rows, of the thread
        self._dropped = 0
        self._queue: queue.Queue[Rows] = queue.Queue(_WAITING)
        self._closing = threading.Event()
        self._thread: threading.Thread | None = None
        self._error: OSError | None = None

    def __call__(self, rows: Rows) -> None:
        """Have them written; never wait."""
        if self._thread is None:
            self._closing.clear()
            self._thread = threading.Thread(target=self._write, name="asap telemetry", daemon=True)
            self._thread.start()
        rows["rows_lost"] = self.lost
        try:
            self._queue.put_nowait(rows)
        except queue.Full:
            self._dropped += len(rows)

    @property
    def lost(self) -> int:
        """Rows that are not in the file."""
        return self._dropped + self._failed

    def _write(self) -> None:
        is_over = False
        while not is_over:
            is_over = self._closing.wait(_WRITE_S)
            for rows in self._waiting():
                try:
                    self._append(rows)
                except OSError as error:
                    self._error = error
                    self._failed += len(rows)

    def _waiting(self) -> Iterator[Rows]:
        with suppress(queue.Empty):
            while True:
                yield self._queue.get_nowait()

    def _append(self, rows: Rows) -> None:
        if self._in_file + len(rows) > _MAX_ROWS:
            self.path.replace(f"{self.path}.1")
            self._in_file = 0
        lines = b"".join([(_LINE % row.item()).encode() for row in rows])
        with self.path.open("ab" if self._in_file else "wb") as file:
            file.write(lines if self._in_file else HEAD + lines)
        self._in_file += len(rows)
        self._written += len(rows)

    def stats(self) -> dict[str, Any]:
        """Sum up as one JSON object, in rows."""
        return {"path": str(self.path), "written": self._written, "lost": self.lost}

    def close(self) -> None:
        """Wait for the disk, 1 s at most; warn of what could not be written."""
        thread, self._thread = self._thread, None
        if thread is None:
            return
        self._closing.set()
        thread.join(_PATIENCE_S)
        if thread.is_alive():  # the disk is stalled: what waits is lost
            self._dropped += sum(map(len, self._waiting()))
        if self._error is not None:
            warnings.warn(
                f"{self.path}: {self._error.strerror}; telemetry lost {self.lost} rows",
                RuntimeWarning,
                stacklevel=4,
            )
            self._error = None
