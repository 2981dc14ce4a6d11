"""The figures of R22, from the benchmarks that the README cites."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path


def figures(build: Path) -> dict[str, float]:
    """What the benchmarks measure, the best of twelve; without Boost no ratio of the rings."""
    end_to_end = _ns_per_event(build, "end_to_end_bench", "BM_EndToEnd")
    pipeline = _ns_per_event(build, "pipeline_bench", "BM_Pipeline/size:1000")
    rings = _ns_per_event(build, "event_buffer_bench", "<(OurRing|BoostRing)>")
    found = {
        "end_to_end_ns": end_to_end["BM_EndToEnd/gamma_percent:100/real_time"],
        "end_to_end_half_ns": end_to_end["BM_EndToEnd/gamma_percent:50/real_time"],
        "pipeline_ns": pipeline["BM_Pipeline/size:1000"],
    }
    ratios = [
        boost / rings[name.replace("BoostRing", "OurRing")]
        for name, boost in rings.items()
        if "BoostRing" in name
    ]
    return {**found, "ring_of_boost": min(ratios)} if ratios else found


def _ns_per_event(build: Path, benchmark: str, names: str) -> dict[str, float]:
    command = [
        build / "tests" / "bench" / benchmark,
        f"--benchmark_filter={names}",
        "--benchmark_format=json",
        "--benchmark_min_time=0.02",
        "--benchmark_repetitions=12",
        "--benchmark_enable_random_interleaving=true",
    ]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
    rows = json.loads(done.stdout)["benchmarks"]
    best: dict[str, float] = {}
    for row in rows:
        if row["run_type"] == "iteration":
            ns = 1e9 / row["items_per_second"]
            best[row["run_name"]] = min(ns, best.get(row["run_name"], ns))
    return best
