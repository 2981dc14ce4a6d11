"""A process that plays events into a pipe, and the device at the other end of it.

The events go in by the child's standard input; that it closes is the sign to begin. Packets come
out by its standard output, a header and the events. The end of either side ends the other one.
"""

from __future__ import annotations

import fcntl
import io
import os
import select
import shutil
import struct
import subprocess
import sys
import time
from collections import deque
from collections.abc import Iterable
from contextlib import suppress
from types import SimpleNamespace
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from asap._checks import named
from asap.events import EVENT_DTYPE, Events

_HEAD = struct.Struct("<dQQQ?")  # came, s of the wall clock; events, backlog, dropped; after a loss
_RING = 1000  # packets
_MERGED = 64  # packets at once
_WAIT_S = 0.1
_PIPE_BYTES = 1 << 20


class Playback:
    """What an open device of neuromorphic-drivers is: iterate for (status, packet).

    Parameters
    ----------
    chunks
        Events whose stamps never go back.
    how
        Speed, loop, drop and packet_us of `asap.SoftwareCamera`.
    """

    def __init__(self, chunks: Iterable[Events], size: tuple[int, int], *how: Any) -> None:
        self.properties = lambda: SimpleNamespace(width=size[0], height=size[1])
        code = f"import sys; sys.path[:] = {sys.path!r}; from asap import _playback"
        self.process = subprocess.Popen(
            [sys.executable, "-c", f"{code}; _playback.play{how!r}"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            bufsize=0,
            start_new_session=True,  # Ctrl-C is for the user's process alone
        )
        pipes: tuple[Any, Any] = self.process.stdin, self.process.stdout
        self._in, self._out = pipes
        self._rest = memoryview(b"")
        self._poll = select.poll()
        self._poll.register(self._out.fileno(), select.POLLIN)
        with suppress(OSError, AttributeError):  # as far as the system allows
            fcntl.fcntl(self._out.fileno(), fcntl.F_SETPIPE_SZ, _PIPE_BYTES)
        self._expect_head()
        try:
            self._write(chunks)
        except BaseException:
            self.close()
            raise

    def _write(self, chunks: Iterable[Events]) -> None:
        count, last_us = 0, -(2**63)
        for events in chunks:
            t = events["t"]
            back = np.append(t[0] < last_us, t[1:] < t[:-1])
            if back.any():
                number = int(back.argmax())
                remedy = f"goes back (event {count + number}); sort the events by time"
                raise ValueError(named("t", int(t[number]), remedy))
            count, last_us = count + len(events), int(events["t"][-1])
            rest = events.view(np.uint8).data
            try:
                while rest:
                    rest = rest[self._in.write(rest) :]
            except BrokenPipeError:
                self._end()
        if not count:
            raise ValueError("source: holds no events; give some to play")

    def name(self) -> str:
        return "SoftwareCamera"

    def serial(self) -> str:
        return str(self.process.pid)

    def backlog(self) -> int:
        """Return whether something waits."""
        return int(self._in.closed and bool(self._poll.poll(0)))

    def clear_backlog(self, until: int) -> None:
        """Throw away what waits."""
        for _ in range(_RING):
            if self.backlog() <= until or next(self, None) is None:
                return

    def close(self) -> None:
        """End the process."""
        self.process.kill()
        self.process.wait()
        self._in.close()
        self._out.close()

    def __iter__(self) -> Playback:
        return self

    def __next__(self) -> tuple[Any, Any]:
        """Return what waits, or what comes within .1 s; after that a status without a ring."""
        self._in.close()
        pieces: list[Events] = []
        marks: list[int] = []
        count, came_s = 0, 0.0
        while len(pieces) < _MERGED and self._poll.poll(0 if pieces else _WAIT_S * 1e3):
            taken = os.readv(self._out.fileno(), [self._rest])
            if taken == 0:
                if pieces:
                    break  # what came before first; the next call comes here again
                self._end()
            self._rest = self._rest[taken:]
            if not self._rest and self._events is None:
                self._expect_events()
            if self._rest or self._events is None:
                continue
            wall_s, _, backlog, dropped, after_loss = self._head
            came_s = came_s or wall_s
            marks += [count] * after_loss
            pieces.append(self._events)
            count += len(self._events)
            self._expect_head()
        if not pieces:
            return SimpleNamespace(system_time=time.time(), ring=None), None
        events = pieces[0] if len(pieces) == 1 else np.concatenate(pieces)
        ring = SimpleNamespace(
            system_time=came_s,
            backlog=backlog,
            raw_packets=len(pieces),
            dropped_packets=dropped,
        )
        packet = SimpleNamespace(
            polarity_events=events,
            polarity_events_overflow_indices=np.array(marks) if marks else None,
        )
        return SimpleNamespace(system_time=time.time(), ring=ring), packet

    def _expect_head(self) -> None:
        self._events: Events | None = None
        self._bytes = bytearray(_HEAD.size)
        self._rest = memoryview(self._bytes)

    def _expect_events(self) -> None:
        self._head = _HEAD.unpack(self._bytes)
        self._events = np.empty(self._head[1], EVENT_DTYPE)
        self._rest = self._events.view(np.uint8).data

    def _end(self) -> NoReturn:
        code = self.process.wait()
        if code == 0 and self._events is None and len(self._rest) == _HEAD.size:
            raise StopIteration
        raise RuntimeError(f"its process has ended ({code})")


def play(speed: float, loop: bool, drop: float, packet_us: int) -> None:
    """Play what comes in, as a camera would; when `_RING` packets wait, the newest are lost."""
    with suppress(BrokenPipeError):  # the other side has gone
        memory = io.BytesIO()
        shutil.copyfileobj(sys.stdin.buffer, memory)
        _play(np.frombuffer(memory.getbuffer(), EVENT_DTYPE), speed, loop, drop, packet_us)
    os._exit(0)


def _play(events: Events, speed: float, loop: bool, drop: float, packet_us: int) -> None:
    t: npt.NDArray[np.int64] = events["t"]
    t -= t[0].copy()
    if speed != 1:
        t[:] = np.rint(t / speed)
    slots = t // packet_us
    ends = np.append(np.flatnonzero(np.diff(slots)) + 1, len(t))
    turn_us = (int(slots[-1]) + 1) * packet_us
    random, out = np.random.default_rng(0), _Out()
    dropped, after_loss, start_s = 0, False, time.monotonic()
    while True:
        begin = 0
        for end in ends.tolist():
            piece, begin = events[begin:end], end
            due_s = (
                start_s + (int(slots[end - 1]) + 1) * packet_us * 1e-6
            )  # its last event is there
            while (left_s := due_s - time.monotonic()) > 0:
                out.send(left_s)
            if out.waiting() >= _RING or random.random() < drop:
                dropped, after_loss = dropped + 1, True
                continue
            head = _HEAD.pack(time.time(), len(piece), out.waiting(), dropped, after_loss)
            out.put(head, piece.tobytes())
            out.send(0)
            after_loss = False
        if not loop:
            break
        t += turn_us
        start_s += turn_us * 1e-6
    if after_loss:  # nothing else tells it
        out.put(_HEAD.pack(time.time(), 0, out.waiting(), dropped, True), b"")
    while out.waiting():
        out.send(_WAIT_S)


class _Out:
    """Packets on their way into the standard output."""

    def __init__(self) -> None:
        os.set_blocking(1, False)
        self._queue: deque[memoryview] = deque()
        self._gone = select.poll()
        self._gone.register(1, 0)  # the other side has closed: an error, whatever is asked for

    def waiting(self) -> int:
        return (len(self._queue) + 1) // 2

    def put(self, *parts: bytes) -> None:
        self._queue.extend(map(memoryview, parts))

    def send(self, wait_s: float) -> None:
        """Write what the pipe takes within that time, .1 s at most."""
        if self._gone.poll(0):
            raise BrokenPipeError
        wanted = [1] if self._queue else []
        if select.select([], wanted, [], min(wait_s, _WAIT_S))[1]:
            self._queue[0] = self._queue[0][os.write(1, self._queue[0]) :]
            if not self._queue[0]:
                self._queue.popleft()
