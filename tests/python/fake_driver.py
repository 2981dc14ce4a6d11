"""A module with the interface of neuromorphic_drivers: what it raises, what it hands out."""

from __future__ import annotations

import time
from enum import Enum
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np

SERIAL = "00050421"
EVENT = np.dtype([("t", "<u8"), ("x", "<u2"), ("y", "<u2"), ("on", "?")])
PACKET = 1000  # events, us


class Name(Enum):
    PROPHESEE_EVK4 = "Prophesee EVK4"


class Connection(Enum):
    USB_3 = "USB 3.0"


class Driver(ModuleType):
    """One camera is attached, unless `fault` says what the driver raises.

    `script` is what the camera does, packet by packet: "events", "silence", "frames", "loss",
    "merged" (of 20, with the time of the first), "wild" (a stamp beyond 63 bits, a count of losses
    that goes back), or the words of an error; when it is over the camera is silent.
    """

    def __init__(self, script: tuple[str, ...] = (), fault: str | None = None) -> None:
        super().__init__("neuromorphic_drivers")
        self.script, self.fault = script, fault
        self.size = SimpleNamespace(width=1280, height=720)
        self.opened: list[Device] = []
        self.given: dict[str, Any] = {}

    def list_devices(self) -> list[Any]:
        if self.fault:
            raise RuntimeError(self.fault)
        device = {"name": Name.PROPHESEE_EVK4, "connection": Connection.USB_3, "address": "1:2"}
        return [SimpleNamespace(**device, serial=SERIAL, error=None)]

    def open(self, *, serial: str | None = None, **given: Any) -> Device:
        self.given = given
        if self.fault:
            raise RuntimeError(self.fault)
        if serial not in (None, SERIAL):
            raise RuntimeError(f'serial "{serial}" not found')
        self.opened.append(Device(self))
        return self.opened[-1]


class Device:
    def __init__(self, driver: Driver) -> None:
        self._driver, self._left = driver, list(driver.script)
        self._t, self._dropped = 0, 0
        self.made, self.is_open, self.waiting = 0, True, 0

    def name(self) -> Name:
        return Name.PROPHESEE_EVK4

    def serial(self) -> str:
        return SERIAL

    def properties(self) -> Any:
        return self._driver.size

    def backlog(self) -> int:
        return self.waiting

    def clear_backlog(self, until: int) -> None:
        del self._left[: self.waiting - until]
        self.waiting = until

    def close(self) -> None:
        self.is_open = False

    def __iter__(self) -> Device:
        return self

    def __next__(self) -> tuple[Any, Any]:
        assert self.is_open
        step = self._left.pop(0) if self._left else "silence"
        if step == "silence":
            time.sleep(self._driver.given["iterator_timeout"])
            return SimpleNamespace(system_time=time.time(), ring=None), None
        if step not in ("events", "loss", "frames", "merged", "wild"):
            raise RuntimeError(step)
        self._dropped += 3 * (step == "loss")  # the driver counts from the opening on
        events = None if step == "frames" else self._events()
        if step == "merged":
            events = np.concatenate([events, *(self._events() for _ in range(19))])
        if step == "wild":
            events["t"][500], self._dropped = 2**63, -2
        ring = SimpleNamespace(
            system_time=time.time() - (0.02 if step == "merged" else 0.005),
            backlog=len(self._left),
            dropped_packets=self._dropped,
        )
        packet = SimpleNamespace(
            polarity_events=events,
            polarity_events_overflow_indices=np.array([0]) if step == "loss" else None,
        )
        return SimpleNamespace(system_time=time.time(), ring=ring), packet

    def _events(self) -> Any:
        events = np.zeros(PACKET, EVENT)
        events["t"] = self._t + np.arange(PACKET)
        events["x"] = 7
        self._t += PACKET
        self.made += PACKET
        return events
