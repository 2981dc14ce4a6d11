"""What the soak must reach: the goals R1 to R22, figure by figure."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Goal:
    """One figure of a part, with the most or least that is asked of it."""

    rule: str
    words: str
    unit: str = ""
    most: float | None = None
    least: float | None = None
    # Holds on any machine; else the figure depends on what else the machine does.
    exact: bool = False

    def reached(self, value: float) -> bool:
        return (self.most is None or value <= self.most) and (
            self.least is None or value >= self.least
        )

    @property
    def bound(self) -> str:
        if self.most is not None:
            return f"<= {self.most:g}" if self.most else "0"
        return f">= {self.least:g}" if self.least is not None else ""


PARTS: dict[str, dict[str, Goal]] = {
    "ledger": {
        "ledger_events": Goal("R1", "events through random pipelines"),
        "ledger_snapshots": Goal("R1", "snapshots while they ran"),
        "ledger_wrong": Goal("R1", "wrong in the end or meanwhile", most=0, exact=True),
        "ledger_delivered": Goal("R7", "of these, delivered"),
        "hot_path_allocations": Goal("R7", "allocations by push and loop", most=0, exact=True),
    },
    "steady": {
        "steady_events": Goal("R3", "events at 12 Mev/s, algorithm keeps up"),
        "steady_wrong": Goal("R3", "ledger wrong", most=0, exact=True),
        "steady_overflow": Goal("R3", "overflow", most=0),
        "steady_kept": Goal("R3", "kept"),
        "steady_cpu_percent": Goal("R3", "processor, algorithm left out", "% of a core", most=50),
        "steady_push_percent": Goal("R3", "of it, push", "% of a core"),
        "steady_p99_ms": Goal("R3", "latency p99, bound 10 ms", "ms"),
        "steady_max_ms": Goal("R3", "latency max", "ms"),
        "steady_longest_push_ms": Goal("R3", "longest push", "ms"),
        "steady_late_ms": Goal("R3", "latest packet of the camera's thread", "ms"),
        "memory_above_ring_mib": Goal("R6", "resident beyond ring", "MiB", most=8),
        "memory_after_stalls_mib": Goal("R6", "after ten stalls of 200 ms", "MiB", most=8),
        "memory_of_pipeline_mib": Goal("R6", "of it the pipeline's", "MiB", most=6, exact=True),
        "stalled_overflow": Goal("R4", "overflow in these stalls", most=0),
        "steady_memory_growth_mib": Goal("R6", "growth once warm", "MiB", most=1),
    },
    "overload": {
        "deadline_events": Goal("R4", "events at five times the capacity"),
        "deadline_wrong": Goal("R4", "ledger wrong", most=0, exact=True),
        "deadline_overflow": Goal("R4", "overflow after 1 s", most=0),
        "deadline_kept": Goal("R4", "kept"),
        "deadline_p99_of_bound": Goal("R4", "latency p99 / bound", most=1),
        "deadline_max_of_bound": Goal("R4", "latency max / bound", most=1.5),
        "deadline_alpha_us": Goal("R4", "fixed cost as learnt in the end, 100 in truth", "us"),
        "deadline_memory_growth_mib": Goal("R6", "growth once warm", "MiB", most=1),
        "thin_events": Goal("R4", "the same, FixedSize over a ring that thins"),
        "thin_wrong": Goal("R4", "ledger wrong", most=0, exact=True),
        "thin_overflow": Goal("R4", "overflow after 1 s", most=0),
        "thin_kept": Goal("R4", "kept"),
        "thin_p99_of_bound": Goal("R4", "latency p99 / longest for a full ring", most=1),
        "thin_max_of_bound": Goal("R4", "latency max / longest for a full ring", most=1),
        "thin_memory_growth_mib": Goal("R6", "growth once warm", "MiB", most=1),
    },
    "saturation": {
        f"saturation_{when_full}_{name}": goal
        for when_full in ("newest", "thin")
        for name, goal in {
            "events": Goal("R5", f"events at memory speed, when full: {when_full}"),
            "wrong": Goal("R5", "ledger wrong", most=0, exact=True),
            "mev_per_s": Goal("R5", "offered", "Mev/s", least=300),
            "mev_per_cpu_s": Goal("R5", "offered, by processor time", "Mev/s", least=300),
            "memory_growth_mib": Goal("R5", "growth once warm", "MiB", most=1),
        }.items()
    },
    "stops": {
        "stop_trials": Goal("R14", "stops from random states"),
        "stop_thrown": Goal("R13", "of these, by an exception"),
        "stop_wrong": Goal("R13", "wrong ledger, exception or restart", most=0, exact=True),
        "stop_threads_left": Goal("R14", "threads left", most=0, exact=True),
        "stop_longest_ms": Goal("R14", "longest stop", "ms", most=500),
    },
    "idle": {
        "idle_cpu_percent": Goal("R19", "processor while silent", "% of a core", most=2),
        "wake_ups": Goal("R19", "wake-ups after 5 ms of silence"),
        "wake_ups_lost": Goal("R19", "lost", most=0, exact=True),
        "wake_up_p50_us": Goal("R19", "wake-up p50", "us"),
        "wake_up_p99_us": Goal("R19", "wake-up p99", "us", most=1000),
        "wake_up_max_us": Goal("R19", "wake-up max", "us"),
    },
    "speed": {
        "end_to_end_ns": Goal("R22", "push to booked package, two threads", "ns/event", most=10),
        "end_to_end_half_ns": Goal("R22", "the same at gamma = 0.5", "ns/event", most=10),
        "pipeline_ns": Goal("R22", "live pipeline, one thread", "ns/event", most=10),
        "ring_of_boost": Goal("R22", "ring / boost spsc_queue, least of six", least=0.5),
    },
}

# The share of the time that a part gets; the benchmarks of "speed" take theirs on top.
SHARES = {
    "ledger": 0.2,
    "steady": 0.25,
    "overload": 0.2,
    "saturation": 0.1,
    "stops": 0.15,
    "idle": 0.1,
}
