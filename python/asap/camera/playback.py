"""A process that plays events into a pipe, and the device at the other end of it.

The events go in by the child's standard input; that it closes is the sign to begin. Packets come
out by its standard output, a header and the events. The end of either side ends the other one.
"""

from __future__ import annotations

import fcntl
import io
import os
import queue
import select
import shutil
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Iterable
from contextlib import suppress
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np

from asap._process import begun
from asap.events import EVENT_DTYPE, Events
from asap.io.errors import NoGoodEvent

_HEAD = struct.Struct("<dQQQ?")  # came, s of the wall clock; events, backlog, dropped; after a loss
_RING = 1000  # packets
_WAIT_S = 0.1
_PIPE_BYTES = 1 << 20


class Playback:
    """What an open device of neuromorphic-drivers is: iterate for (status, packet).

    Parameters
    ----------
    chunks
        Events from time 0 on; their timestamps never go back.
    how
        Speed, loop, drop and packet_us of `asap.SoftwareCamera`.
    """

    def __init__(self, chunks: Iterable[Events], size: tuple[int, int], *how: Any) -> None:
        self.properties = lambda: SimpleNamespace(width=size[0], height=size[1])
        self.process = begun(play, *how, stdout=subprocess.PIPE, bufsize=0)
        pipes: tuple[Any, Any] = self.process.stdin, self.process.stdout
        self._in, self._out = pipes
        self._poll = select.poll()
        self._poll.register(self._out.fileno(), select.POLLIN)
        with suppress(OSError, AttributeError):  # as far as the system allows
            fcntl.fcntl(self._out.fileno(), fcntl.F_SETPIPE_SZ, _PIPE_BYTES)
        self._bytes = bytearray()  # what has come and was not returned yet
        self._from_s = 0.0  # of the wall clock
        try:
            self._write(chunks)
        except BaseException:
            self.close()
            raise

    def _write(self, chunks: Iterable[Events]) -> None:
        count = 0
        for events in chunks:
            count += len(events)
            rest = events.view(np.uint8).data
            try:
                while rest:
                    rest = rest[self._in.write(rest) :]
            except BrokenPipeError as error:
                raise self._ended() from error
        if not count:
            raise NoGoodEvent("source: holds no events; give some to play")

    def name(self) -> str:
        """Return what stands for the driver's."""
        return "SoftwareCamera"

    def serial(self) -> str:
        """Return what tells it from another one."""
        return str(self.process.pid)

    def backlog(self) -> int:
        """Return whether something waits."""
        return int(self._in.closed and bool(self._poll.poll(0)))

    def clear_backlog(self, until: int) -> None:
        """Throw away what came before now, wherever it waits."""
        self._from_s = time.time()

    def close(self) -> None:
        """End the process."""
        self.process.kill()
        self.process.wait()
        self._in.close()
        self._out.close()

    def __iter__(self) -> Playback:
        return self

    def __next__(self) -> tuple[Any, Any]:
        """Return what waits, or what comes within .1 s; if nothing, a status without a ring."""
        self._in.close()
        if self._poll.poll(_WAIT_S * 1e3):
            came = os.read(self._out.fileno(), _PIPE_BYTES)
            if not came and not self._bytes and self.process.wait() == 0:
                raise StopIteration
            if not came:
                raise self._ended()
            self._bytes += came
        heads, pieces, begin = [], [], 0
        while len(self._bytes) >= (at := begin + _HEAD.size):
            head = _HEAD.unpack_from(self._bytes, begin)
            if len(self._bytes) < (end := at + head[1] * EVENT_DTYPE.itemsize):
                break
            if head[0] >= self._from_s:
                heads.append(head)
                pieces.append(self._bytes[at:end])
            begin = end
        del self._bytes[:begin]
        status = SimpleNamespace(system_time=time.time(), ring=None)
        if not heads:
            return status, None
        came_s, counts, backlog, dropped, after_loss = zip(*heads, strict=True)
        status.ring = SimpleNamespace(
            system_time=came_s[0], backlog=backlog[-1], dropped_packets=dropped[-1]
        )
        marks = (np.cumsum(counts) - counts)[np.array(after_loss)]
        return status, SimpleNamespace(
            polarity_events=np.frombuffer(bytearray().join(pieces), EVENT_DTYPE),
            polarity_events_overflow_indices=marks if len(marks) else None,
        )

    def _ended(self) -> RuntimeError:
        return RuntimeError(f"its process has ended ({self.process.wait()})")


def play(speed: float, loop: bool, drop: float, packet_us: int) -> None:
    """Play what comes in, as a camera would; when `_RING` packets wait, the newest are lost."""
    memory = io.BytesIO()
    shutil.copyfileobj(sys.stdin.buffer, memory)
    count = memory.tell() // EVENT_DTYPE.itemsize
    if not count:
        return  # the other side was killed
    waiting: queue.Queue[bytes] = queue.Queue()
    sender = threading.Thread(target=_send, args=(waiting,), daemon=True)
    sender.start()
    events: Events = np.frombuffer(memory.getbuffer(), EVENT_DTYPE, count)
    t = events["t"]
    t[:] = np.rint(t / speed)
    slots = t // packet_us
    ends = np.append(np.flatnonzero(np.diff(slots)) + 1, len(t)).tolist()
    turn_us = (int(slots[-1]) + 1) * packet_us
    random, dropped, after_loss = np.random.default_rng(0), 0, False
    start_s = time.monotonic()

    def put(piece: Events) -> None:
        head = _HEAD.pack(time.time(), len(piece), waiting.qsize(), dropped, after_loss)
        waiting.put(head + piece.tobytes())

    while True:
        for begin, end in pairwise([0, *ends]):
            due_s = start_s + (int(slots[begin]) + 1) * packet_us * 1e-6  # its last event is there
            if select.select([1], [], [], max(due_s - time.monotonic(), 0))[0]:
                os._exit(0)  # the other side has closed the pipe
            is_lost = waiting.qsize() >= _RING or random.random() < drop
            if is_lost:
                dropped += 1
            else:
                put(events[begin:end])
            after_loss = is_lost
        if not loop:
            break
        t += turn_us
        start_s += turn_us * 1e-6
    if after_loss:  # nothing else tells it
        put(events[:0])
    waiting.put(b"")
    sender.join()


def _send(waiting: queue.Queue[bytes]) -> None:
    """Write until the other side of the pipe has gone, or the last, empty packet."""
    with suppress(BrokenPipeError):
        while packet := waiting.get():
            sys.stdout.buffer.write(packet)
            sys.stdout.buffer.flush()
    os._exit(0)
