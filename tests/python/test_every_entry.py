"""The same packages through every entry: command line, simulate, run and the live forms. R21."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import asap
from asap.cli import main
from entries import packages_of
from event_files import recording

SIZE = 700
SENSOR = {"width": 346, "height": 260}
GEOMETRY = ("--width", "346", "--height", "260")
FOR_EVER = {"latency_ms": 1e6}  # nothing is flushed, nothing is late
RECORDINGS = (
    "derived/office.npy",
    "derived/office.npz",
    "text/slider_davis240.txt",
    "text/night_davis346.csv",
    "aedat/cars_davis346.aedat4",
)


def fixed_size() -> asap.FixedSize:
    return asap.FixedSize(size=SIZE)


def boundaries(packages: Any) -> list[tuple[int, int, int]]:
    return [tuple(row) for row in packages[["t_first", "t_last", "size"]].tolist()]


@pytest.mark.parametrize("name", RECORDINGS)
def test_the_same_packages_through_every_door(name: str, tmp_path: Any) -> None:
    if name.endswith("aedat4"):
        pytest.importorskip("lz4")
    path = recording(name)
    events = asap.load(path)
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
        live = packages_of(algorithm, events, scheme=fixed_size(), **FOR_EVER, **SENSOR)
        assert boundaries(live) == expected
