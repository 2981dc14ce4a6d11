"""asap.map on a cluster of dask: two workers on loopback, one of them killed midway."""

from __future__ import annotations

import os
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
import streams

# Its own modules warn as they are imported, and as a worker goes.
pytestmark = [pytest.mark.full, pytest.mark.filterwarnings("ignore")]


def simulated(path: Path) -> asap.Run:
    """Recording 5 kills its worker, the first time."""
    killed = path.with_suffix(".killed")
    if path.stem == "5" and not killed.exists():
        killed.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    path.with_suffix(f".{os.getpid()}").touch()
    return asap.simulate(path, cost=asap.LinearCost(100, 300))


def fails(path: Path) -> Any:
    raise ValueError(f"{path.name}: too few events")


@pytest.fixture
def recordings(tmp_path: Path) -> list[Path]:
    paths = [tmp_path / f"{number}.npy" for number in range(20)]
    for number, path in enumerate(paths):
        np.save(path, streams.make(np.arange(100 + number) * 50, x=3, y=4))
    return paths


def test_two_workers_of_which_one_is_killed(recordings: list[Path]) -> None:
    distributed = pytest.importorskip("distributed")
    cluster = distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None
    )
    with cluster, distributed.Client(cluster) as client:
        executor = client.get_executor()
        runs = asap.map(simulated, recordings, executor=executor)
        assert recordings[5].with_suffix(".killed").exists()
        assert [run.ledger.received for run in runs] == [100 + n for n in range(20)]
        assert len({path.suffix for path in recordings[0].parent.iterdir()}) >= 4  # two workers
        failed = asap.map(fails, recordings[:2], executor=executor)
        assert [str(one) for one in failed] == [f"{n}.npy: too few events" for n in range(2)]
        assert [one.recording for one in failed] == recordings[:2]
