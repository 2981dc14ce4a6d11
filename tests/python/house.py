"""The checkout as the tests see it: its files, its C++ build, and commands that must succeed."""

from __future__ import annotations

import faulthandler
import functools
import os
import shutil
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
INCLUDE = ROOT / "cpp" / "include"

_WRITTEN_BY_HAND = {
    *(".cpp", ".hpp", ".py", ".pyi", ".md", ".toml", ".json", ".txt", ".cmake", ".in", ".ipynb"),
}


def sources(*folders: str, suffixes: set[str] = _WRITTEN_BY_HAND) -> Iterator[Path]:
    """Files of the project, in a fixed order; without folders those at the top as well."""
    tops = [ROOT / folder for folder in folders or ("cpp", "python", "tests", "notebooks")]
    found = [path for top in tops for path in top.rglob("*")]
    if not folders:
        found += [*ROOT.iterdir(), ROOT / ".ci" / "run"]
    for path in sorted(found):
        if path.is_file() and (path.suffix in suffixes or path.name == "run"):
            yield path


def name_of(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def run(
    command: Sequence[str | Path],
    *,
    cwd: Path | None = None,
    env: Mapping[str, str] | None = None,
    check: bool = True,
) -> str:
    """What the command writes; where it fails, an AssertionError with the end of that."""
    words = [str(word) for word in command]
    assert shutil.which(words[0]), f"{words[0]} is missing: see the apt-get line of README.md"
    faulthandler.cancel_dump_traceback_later()  # pytest's limit: a build may take longer
    done = subprocess.run(
        words,
        cwd=cwd,
        env=env,
        timeout=1200,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    failed = check and done.returncode != 0
    assert not failed, f"exit code {done.returncode}: {' '.join(words)}\n{done.stdout[-8000:]}"
    return done.stdout


def cmake(source: Path, build: Path, **variables: str | Path) -> None:
    """Configure, unless that is done, and build in Release with all cores."""
    if not (build / "CMakeCache.txt").is_file():
        generator = ["-G", "Ninja"] if shutil.which("ninja") else []
        values = {"CMAKE_BUILD_TYPE": "Release", **variables}
        settings = [f"-D{name}={value}" for name, value in values.items()]
        run(["cmake", "-S", source, "-B", build, *generator, *settings])
    run(["cmake", "--build", build, "--parallel", str(os.cpu_count() or 1)])


@functools.cache
def native_build() -> Path:
    """Build the C++ libraries in Release without their tests and return the build folder.

    Two processes must not do this at once, so only one file of tests calls it.
    """
    build = ROOT / "build" / "release-libraries"
    cmake(ROOT, build, CMAKE_UNITY_BUILD="ON")
    return build
