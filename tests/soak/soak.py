"""Runs the parts of the soak one after the other, and prints what they measure beside the goals.

Exit code 1: a figure that any machine must reach was wrong; with --strict, any figure.
"""

from __future__ import annotations

import argparse
import os
import platform
import subprocess
import sys
from pathlib import Path

# The share of the time that a part gets.
SHARES = {
    "ledger": 0.35,
    "steady": 0.25,
    "overload": 0.2,
    "saturation": 0.1,
    "idle": 0.1,
}

# What a figure must not exceed on any machine.
EXACT = {
    "ledger_wrong": 0,
    "hot_path_allocations": 0,
    "steady_wrong": 0,
    "memory_of_pipeline_mib": 6,
    "deadline_wrong": 0,
    "thin_wrong": 0,
    "saturation_newest_wrong": 0,
    "saturation_thin_wrong": 0,
    "stop_threads_left": 0,
    "wake_ups_lost": 0,
}

# What it must not exceed on a quiet machine; with more threads than cores it is that of the others.
QUIET = {
    "steady_overflow": 0,
    "steady_cpu_percent": 50,
    "memory_above_ring_mib": 8,
    "memory_after_stalls_mib": 8,
    "stalled_overflow": 0,
    "steady_memory_growth_mib": 1,
    "deadline_overflow": 0,
    "deadline_p99_of_bound": 1,
    "deadline_max_of_bound": 1.5,
    "deadline_memory_growth_mib": 1,
    "thin_overflow": 0,
    "thin_p99_of_bound": 1,
    "thin_max_of_bound": 1,
    "thin_memory_growth_mib": 1,
    "saturation_newest_memory_growth_mib": 1,
    "saturation_thin_memory_growth_mib": 1,
    "stop_longest_ms": 500,
    "idle_cpu_percent": 2,
    "wake_up_p99_us": 1000,
}

# What it must reach there.
FAST = {
    f"saturation_{when_full}_{name}": 300
    for when_full in ("newest", "thin")
    for name in ("mev_per_s", "mev_per_cpu_s")
}


def main() -> int:
    parser = argparse.ArgumentParser(prog="tests/soak/run", description=__doc__)
    parser.add_argument("--minutes", type=float, required=True)
    parser.add_argument("--seed", type=int, default=None, help="default: another one every time")
    parser.add_argument("--strict", action="store_true", help="fail for a slow machine, too")
    parser.add_argument("--build", type=Path, required=True)
    options = parser.parse_args()
    seed = int.from_bytes(os.urandom(4), "big") if options.seed is None else options.seed

    machine = f"{platform.machine()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}"
    print(f"seed {seed}, {machine}", flush=True)
    found: dict[str, float] = {}
    for part, share in SHARES.items():
        seconds = max(60 * options.minutes * share, 1)
        figures = figures_of(options.build, part, seconds, seed)
        for name, value in figures.items():
            print(row(name, value), flush=True)
        found |= figures
    asked = EXACT | QUIET | FAST if options.strict else EXACT
    return not all(is_reached(name, found[name]) for name in asked)


def figures_of(build: Path, part: str, seconds: float, seed: int) -> dict[str, float]:
    command = [build / "tests" / "soak" / "soak", part, str(seconds), str(seed)]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
    pairs = (line.split() for line in done.stdout.splitlines())
    return {name: float(value) for name, value in pairs}


def is_reached(name: str, value: float) -> bool:
    return value >= FAST[name] if name in FAST else value <= (EXACT | QUIET)[name]


def row(name: str, value: float) -> str:
    limits, goal = EXACT | QUIET | FAST, ""
    if name in limits:
        sign = ">=" if name in FAST else "<="
        goal = f"{sign} {limits[name]:<8g}{'reached' if is_reached(name, value) else 'MISSED'}"
    return f"{name:<38}{value:<14.6g}{goal}".rstrip()


if __name__ == "__main__":
    sys.exit(main())
