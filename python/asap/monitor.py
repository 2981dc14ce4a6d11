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
from asap.experiment.telemetry import HEAD, TELEMETRY_DTYPE, Rows, lost
from asap.io.errors import library

__all__ = ["EVERY_S", "Screen", "Tail", "follow", "need_terminal", "newest", "shown"]

EVERY_S = 0.5
_SLOT_US = 500_000  # a column of the curves
_MOST_SLOTS = 400
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
_LARGEST = {"rate": "event_rate", "latency": "latency_max_us", "waiting": "all_pending"}
_FIGURES = ("packages", "size", "thinned", *_LARGEST)


class Screen:
    """What the rows of the last minutes say."""

    def __init__(self, title: str) -> None:
        self._title = title
        self._slots: deque[dict[str, float]] = deque(maxlen=_MOST_SLOTS)
        self._last: Any = None
        self._last_s = time.monotonic()

    def add(self, rows: Rows) -> None:
        """Take rows, for the next drawing."""
        if not len(rows):
            return
        slots = (rows["start_us"] // _SLOT_US).astype(np.int64)
        for slot in dict.fromkeys(slots.tolist()):
            self._add(slot, rows[slots == slot])
        self._last, self._last_s = rows[-1], time.monotonic()

    def _add(self, number: int, rows: Rows) -> None:
        slots = self._slots
        while not slots or slots[-1]["slot"] != number:
            new = dict.fromkeys(_FIGURES, 0.0) | {"slot": number}
            if slots and 0 < number - slots[-1]["slot"] < _MOST_SLOTS:  # silence has columns too
                new["slot"] = slots[-1]["slot"] + 1
            new["lost"] = new["before"] = slots[-1]["lost"] if slots else lost(rows[0])
            slots.append(new)
        slot = slots[-1]
        slot["packages"] += len(rows)
        slot["size"] += float(rows["size"].sum())
        slot["thinned"] += float((rows["size"] / rows["gamma"]).sum())
        for name, column in _LARGEST.items():
            slot[name] = max(slot[name], float(rows[column].max()))
        slot["lost"] = lost(rows[-1])

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
        if self._last is None:
            yield Text("\n  no package yet")
            return
        yield Text(f"{'newest right, a column is 0.5 s':>{width}}", "bright_black")
        slots = list(self._slots)[-max(width - _LEFT - 1, 1) :]
        for name, value, curve, top, colour, above in _panels(slots, self._last):
            left = [Text(f" {name}", "bold"), Text(f"  {value}")]
            for words, line in zip(left, _curve(curve, top), strict=True):
                words.pad_right(width - len(slots) - 1 - words.cell_len)
                reds = [figure > above for figure in curve]
                for is_red, bars in groupby(zip(reds, line, strict=True), itemgetter(0)):
                    words.append("".join(bar for _, bar in bars), "red" if is_red else colour)
                yield words
            yield Text()
        yield from _ledger(self._last, width)


def _panels(slots: list[dict[str, float]], last: Any) -> Iterator[tuple[Any, ...]]:
    """Name, words, curve, upper end of its scale, colour, and the value above which it is red."""
    bound_us, per_s, none = float(last["latency_bound_us"]), 1e6 / _SLOT_US, float("inf")
    full = slots[-2:][0]  # the newest is not over yet
    rate = [slot["rate"] for slot in slots]
    yield "event rate", _units.rate(full["rate"]), rate, max(rate), "cyan", none
    size = [slot["size"] / max(slot["packages"], 1) for slot in slots]
    count = full["packages"]
    words = f"{full['size'] / max(count, 1):,.0f} ev x {count * per_s:,.0f}/s"
    yield "package size", words, size, max(size), "cyan", none
    gamma = [slot["size"] / slot["thinned"] if slot["thinned"] else 0.0 for slot in slots]
    yield "gamma", _units.share(gamma[-1]), gamma, 1.0, "yellow", none
    late = [slot["latency"] for slot in slots]
    words = f"{_units.duration(full['latency'])} of {_units.duration(bound_us)}"
    yield "latency, worst", words, late, max(bound_us, *late), "green", bound_us
    waiting = [slot["waiting"] for slot in slots]
    words = f"{full['waiting']:,.0f} events"
    yield "waiting in the ring", words, waiting, max(waiting), "blue", none
    gone = [slot["lost"] - slot["before"] for slot in slots]
    words = _units.rate((full["lost"] - full["before"]) * per_s)
    yield "lost", words, gone, max(gone), "red", none


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
