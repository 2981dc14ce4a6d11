"""The JSON object of a live pipeline's stats."""

from __future__ import annotations

from typing import Any

from asap import _core
from asap.results.data import SCHEMA_VERSION, Ledger, Named, latency_us


def state_of(stats: _core.PipelineStats) -> str:
    """Say "open", "stalled" (open, but the consumer stays away) or "stopped"."""
    if not stats.open:
        return "stopped"
    return "stalled" if stats.stalled else "open"


def summary(
    stats: _core.PipelineStats,
    *,
    scheme: _core.Scheme,
    algorithm: Any,
    width: int | None,
    height: int | None,
    pinned: int,
) -> dict[str, Any]:
    """Sum the run up; the keys are those of run.summary(), as far as they make sense."""
    ledger = Ledger.of(stats.ledger)
    latency, elapsed_s = stats.latency, stats.elapsed_s
    received = ledger["received"]
    return {
        "schema_version": SCHEMA_VERSION,
        "mode": "live",
        "state": state_of(stats),
        "open": stats.open,
        "source": {
            "path": None,
            "format": "live",
            "width": width,
            "height": height,
            "events": received,
            "duration_s": round(elapsed_s, 6),
        },
        "scheme": Named.of(scheme).as_json(),
        "algorithm": None if algorithm is None else Named.of(algorithm).as_json(),
        "latency_bound_us": stats.latency_bound_us,
        "ledger": dict(ledger),
        "rejected": stats.rejected,
        "clock_resets": stats.clock_resets,
        "upstream_lost": {"marks": stats.upstream_marks, "packets": stats.upstream_packets},
        "sensor_delay_us": {"last": stats.sensor_delay_us, "max": stats.sensor_delay_max_us},
        "most_waiting": stats.most_waiting,
        "pinned": pinned,
        "kept": ledger["delivered"] / received if received else 1.0,
        "in_time": latency.within_bound / received if received else 1.0,
        "latency_us": latency_us(latency),
        "gap_us": stats.gap_us,
        "packages": {
            "count": stats.packages,
            "per_s": stats.packages / elapsed_s if elapsed_s > 0 else 0.0,
            "size_mean": stats.size / stats.packages if stats.packages else 0.0,
            "size_max": stats.size_max,
        },
        "gamma": {
            "mean": stats.size / stats.thinned if stats.thinned else 1.0,
            "min": stats.gamma_min,
        },
        "cpu": stats.busy_s / elapsed_s if elapsed_s > 0 else 0.0,
        "version": _core.__version__,
    }
