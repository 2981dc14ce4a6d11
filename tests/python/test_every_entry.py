"""The same packages through every entry: command line, simulate, run and the live forms. R21."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import asap
import streams
from asap.cli import main

SIZE = 700
SENSOR = {"width": 346, "height": 260}
GEOMETRY = ("--width", "346", "--height", "260")
FOR_EVER = {"latency_ms": 1e6}  # nothing is flushed, nothing is late


def fixed_size() -> asap.FixedSize:
    return asap.FixedSize(size=SIZE)


def boundaries(packages: Any) -> list[tuple[int, int, int]]:
    return [tuple(row) for row in packages[["t_first", "t_last", "size"]].tolist()]


def live(algorithm: Any, events: Any) -> Any:
    """Give the rows of a pipeline that gets all events at once: in a loop, or by run()."""
    pipeline = asap.Pipeline(algorithm, scheme=fixed_size(), **FOR_EVER, **SENSOR)
    pipeline.push(events)
    pipeline.stop()
    if algorithm is None:
        assert sum(map(len, pipeline)) == events.size
    else:
        pipeline.run()
    return pipeline.packages


def test_the_same_packages_through_every_door(tmp_path: Path) -> None:
    events, path = streams.poisson(1e6, 0.02), tmp_path / "events.npy"
    np.save(path, events)
    options = {"scheme": fixed_size(), **FOR_EVER, **SENSOR}
    simulated = asap.simulate(path, cost=asap.LinearCost(1, 1), **options)
    expected = boundaries(simulated.packages)
    parts = np.split(events["t"], np.arange(SIZE, events.size, SIZE))
    assert expected == [(part[0], part[-1], part.size) for part in parts]

    saved = str(tmp_path / "run.npz")
    command = f"--cost 1us+1ns --scheme fixed_size --set size={SIZE} --latency 1000s --json"
    assert main(["run", str(path), *command.split(), *GEOMETRY, "--save", saved]) == 0
    by_command = asap.load_run(saved)
    assert boundaries(by_command.packages) == expected
    assert by_command.ledger == simulated.ledger

    assert boundaries(asap.run(path, algorithm=len, speed=1000.0, **options).packages) == expected
    for algorithm in (None, len, asap.ClusterTracker(346, 260)):
        assert boundaries(live(algorithm, events)) == expected
