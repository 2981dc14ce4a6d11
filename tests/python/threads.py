"""What another thread gets done while a native call works."""

import threading
from collections.abc import Callable
from typing import Any

ENOUGH = 10  # turns
TRIES = 20  # a busy machine may give this thread no turn during one call


def turns_meanwhile(call: Callable[..., object], *makes: Callable[[], object]) -> int:
    """Count in this thread while another one calls, at best: twice at most if it holds the GIL.

    What the call works on is made anew for each try.
    """
    most = 0
    for _ in range(TRIES):
        most = max(most, _turns_during(call, *(make() for make in makes)))
        if most >= ENOUGH:
            break
    return most


def _turns_during(call: Callable[..., object], *arguments: Any) -> int:
    begins, done = threading.Event(), threading.Event()

    def work() -> None:
        begins.set()
        try:
            call(*arguments)
        finally:
            done.set()

    worker = threading.Thread(target=work)
    worker.start()
    begins.wait()
    turns = 0
    while not done.wait(0.001):
        turns += 1
    worker.join()
    return turns
