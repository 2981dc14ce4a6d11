"""The panels of a live run as one screen of text, for a terminal over ssh too.

The process of `viewer` shows a run, ``asap monitor`` the file of ``Pipeline(telemetry=...)``.
Needs rich: ``asap-events[monitor]``.
"""

from __future__ import annotations

import io
import os
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from itertools import groupby
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np

from asap import _checks, _units
from asap.experiment.telemetry import HEAD, TELEMETRY_DTYPE, Rows, lost, summed
from asap.io.errors import library

__all__ = ["EVERY_S", "Screen", "Tail", "follow", "need_terminal", "newest", "shown"]

EVERY_S = 0.5
_SLOT_US = 500_000  # a column of the curves
_MAX_SLOTS = 400
_SILENT_S = 2.0
_TAIL = 1 << 20  # bytes of a file that are read at the beginning
_LEFT = 31  # columns for the words
_HIGH = 2  # lines of a curve
_BARS = " ▁▂▃▄▅▆▇█"
_ENDS = {  # where events end, and the colour
    "delivered": "green",
    "discarded": "yellow",
    "filtered": "blue",
    "stale": "magenta",
    "overflow": "red",
    "rejected": "bright_black",
}


class Screen:
    """What the rows of the last minutes say."""

    def __init__(self, title: str) -> None:
        self._title = title
        self._slots: deque[dict[str, float]] = deque(maxlen=_MAX_SLOTS)
        self._number, self._rows = 0, np.empty(0, TELEMETRY_DTYPE)  # of the newest slot
        self._lost = 0.0  # before it
        self._last_s = time.monotonic()

    def add(self, rows: Rows) -> None:
        """Take rows, for the next drawing."""
        numbers = (rows["start_us"] // _SLOT_US).astype(np.int64)
        for part in np.split(rows, np.flatnonzero(np.diff(numbers)) + 1) if len(rows) else ():
            self._add(int(part["start_us"][0] // _SLOT_US), part)
            self._last_s = time.monotonic()

    def _add(self, number: int, rows: Rows) -> None:
        if self._slots and number == self._number:
            self._slots.pop()
            rows = np.concatenate([self._rows, rows])
        else:
            silent = number - self._number - 1 if self._slots else 0
            self._slots.extend([summed(rows[:0], 0.0)] * min(silent, _MAX_SLOTS))
            self._lost = lost(self._rows[-1] if self._slots else rows[0])
        self._number, self._rows = number, rows
        self._slots.append(summed(rows, self._lost))

    # ---- drawing

    def __rich_console__(self, console: Any, options: Any) -> Iterator[Any]:
        """Draw what there is, in lines of the terminal's width."""
        from rich.text import Text

        width = options.max_width
        silent_s = time.monotonic() - self._last_s
        state = f"silent for {silent_s:.0f} s" if silent_s > _SILENT_S else "running"
        head = Text(f" {self._title}", "bold reverse")
        head.append(f"{state} ".rjust(max(width - head.cell_len, 0)))
        head.truncate(width)
        yield head
        if not self._slots:
            yield Text("\n  no package yet")
            return
        yield Text(f"{'newest right, a column is 0.5 s':>{width}}", "bright_black")
        slots = list(self._slots)[-max(width - _LEFT - 1, 1) :]
        bound_us = float(self._rows["latency_bound_us"][-1])
        for title, name, value, least_top, colour in _panels(slots, bound_us):
            curve = [slot[name] for slot in slots]
            above = bound_us if name == "latency" else np.inf
            left = [Text(f" {title}", "bold"), Text(f"  {value}")]
            for words, line in zip(left, _curve(curve, max(least_top, *curve)), strict=True):
                words.pad_right(width - len(slots) - 1 - words.cell_len)
                reds = [figure > above for figure in curve]
                for is_red, bars in groupby(zip(reds, line, strict=True), itemgetter(0)):
                    words.append("".join(bar for _, bar in bars), "red" if is_red else colour)
                yield words
            yield Text()
        yield from _ledger(self._rows[-1], width)


def _panels(slots: list[dict[str, float]], bound_us: float) -> Iterator[tuple[Any, ...]]:
    """Title, figure, words, the least upper end of its scale, and colour."""
    per_s, full = 1e6 / _SLOT_US, slots[-2:][0]  # the newest is not over yet
    yield "event rate", "rate", _units.rate(full["rate"]), 0.0, "cyan"
    words = f"{full['size']:,.0f} ev x {full['packages'] * per_s:,.0f}/s"
    yield "package size", "size", words, 0.0, "cyan"
    yield "gamma", "gamma", _units.share(slots[-1]["gamma"]), 1.0, "yellow"
    words = f"{_units.duration(full['latency'])} of {_units.duration(bound_us)}"
    yield "latency, worst", "latency", words, bound_us, "green"
    yield "waiting in the ring", "waiting", f"{full['waiting']:,.0f} events", 0.0, "blue"
    yield "lost", "lost", _units.rate(full["lost"] * per_s), 0.0, "red"


def _curve(values: list[float], top: float) -> list[str]:
    """Draw bars in `_HIGH` lines; what is above 0 is seen."""
    eighths = np.array(values) / (top or 1.0) * 8 * _HIGH
    eighths = np.where(eighths > 0, np.maximum(np.rint(eighths), 1), 0).astype(int)
    lines = [np.clip(eighths - 8 * line, 0, 8) for line in reversed(range(_HIGH))]
    return ["".join(_BARS[bar] for bar in line) for line in lines]


def _ledger(last: Any, width: int) -> Iterator[Any]:
    """Draw where the events have gone, as one bar and in words."""
    from rich.text import Text

    counts = {name: int(last[f"all_{name}"]) for name in _ENDS}
    done = max(sum(counts.values()), 1)
    ends = np.rint(np.cumsum(list(counts.values())) / done * (width - 2)).astype(int)
    bar, words = Text(" "), Text(" ")
    for name, columns in zip(_ENDS, np.diff(ends, prepend=0), strict=True):
        bar.append("█" * int(columns), _ENDS[name])
        if counts[name]:
            words.append("■ ", _ENDS[name])
            words.append(f"{name} {_units.share(counts[name] / done)}   ")
    yield bar
    yield words
    told = {"driver lost": last["upstream_lost"], "rows not written": last["rows_lost"]}
    counted = "".join(f", {name} {_units.count(n)}" for name, n in told.items() if n)
    yield Text(f" {_units.count(last['all_received'])} events received{counted}", "bright_black")


# ---- where it is shown


def need_terminal() -> None:
    """Refuse what cannot be drawn on."""
    library("rich", "a monitor", "monitor")
    if sys.stderr is None or not sys.stderr.isatty():
        raise RuntimeError("monitor: stderr is no terminal; write a file with telemetry= instead")


@contextmanager
def shown(title: str) -> Iterator[Callable[..., None]]:
    """Take the whole terminal, and give what draws more rows on it."""
    from rich.console import Console
    from rich.live import Live

    screen = Screen(title)
    with Live(screen, console=Console(stderr=True), screen=True, auto_refresh=False) as live:

        def draw(rows: Rows, *_: Any) -> None:
            screen.add(rows)
            live.refresh()

        yield draw


def follow(path: Path) -> None:
    """Show the file that a pipeline writes, until Ctrl-C."""
    tail = Tail(path)
    rows = tail.read()
    need_terminal()
    with suppress(KeyboardInterrupt), shown(str(path)) as draw:
        draw(rows)
        while True:
            time.sleep(EVERY_S)
            with suppress(FileNotFoundError):  # it is being renamed
                draw(tail.read())


def newest(path: Path) -> dict[str, Any]:
    """Return the newest row of a file."""
    rows = Tail(path).read()
    return dict(zip(rows.dtype.names or (), rows[-1].tolist(), strict=True)) if len(rows) else {}


class Tail:
    """The rows that a pipeline appends to its file; those of the last minutes come first."""

    def __init__(self, path: Path) -> None:
        _checks.regular_file(path)
        self._path, self._at, self._file = path, 0, 0

    def read(self) -> Rows:
        """Return what was written since; of a file that began anew too."""
        with self._path.open("rb") as file:
            now = os.fstat(file.fileno())
            is_first = self._file == 0
            if now.st_ino != self._file or now.st_size < self._at:
                head = file.read(len(HEAD))
                if len(head) < len(HEAD) and HEAD.startswith(head):  # it is being made
                    return np.empty(0, TELEMETRY_DTYPE)
                if head != HEAD:
                    remedy = "holds no telemetry; give the file of Pipeline(telemetry=)"
                    raise ValueError(f"{self._path}: {remedy}")
                self._file, self._at = now.st_ino, len(HEAD)
            if is_first and now.st_size - _TAIL > self._at:
                file.seek(now.st_size - _TAIL)
                file.readline()
                self._at = file.tell()
            file.seek(self._at)
            text = file.read()
        end = text.rfind(b"\n") + 1  # a line may be half written
        self._at += end
        if not end:
            return np.empty(0, TELEMETRY_DTYPE)
        return np.loadtxt(io.BytesIO(text[:end]), TELEMETRY_DTYPE, delimiter=",", ndmin=1)
