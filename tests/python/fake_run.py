"""A stand-in for asap.Run that needs no extension: a fluid model of one package after another."""

from __future__ import annotations

import json
from types import SimpleNamespace

import numpy as np

from asap.results import text as text_of

PACKAGES_DTYPE = np.dtype(
    [
        ("index", "<i8"),
        ("start_us", "<f8"),
        ("processing_us", "<f8"),
        ("t_first", "<i8"),
        ("t_last", "<i8"),
        ("offered", "<i8"),
        ("size", "<i8"),
        ("gamma", "<f8"),
        ("event_rate", "<f8"),
        ("rate", "<f8"),
        ("margin_us", "<f8"),
        ("latency_max_us", "<f8"),
        ("stale", "<i8"),
        ("overflow", "<i8"),
    ]
)


class FakeLedger(dict):
    """Counts by name, as keys and as attributes."""

    __getattr__ = dict.__getitem__

    @property
    def balanced(self):
        return self["received"] == sum(self.values()) - self["received"]


class FakeLatency:
    def __init__(self, values_us):
        self._values_us = values_us
        self.count = values_us.size
        self.mean = float(values_us.mean()) if values_us.size else 0.0
        self.max = float(values_us.max()) if values_us.size else 0.0

    def quantile(self, q):
        return float(np.quantile(self._values_us, q)) if self.count else 0.0


class FakeRun:
    without_log = False

    def __init__(self, packages, ledger, *, bound_us, scheme, source, mode, speed):
        self.packages = packages
        self.ledger = ledger
        self.mode = mode
        self.speed = speed
        self.rejected = {"nonmonotonic": ledger.rejected, "out_of_bounds": 0}
        self.latency_bound_us = bound_us
        self.scheme = scheme
        self.algorithm = SimpleNamespace(name="linear_cost", parameters={"alpha_us": 100.0})
        self.latency = FakeLatency(packages["latency_max_us"])
        self.lateness = FakeLatency(np.array([60.0, 230.0])) if mode == "real" else None
        self.learned = None
        self.opaque = True
        self.gap_us = 1200
        received = ledger.received
        in_time = packages["size"][packages["latency_max_us"] <= bound_us].sum()
        self.kept = ledger.delivered / received if received else 1.0
        self.in_time = float(in_time / received) if received else 1.0
        self._source = source

    def __str__(self):
        return text_of.format_run(self)

    def summary(self):
        rows = self.packages
        span_s = float(rows["t_last"][-1] - rows["t_first"][0]) / 1e6 if rows.size else 0.0
        latency = self.latency
        return {
            "schema_version": 1,
            "mode": self.mode,
            "source": {
                "path": self._source,
                "format": "npy",
                "width": 346,
                "height": 260,
                "events": self.ledger.received,
                "duration_s": span_s,
            },
            "scheme": {"name": self.scheme.name, **self.scheme.parameters},
            "algorithm": {"name": self.algorithm.name, **self.algorithm.parameters},
            "latency_bound_us": self.latency_bound_us,
            "speed": self.speed,
            "ledger": dict(self.ledger),
            "rejected": dict(self.rejected),
            "kept": self.kept,
            "in_time": self.in_time,
            "latency_us": {
                "mean": latency.mean,
                "p50": latency.quantile(0.5),
                "p99": latency.quantile(0.99),
                "max": latency.max,
            },
            "packages": {
                "count": int(rows.size),
                "per_s": rows.size / span_s if span_s else 0.0,
                "size_mean": float(rows["size"].mean()) if rows.size else 0.0,
                "size_max": int(rows["size"].max()) if rows.size else 0,
            },
            "gamma": {
                "mean": float(rows["gamma"].mean()) if rows.size else 1.0,
                "min": float(rows["gamma"].min()) if rows.size else 1.0,
            },
            "gap_us": self.gap_us,
            "cpu": 0.9,
            "pacing_us": self.lateness and {"p99": self.lateness.max, "max": self.lateness.max},
            "version": "0.0",
        }

    def save(self, path):
        path.write_text(json.dumps(self.summary()))

    def report(self, path):
        path.write_text("<!doctype html>")


def fake_run(
    *,
    rates=(0.1e6, 14e6),
    duration_s=5.0,
    alpha_us=100.0,
    beta_ns=150.0,
    bound_us=10_000.0,
    rate_bound=5e6,
    t0_us=1_600_000_000_000_000,
    seed=0,
    rejected=0,
    stale=0,
    overflow=0,
    pending=0,
    source="abrupt.npy",
    mode="virtual",
    speed=1.0,
):
    """A rate that grows from rates[0] to rates[1], taken greedily, thinned to ``rate_bound``."""
    rng = np.random.default_rng(seed)
    rows = []
    start_us, previous_us = 500.0, 0.0
    while start_us < duration_s * 1e6:
        progress = start_us / (duration_s * 1e6)
        rate_hz = rates[0] * (rates[1] / rates[0]) ** progress * rng.lognormal(0, 0.05)
        interval_us = max(start_us - previous_us, 2.0)
        offered = max(1, round(rate_hz * interval_us / 1e6))
        gamma = min(1.0, rate_bound / rate_hz) if rate_bound else 1.0
        size = max(1, round(gamma * offered))
        processing_us = alpha_us + beta_ns * size / 1e3
        rows.append(
            (
                len(rows),
                t0_us + start_us,
                processing_us,
                t0_us + int(previous_us),
                t0_us + int(start_us) - 1,
                offered,
                size,
                size / offered,
                offered / interval_us * 1e6,
                size / interval_us * 1e6,
                processing_us - interval_us,
                interval_us + processing_us,
                0,
                0,
            )
        )
        previous_us, start_us = start_us, start_us + max(processing_us, 1e3 / 5)
    packages = np.array(rows, PACKAGES_DTYPE)
    if packages.size:
        packages["stale"][-1] = stale
        packages["overflow"][-1] = overflow
    offered, delivered = int(packages["offered"].sum()), int(packages["size"].sum())
    ledger = FakeLedger(
        received=offered + rejected + stale + overflow + pending,
        rejected=rejected,
        filtered=0,
        discarded=offered - delivered,
        stale=stale,
        overflow=overflow,
        delivered=delivered,
        pending=pending,
    )
    scheme = SimpleNamespace(name="asap2020", parameters={"rate_bound": rate_bound})
    if not rate_bound:
        scheme = SimpleNamespace(name="greedy", parameters={"efficiency": None})
    return FakeRun(
        packages,
        ledger,
        bound_us=bound_us,
        scheme=scheme,
        source=source,
        mode=mode,
        speed=speed,
    )


def empty_run():
    """A run that received nothing."""
    return fake_run(duration_s=0.0)
