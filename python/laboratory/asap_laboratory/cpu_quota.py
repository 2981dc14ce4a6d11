"""The flight scene in real time, under a processor quota of the system.

A cgroup gives this process a share of one core, as a container or a service has it. What is
above it waits. ``python -m asap_laboratory.cpu_quota [SHARE ...]`` prints a table for each share,
and first one without a quota; it needs the right to make a cgroup with the controller cpu.
"""

from __future__ import annotations

import multiprocessing
import os
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path

import numpy as np

from asap.experiment import run
from asap.synthetic import FlightOverChairs
from asap_laboratory.cpu_share import (
    ALPHA_US,
    BETA_NS,
    COLUMNS,
    CPU_SHARE,
    USUAL_OVERHEAD,
    Setting,
    figures,
    scheme,
)
from asap_laboratory.page import Row, Rows, Writer

PERIOD_US = 10_000  # of the quota
SETTINGS = (
    *((share, 0.0) for share in (0.8, 0.5, 0.25, 0.1)),
    (USUAL_OVERHEAD, 4.0),
)
_CGROUPS = Path("/sys/fs/cgroup")


class NoQuota(OSError):
    """The system gives no cgroup with a processor quota."""


@contextmanager
def quota(share: float, root: Path = _CGROUPS) -> Iterator[None]:
    """Give this process a share of one core until the end of the block.

    Raises
    ------
    NoQuota
        There is no controller cpu, or no right to make a group of it.
    """
    parent, limits = _limits(root, round(share * PERIOD_US))
    with _group(parent) as group:
        for name, value in {**limits, "cgroup.procs": str(os.getpid())}.items():
            (group / name).write_text(value)
        try:
            yield
        finally:
            (parent / "cgroup.procs").write_text(str(os.getpid()))


@contextmanager
def _group(parent: Path) -> Iterator[Path]:
    try:
        group = Path(tempfile.mkdtemp(prefix="asap-", dir=parent))
    except OSError as error:
        raise NoQuota(f"quota: skipped, no group can be made in {parent}: {error}") from error
    try:
        yield group
    finally:
        group.rmdir()


def _limits(root: Path, quota_us: int) -> tuple[Path, dict[str, str]]:
    """Find the folder in which a group is made, and its files, in version 1 and 2 of cgroups."""
    first = root / "cpu"
    if (first / "cpu.cfs_quota_us").exists() or (first / "cpu.shares").exists():
        return first, {"cpu.cfs_period_us": str(PERIOD_US), "cpu.cfs_quota_us": str(quota_us)}
    controllers = root / "cgroup.subtree_control"
    if controllers.exists() and "cpu" in controllers.read_text().split():
        return root, {"cpu.max": f"{quota_us} {PERIOD_US}"}
    raise NoQuota(f"quota: skipped, {root} has no controller cpu")


def measure(
    share: float | None,
    settings: Sequence[Setting] = SETTINGS,
    *,
    seed: int = 0,
    duration_s: float = 4.0,
) -> Rows:
    """Replay one flight in real time under every setting, in a process of its own.

    `share` is the part of one core that the process may use; None: no quota. A row for each
    setting, where `cpu` is the processor time of the whole process over the duration. NoQuota where
    the system gives none.
    """
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(_measured, (share, tuple(settings), seed, duration_s))


def _measured(
    share: float | None, settings: tuple[Setting, ...], seed: int, duration_s: float
) -> Rows:
    events = FlightOverChairs(duration_s=duration_s, seed=seed).events()
    with nullcontext() if share is None else quota(share):
        return [_flown(events, setting) for setting in settings]


def _flown(events: np.ndarray, setting: Setting) -> Row:
    begun, begun_cpu = time.perf_counter(), time.process_time()
    found = run(events, algorithm=_work, scheme=scheme(setting))
    duration_s = time.perf_counter() - begun
    return figures(setting, found, time.process_time() - begun_cpu, duration_s)


def _work(events: np.ndarray) -> None:
    """Take the processor time of the algorithm."""
    until_ns = time.thread_time_ns() + ALPHA_US * 1e3 + BETA_NS * events.size
    while time.thread_time_ns() < until_ns:
        pass


def main(words: Sequence[str]) -> int:
    """Print a table without a quota and one for each share; the exit code."""
    shares = [None, *(float(word) for word in words or ("0.5", "0.3"))]
    for share in shares:
        name = "no quota" if share is None else f"quota {share:.0%} of a core"
        try:
            print(f"{name}\n\n{Writer(CPU_SHARE.cells).listing(measure(share), COLUMNS)}\n")
        except NoQuota as reason:
            print(reason, file=sys.stderr)
            return 3
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
