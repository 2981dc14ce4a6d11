"""What another thread gets done while a native call works."""

import threading
from collections.abc import Callable


def turns_meanwhile(call: Callable[[], object]) -> int:
    """Count in this thread while another one calls: once at most if the call holds the GIL."""
    done = threading.Event()

    def work() -> None:
        call()
        done.set()

    worker = threading.Thread(target=work)
    worker.start()
    turns = 0
    while not done.wait(0.001):
        turns += 1
    worker.join()
    return turns
