"""Runs the parts of the soak one after the other, prints what they reach, and keeps a log of it.

Exit code 1: a figure that any machine must reach was wrong; with --strict, any figure.
"""

from __future__ import annotations

import argparse
import datetime
import os
import platform
import subprocess
import sys
from pathlib import Path

import speed
from goals import PARTS, SHARES, Goal

HERE = Path(__file__).resolve().parent


def main() -> int:
    parser = argparse.ArgumentParser(prog="tests/soak/run", description=__doc__)
    parser.add_argument("--minutes", type=float, required=True)
    parser.add_argument("--seed", type=int, default=None, help="default: another one every time")
    parser.add_argument("--no-log", action="store_true", help="leave LOG.md as it is")
    parser.add_argument("--strict", action="store_true", help="fail for a slow machine, too")
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=list(PARTS))
    parser.add_argument("--build", type=Path, required=True)
    options = parser.parse_args()
    seed = int.from_bytes(os.urandom(4), "big") if options.seed is None else options.seed

    before = load()
    print(f"seed {seed}, {machine()}, load {before}", flush=True)
    found: dict[str, float] = {}
    failed = missed = False
    for part in options.parts:
        if part == "speed":
            figures = speed.figures(options.build)
        else:
            seconds = max(60 * options.minutes * SHARES[part], 1)
            figures = figures_of(options.build, part, seconds, seed)
        found |= figures
        for name, value in figures.items():
            goal = PARTS[part].get(name)
            if goal is None:
                continue
            print(row(goal, value), flush=True)
            missed |= not goal.reached(value)
            failed |= goal.exact and not goal.reached(value)
    if not options.no_log:
        log(options.minutes, f"{machine()}, load {before} to {load()}", found)
    return 1 if failed or (missed and options.strict) else 0


def figures_of(build: Path, part: str, seconds: float, seed: int) -> dict[str, float]:
    command = [build / "tests" / "soak" / "soak", part, str(seconds), str(seed)]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
    pairs = (line.split() for line in done.stdout.splitlines())
    return {name: float(value) for name, value in pairs}


def row(goal: Goal, value: float) -> str:
    verdict = "" if not goal.bound else "reached" if goal.reached(value) else "MISSED"
    measured = f"{number(value)} {goal.unit}"
    return f"{goal.rule:<4}{goal.words:<50}{goal.bound:>8}  {measured:<24}{verdict}".rstrip()


def number(value: float) -> str:
    if value == int(value) and abs(value) < 1e7:
        return str(int(value))
    return f"{value:.3g}"


def machine() -> str:
    return f"{platform.machine()}, {os.cpu_count()} cores"


def load() -> str:
    """How many threads want to run; with more than cores the figures are those of the others."""
    return f"{os.getloadavg()[0]:.1f}"


def log(minutes: float, where: str, found: dict[str, float]) -> None:
    """One line: date, commit, machine, minutes, and every figure that has a goal or a count."""
    commit = git("rev-parse", "--short", "HEAD")
    if git("status", "--porcelain", "--", "cpp", "tests/soak/*.cpp"):
        commit += " and changes"
    goals = {name: goal for part in PARTS.values() for name, goal in part.items()}
    words = ", ".join(
        f"{name} {number(value)}{'' if goals[name].reached(value) else ' (MISSED)'}"
        for name, value in found.items()
        if name in goals
    )
    today = datetime.datetime.now(datetime.timezone.utc).date()
    with (HERE / "LOG.md").open("a", encoding="utf-8") as file:
        file.write(f"| {today} | {commit} | {where} | {minutes:g} | {words} |\n")


def git(*words: str) -> str:
    done = subprocess.run(["git", *words], cwd=HERE, capture_output=True, text=True, check=False)
    return done.stdout.strip()


if __name__ == "__main__":
    sys.exit(main())
