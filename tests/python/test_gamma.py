"""What an algorithm is told: weight = 1 / gamma counts what thinning has seen, in every run."""

from __future__ import annotations

import ctypes
import time

import numpy as np
import pytest

import asap
import streams


class Count:
    """The class of own_algorithm.md, without decay."""

    def __init__(self):
        self.total = 0.0
        self.gammas = []

    def set_gamma(self, gamma):
        self.gamma = gamma
        self.gammas.append(gamma)

    def process(self, events):
        self.total += len(events) / self.gamma


def odd_pixels(events):
    return events[events["x"] % 2 == 1]


SCHEMES = [
    *(asap.Deadline(latency_ms=10, prefer=kind) for kind in ("balanced", "events", "continuity")),
    asap.DeadBeat(latency_ms=10),
    asap.Asap2020(rate_bound=3e5),
    asap.Asap2022(),
    asap.FixedSize(size=300),
    asap.FixedTime(period_ms=2),
    asap.SingleEvent(),
    asap.Greedy(),
]


@pytest.mark.parametrize("before", [None, odd_pixels], ids=["", "filtered"])
@pytest.mark.parametrize("execution", ["whole", "anytime"])
@pytest.mark.parametrize("scheme", SCHEMES, ids=lambda scheme: f"{scheme.name}")
def test_the_weights_count_what_thinning_has_seen(scheme, execution, before):
    """Bursts at five rates, of which the lowest can be done and the highest cannot."""
    rng = np.random.default_rng(11)
    rates_hz = np.repeat(rng.permutation([1e5, 4e5, 1e6, 2e6, 4e6]), 2)
    parts = [streams.poisson(rate, 0.02, k, 20_000 * k) for k, rate in enumerate(rates_hz)]
    count = Count()
    run = asap.simulate(
        np.concatenate(parts),
        cost=asap.LinearCost(alpha_us=500, beta_ns=2000, noise=0.1),
        scheme=scheme,
        latency_ms=10,
        algorithm=count,
        execution=execution,
        before=before,
    )
    ledger = run.ledger
    seen = ledger.received - ledger.stale - ledger.overflow - ledger.filtered
    assert (ledger.filtered > 0) == (before is not None)
    assert count.total == pytest.approx(seen, rel=0.01)
    assert (ledger.discarded > 0) == (min(count.gammas) < 1)
    if execution == "whole":
        assert count.gammas == run.packages["gamma"].tolist()


class Parts:
    """An algorithm of another extension: it gets a package in parts."""

    class Consumer(ctypes.Structure):
        _fields_ = (("algorithm", ctypes.c_void_p), ("process", ctypes.c_void_p))

    CALL = ctypes.CFUNCTYPE(
        None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_double, ctypes.c_bool
    )

    def __init__(self):
        self.total = 0.0
        self.later = 0
        self._call = self.CALL(self._process)
        self._consumer = self.Consumer(None, ctypes.cast(self._call, ctypes.c_void_p))
        new = ctypes.pythonapi.PyCapsule_New
        new.restype = ctypes.py_object
        new.argtypes = (ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p)
        self._name = b"__asap_consumer__"
        self.__asap_consumer__ = new(ctypes.addressof(self._consumer), self._name, None)

    def _process(self, algorithm, events, size, gamma, continues):
        self.total += size / gamma
        self.later += continues
        end = time.perf_counter() + 10e-6 * size
        while time.perf_counter() < end:
            pass

    def process(self, events):
        raise AssertionError("it is native")


def test_each_part_of_a_package_has_its_own():
    parts = Parts()
    scheme = asap.Deadline(latency_ms=20, prefer="continuity")
    run = asap.run(streams.poisson(3e5, 0.3), algorithm=parts, scheme=scheme)
    ledger = run.ledger
    assert parts.later > 0 and ledger.discarded > 0
    assert parts.total == pytest.approx(
        ledger.received - ledger.stale - ledger.overflow, rel=0.01, abs=100
    )
