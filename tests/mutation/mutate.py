"""Applies the mutants to a copy of the tree, one after the other, and runs the tests they name.

Exit code 1: fewer than 95 % were killed. 2: a mutant finds its line no more, or the tests fail
without any.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from mutants import MUTANTS, Mutant

ROOT = Path(__file__).resolve().parents[2]
COPIED = ("CMakeLists.txt", "pyproject.toml", "cpp", "tests")
WANTED = 0.95
# The simulated core and the simulated pipeline, in one program; the other tests are of googletest.
SIMULATIONS = {"simulation": "--seeds 0..99", "live": "--life live --seeds 0..99"}


def main() -> int:
    parser = argparse.ArgumentParser(prog="tests/mutation/run", description=__doc__)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--only", nargs="+", metavar="WORD", help="mutants with such a word")
    parser.add_argument("--keep", type=Path, metavar="DIRECTORY", help="build there, and leave it")
    options = parser.parse_args()
    lost = [mutant for mutant in MUTANTS if (ROOT / mutant.file).read_text().count(mutant.old) != 1]
    for mutant in lost:
        print(f"{mutant.file}: {mutant.words}: its line does not stand there once: {mutant.old!r}")
    if lost or options.check:
        return 2 if lost else 0
    chosen = [m for m in MUTANTS if not options.only or any(w in m.words for w in options.only)]
    place = options.keep or Path(tempfile.mkdtemp(prefix="asap-mutation-"))
    try:
        return run(Workshop(place), chosen)
    finally:
        if not options.keep:
            shutil.rmtree(place)


class Workshop:
    """A copy of the tree with a plain build and one for race detection."""

    def __init__(self, place: Path) -> None:
        self.tree = place / "tree"
        for name in COPIED:
            source, copy = ROOT / name, self.tree / name
            if source.is_dir():
                shutil.copytree(source, copy, dirs_exist_ok=True, copy_function=copy_if_changed)
            else:
                copy.parent.mkdir(parents=True, exist_ok=True)
                copy_if_changed(str(source), str(copy))
        self.builds = {False: place / "build", True: place / "build-threads"}
        self.longest: dict[tuple[str, bool], float] = {}

    def configure(self, threads: bool) -> None:
        flags = "-O1 -g1" if threads else "-O0 -g0"
        generator = ["-G", "Ninja"] if shutil.which("ninja") else []
        command = ["cmake", "-S", self.tree, "-B", self.builds[threads], *generator]
        command += ["-DASAP_TESTS=ON", "-DCMAKE_BUILD_TYPE=Debug", f"-DCMAKE_CXX_FLAGS={flags}"]
        command += ["-DCMAKE_UNITY_BUILD=ON"]
        command += [f"-DASAP_SANITIZE={'thread' if threads else ''}"]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)

    def build(self, tests: tuple[str, ...], threads: bool) -> bool:
        targets = ["simulation" if test in SIMULATIONS else f"test_{test}" for test in tests]
        command = ["cmake", "--build", self.builds[threads], "--parallel", str(os.cpu_count())]
        command += ["--target", *targets]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            print(done.stdout[-4000:])
        return done.returncode == 0

    def failure(self, test: str, threads: bool) -> str | None:
        """The first test that fails, or what else happens; None if all pass."""
        usual = self.longest.get((test, threads))
        start = time.monotonic()
        doubtful: list[str] = []
        while True:
            without = f"--gtest_filter=-{':'.join(doubtful)}"
            said = self.said_by(test, threads, without, usual)
            failed = re.search(r"^\[  FAILED  \] ([\w./]+)", said or "", re.M)
            if said is None and usual is None:
                self.longest[test, threads] = time.monotonic() - start
            if failed is None:
                return said
            # On a busy machine a test may fail for another reason, once.
            name = failed[1]
            if any(self.said_by(test, threads, f"--gtest_filter={name}", usual) for _ in range(3)):
                return name
            doubtful.append(name)

    def said_by(self, test: str, threads: bool, tests: str, usual: float | None) -> str | None:
        """What a test executable says when it fails."""
        folder = self.builds[threads] / "tests"
        place = "race" if test == "race" else "cpp"
        command = [folder / place / f"test_{test}", "--gtest_fail_fast", "--gtest_brief=1", tests]
        if test in SIMULATIONS:
            command = [folder / "simulation" / "simulation", *SIMULATIONS[test].split()]
        try:
            done = subprocess.run(
                command,
                env={**os.environ, "TSAN_OPTIONS": "halt_on_error=1:allocator_may_return_null=1"},
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                errors="replace",
                timeout=600.0 if usual is None else max(60.0, 3 * usual),
                check=False,
            )
        except subprocess.TimeoutExpired:
            return f"{test}, which hangs"
        if done.returncode == 0:
            return None
        if "[  FAILED  ]" in done.stdout:
            return done.stdout
        race = "data race" in done.stdout
        return f"{test}: " + ("data race" if race else f"exit code {done.returncode}")


def copy_if_changed(source: str, copy: str) -> None:
    """An incremental build sees only what differs."""
    old, new = Path(copy), Path(source).read_bytes()
    if not old.is_file() or old.read_bytes() != new:
        old.write_bytes(new)


def run(workshop: Workshop, chosen: list[Mutant]) -> int:
    for threads in sorted({mutant.threads for mutant in chosen}):
        workshop.configure(threads)
        tests = sorted({test for m in chosen if m.threads == threads for test in m.tests})
        if not workshop.build(tuple(tests), threads):
            return 2
        for test in tests:
            if failure := workshop.failure(test, threads):
                print(f"without any mutant: {failure}")
                return 2
    killed = 0
    for mutant in chosen:
        file = workshop.tree / mutant.file
        text = file.read_text()
        file.write_text(text.replace(mutant.old, mutant.new))
        try:
            verdict = verdict_on(workshop, mutant)
        finally:
            file.write_text(text)
        killed += verdict.startswith("killed")
        print(f"{Path(mutant.file).stem:<18}{mutant.words:<44}{verdict}", flush=True)
    print(f"{killed} of {len(chosen)} killed")
    return 0 if killed >= WANTED * len(chosen) else 1


def verdict_on(workshop: Workshop, mutant: Mutant) -> str:
    for test in mutant.tests:
        if not workshop.build((test,), mutant.threads):
            return "DOES NOT COMPILE"
        if failure := workshop.failure(test, mutant.threads):
            return f"killed by {failure}"
    return "SURVIVED"


if __name__ == "__main__":
    sys.exit(main())
