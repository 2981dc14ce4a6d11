"""No output is written over the recording, and none under a name that promises something else."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
import corrupt


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    path = tmp_path / "flight.npz"
    with path.open("wb") as file:
        np.savez(file, events=corrupt.clean_events(500))
    return path


def test_a_suffix_says_what_is_inside(recording: Path, tmp_path: Path) -> None:
    events = asap.load(recording, width=346, height=260)
    results: list[Any] = [
        asap.simulate(events, cost=asap.LinearCost(1, 1)),
        asap.compare(events, cost=asap.LinearCost(1, 1), latency_ms=10),
        asap.check(events, width=346, height=260),
    ]
    for result in results:
        with pytest.raises(ValueError, match=r"page\.pdf': give a name that ends in \.html"):
            result.report(tmp_path / "page.pdf")
    for result in results[1:]:
        with pytest.raises(ValueError, match=r"table\.npz': give a name that ends in \.json"):
            result.save(tmp_path / "table.npz")
        assert json.loads(result.save(tmp_path / "table.json").read_text()) == result.summary()
