"""Scripts in Python processes of their own, for what would end or hang this one."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import time
from dataclasses import dataclass

LONG = bool(os.environ.get("ASAP_LONG_TESTS"))

# What a limit is worth on a machine that is busy with something else.
PATIENCE = 30

_HEAD = """
import os, signal, sys, threading, time, warnings
import numpy as np
import asap
warnings.filterwarnings("ignore", "packages of")  # on a busy machine they may be small
signal.signal(signal.SIGINT, signal.default_int_handler)  # a background job ignores it

def in_background(call, *arguments):
    threading.Thread(target=call, args=arguments, daemon=True).start()

def after(seconds, call, *arguments):
    def wait():
        time.sleep(seconds)
        call(*arguments)
    in_background(wait)

def camera(pipeline, count=1000):  # as fast as it goes
    events = np.zeros(count, asap.EVENT_DTYPE)
    try:
        while True:
            pipeline.push(events)
            events["t"] += 100
    except RuntimeError:
        pass

def fill(pipeline, count):
    events = np.zeros(count, asap.EVENT_DTYPE)
    events["t"] = np.arange(count)
    pipeline.push(events)
"""


@dataclass
class Ended:
    """A child's exit code, output, and how long after its last line it ended, s."""

    code: int
    lines: list[str]
    errors: str
    took_s: float


def run_script(body: str, *, before: str = "") -> Ended:
    """Run the script; its last line of output is a time.monotonic() if it wants to be timed."""
    script = before + _HEAD + textwrap.dedent(body)
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=300
    )
    ended = time.monotonic()
    lines = done.stdout.split("\n")[:-1]
    try:
        took = ended - float(lines[-1])
    except (IndexError, ValueError):
        took = 0.0
    return Ended(done.returncode, lines, done.stderr, took)


def send_when_ready(body: str, number: signal.Signals) -> int:
    """Send the script a signal once it has printed a line; its exit code."""
    script = _HEAD + textwrap.dedent(body)
    with subprocess.Popen(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, text=True
    ) as child:
        child.stdout.readline()
        child.send_signal(number)
        try:
            return child.wait(300)
        finally:
            child.kill()
