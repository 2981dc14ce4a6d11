"""Count the instructions per event of the hot path under callgrind and compare them with a file.

    python tests/instructions/count.py build/release/tests/instructions/instructions
    python tests/instructions/count.py PROGRAM --write "why they have changed"

A figure is the difference of two run lengths, so that start and end do not count. Each compiler has
a file of its own; without one the figures are printed and nothing is compared. Exit code 1: a
figure is more than 2 % above the file's. Then mend the code, or write a new file with the reason.
What Deadline takes to decide once and to observe once has bounds of its own.
"""

from __future__ import annotations

import argparse
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
EVENTS = 100_000
MAX_RISE = 1.02

WHAT = ("keep", "thin", "deadline")
STAGES = {
    "push": "asap::*::Pipeline::push*",  # validate, into the ring
    "next": "asap::*::Pipeline::next*",  # decide, filter, pack
    "complete": "asap::*::Pipeline::complete*",  # feed back, book
}
DECISION = ("asap::*::LearningScheme::decide*", "asap::*::LearningScheme::observe*")
# Instructions by the number of events that come at once, by any compiler. The aim is 2000 for all;
# in overload, 40,000, Deadline plays its plans forward.
MAX_PER_DECISION = {10: 2000, 1000: 2000, 10_000: 2000, 40_000: 2900}
# glibc copies by `rep movsb` from some length on, which callgrind counts once per byte.
ENVIRONMENT = {"GLIBC_TUNABLES": "glibc.cpu.x86_rep_movsb_threshold=100000000"}

Figures = dict[str, float]


def instructions(program: Path, words: list[str], functions: str) -> tuple[int, list[int]]:
    """Return the instructions of these functions, over a whole run, and what it prints."""
    done = subprocess.run(
        [
            *("valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"),
            *(f"--toggle-collect={functions}", program, *words),
        ],
        env={"PATH": "/usr/bin:/bin", **ENVIRONMENT},
        capture_output=True,
        text=True,
        check=True,
    )
    (collected,) = re.findall(r"Collected : (\d+)", done.stderr)
    return int(collected), [int(word) for word in done.stdout.split()]


def count(program: Path) -> Figures:
    """Return the instructions per event, by what the run does and stage."""
    return {
        f"{what} {stage}": round(
            (
                instructions(program, [what, str(2 * EVENTS)], STAGES[stage])[0]
                - instructions(program, [what, str(EVENTS)], STAGES[stage])[0]
            )
            / EVENTS,
            2,
        )
        for what in WHAT
        for stage in STAGES
    }


def per_decision(program: Path, backlog: int) -> float:
    """Return the instructions of Deadline to decide and to observe, pushed so many events."""
    events = max(20 * backlog, EVENTS)
    total = 0.0
    for i, functions in enumerate(DECISION):
        short, long = (
            instructions(program, ["backlog", str(length), str(backlog)], functions)
            for length in (events, 2 * events)
        )
        figure = (long[0] - short[0]) / (long[1][i] - short[1][i])
        if figure <= 0:
            raise ValueError(f"{functions} = {figure:g} instructions: no such function is called")
        total += figure
    return total


def risen(now: Figures, before: Figures) -> list[str]:
    """Return a line for every figure that is more than 2 % above the one before."""
    return [
        f"{name}: {before[name]} -> {figure} instructions per event"
        for name, figure in now.items()
        if figure > MAX_RISE * before.get(name, float("inf"))
    ]


def file_of(program: Path) -> Path:
    """Return the file of the compiler that has built the program, as it says itself."""
    done = subprocess.run([program, "compiler"], capture_output=True, text=True, check=True)
    return FOLDER / f"{done.stdout.strip()}.json"


def main(words: list[str]) -> int:
    """Count, print and compare; the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=Path)
    parser.add_argument("--write", metavar="REASON", help="make these the figures of the file")
    given = parser.parse_args(words)
    if shutil.which("valgrind") is None:
        print("valgrind is missing: apt-get install -y valgrind", file=sys.stderr)
        return 2
    program = given.program.resolve()
    decisions = {backlog: per_decision(program, backlog) for backlog in MAX_PER_DECISION}
    for backlog, figure in decisions.items():
        print(f"{figure:8.0f} instructions to decide and to observe, pushes of {backlog} events")
    figures, file = count(program), file_of(program)
    for name, figure in figures.items():
        print(f"{name:<18}{figure:>8.2f} instructions per event")
    for what in WHAT:
        print(f"{what:<18}{sum(figures[f'{what} {stage}'] for stage in STAGES):>8.2f}")
    if given.write:
        file.write_text(json.dumps({"reason": given.write, **figures}, indent=2) + "\n")
    worse = [
        f"{figure:.0f} instructions to decide and to observe: at most {most}"
        for figure, most in zip(decisions.values(), MAX_PER_DECISION.values(), strict=True)
        if figure > most
    ]
    if file.is_file():
        worse += risen(figures, json.loads(file.read_text()))
    else:
        print(f"{file.stem} has no file here: nothing is compared")
    print(*worse, sep="\n", end="\n" if worse else "")
    return 1 if worse else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
