"""A process of its own beside the user's, which calls one function of asap."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Callable
from typing import Any


def begun(function: Callable[..., object], *given: Any, **pipes: Any) -> subprocess.Popen[bytes]:
    """Begin a process that calls a function with what is given, with a pipe into it.

    Signals that end are for the user's process alone. A session of its own would do so too, but
    have a share of the processor for itself, within which alone a priority counts.
    """
    name, module = function.__name__, function.__module__
    code = f"import sys; sys.path[:] = {sys.path!r}; from {module} import {name}; {name}{given!r}"
    ends = {signal.SIGINT, signal.SIGTERM, signal.SIGHUP}
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, ends)
    try:
        return subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, **pipes)
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
