"""The sensor of an algorithm or a filter against that of the source: too small is refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
from streams import make

EVENTS = make(np.arange(1000))  # 346 x 260 px
COST = asap.LinearCost(1, 1)


def run(source: Any, worker: Any, **sensor: int) -> object:
    return asap.run(source, algorithm=worker, **sensor)


def simulate(source: Any, worker: Any, **sensor: int) -> object:
    return asap.simulate(source, cost=COST, algorithm=worker, **sensor)


def filtered(source: Any, worker: Any, **sensor: int) -> object:
    return asap.simulate(source, cost=COST, before=worker, **sensor)


def live(source: Any, worker: Any, **sensor: int) -> object:
    return asap.Pipeline(worker, **sensor)


def live_filtered(source: Any, worker: Any, **sensor: int) -> object:
    return asap.Pipeline(before=worker, **sensor)


ENTRIES = [run, simulate, filtered, live, live_filtered]


@pytest.mark.parametrize("entry", ENTRIES)
@pytest.mark.parametrize("size", [(34, 34), (346, 34), (34, 260)])
def test_one_that_is_too_small_is_named_with_the_source_and_the_remedy(
    entry: Callable[..., object], size: tuple[int, int]
) -> None:
    worker = asap.BackgroundActivityFilter(*size)
    field = "before" if "filtered" in entry.__name__ else "algorithm"
    words = (
        rf"^{field} = BackgroundActivityFilter for {size[0]} x {size[1]} px: .* 346 x 260 px; "
        r"make it BackgroundActivityFilter\(346, 260\)"
    )
    with pytest.raises(ValueError, match=words):
        entry(EVENTS, worker, width=346, height=260)
    assert worker.rejected == 0


@pytest.mark.parametrize("entry", [run, simulate, filtered])
def test_the_file_knows_the_sensor(entry: Callable[..., object], tmp_path: Path) -> None:
    np.savez(tmp_path / "events.npz", events=EVENTS, width=346, height=260)
    with pytest.raises(ValueError, match="346 x 260 px"):
        entry(tmp_path / "events.npz", asap.BackgroundActivityFilter(34, 34))
