"""A run by formula: a fluid model of one package after another, without events."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

import asap
from asap._core import PACKAGE_DTYPE
from asap.results import Ledger, Named


class Latencies:
    """What a LatencyHistogram says, of these values."""

    def __init__(self, values_us, sizes=None, bound_us=0.0):
        self._values_us = values_us
        self.count = values_us.size
        self.mean = float(values_us.mean()) if values_us.size else 0.0
        self.max = float(values_us.max()) if values_us.size else 0.0
        self.within_bound = 0 if sizes is None else int(sizes[values_us <= bound_us].sum())

    def quantile(self, q):
        return float(np.quantile(self._values_us, q)) if self.count else 0.0


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
    filtered=0,
    stale=0,
    overflow=0,
    pending=0,
    source="abrupt.npy",
    mode="virtual",
    speed=1.0,
    lateness_us=(60.0, 230.0),
    **others,
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
            {
                "index": len(rows),
                "start_us": t0_us + start_us,
                "processing_us": processing_us,
                "t_first": t0_us + int(previous_us),
                "t_last": t0_us + int(start_us) - 1,
                "offered": offered,
                "size": size,
                "gamma": size / offered,
                "event_rate": offered / interval_us * 1e6,
                "rate": size / interval_us * 1e6,
                "margin_us": processing_us - interval_us,
                "latency_max_us": interval_us + processing_us,
                "stale": 0,
                "overflow": 0,
            }
        )
        previous_us, start_us = start_us, start_us + max(processing_us, 1e3 / 5)
    packages = np.zeros(len(rows), PACKAGE_DTYPE)
    for name in PACKAGE_DTYPE.names:
        packages[name] = [row[name] for row in rows]
    if packages.size:
        packages["stale"][-1], packages["overflow"][-1] = stale, overflow
    offered, delivered = int(packages["offered"].sum()), int(packages["size"].sum())
    received = offered + rejected + filtered + stale + overflow + pending
    scheme = Named("asap2020", {"rate_bound": rate_bound})
    return asap.Run(
        packages=packages,
        ledger=Ledger(
            received=received,
            rejected=rejected,
            filtered=filtered,
            discarded=offered - delivered,
            stale=stale,
            overflow=overflow,
            delivered=delivered,
            pending=pending,
        ),
        latency=Latencies(packages["latency_max_us"], packages["size"], bound_us),
        lateness=Latencies(np.array(lateness_us)) if mode == "real" else None,
        rejected={"nonmonotonic": rejected, "out_of_bounds": 0},
        scheme=scheme if rate_bound else Named("greedy", {"efficiency": None}),
        algorithm=SimpleNamespace(name="linear_cost", parameters={"alpha_us": alpha_us}),
        mode=mode,
        latency_bound_us=bound_us,
        source={
            "path": source,
            "format": "npy",
            "width": 346,
            "height": 260,
            "events": received,
            "duration_s": duration_s,
        },
        speed=speed,
        gap_us=1200,
        **{"execution": "whole", **others},
    )


def empty_run():
    """A run that received nothing."""
    return fake_run(duration_s=0.0)
