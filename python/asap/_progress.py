"""Progress of a long verb, for a person at a terminal: a bar where tqdm is there, else lines."""

from __future__ import annotations

import importlib
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

OnProgress = Callable[[int, "int | None", Any], None]

_SECONDS_BETWEEN_LINES = 10.0


@contextmanager
def on_terminal() -> Iterator[OnProgress | None]:
    """Give a callback ``on_progress(done, total, stats)`` that writes to stderr.

    None when stderr is no terminal, or closed: logs and pipes stay clean.
    """
    if sys.stderr is None or not sys.stderr.isatty():
        yield None
        return
    try:
        tqdm = importlib.import_module("tqdm").tqdm
    except ImportError:
        yield _Lines()
        return
    # leave=False takes the bar away at the end, whatever the end is. No colours.
    with tqdm(file=sys.stderr, unit="ev", unit_scale=True, leave=False, delay=0.5) as bar:
        yield _Bar(bar)


class _Lines:
    """A line every ten seconds."""

    def __init__(self) -> None:
        self._last_s = time.monotonic()

    def __call__(self, done: int, total: int | None, stats: Any = None) -> None:
        now_s = time.monotonic()
        if now_s - self._last_s >= _SECONDS_BETWEEN_LINES:
            self._last_s = now_s
            of = f" of {total:,}" if total else ""
            print(f"asap: {done:,}{of} events", file=sys.stderr)


class _Bar:
    """A bar of tqdm."""

    def __init__(self, bar: Any) -> None:
        self._bar = bar

    def __call__(self, done: int, total: int | None, stats: Any = None) -> None:
        self._bar.total = total
        self._bar.update(done - self._bar.n)
