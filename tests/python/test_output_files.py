"""No output is written over the recording, and none under a name that promises something else."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
import corrupt
from asap import cli

SENSOR = ("--width", str(corrupt.WIDTH), "--height", str(corrupt.HEIGHT))


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    path = tmp_path / "flight.npz"
    with path.open("wb") as file:
        np.savez(file, events=corrupt.clean_events(500))
    return path


@pytest.mark.parametrize(
    "arguments",
    [
        ["check", "flight.npz", *SENSOR, "--report", "flight.npz"],
        ["run", "flight.npz", *SENSOR, "--cost", "1us+1ns", "--report", "flight.npz"],
        ["run", "flight.npz", *SENSOR, "--cost", "1us+1ns", "--save", "flight.npz"],
        ["compare", "flight.npz", *SENSOR, "--cost", "1us+1ns", "--report", "flight.npz"],
        ["report", "flight.npz", "-o", "flight.npz"],
    ],
    ids=" ".join,
)
def test_the_recording_is_never_written_over(
    recording: Path, monkeypatch: Any, capsys: Any, arguments: list[str]
) -> None:
    before = recording.read_bytes()
    monkeypatch.chdir(recording.parent)
    assert cli.main(arguments) == 2
    assert recording.read_bytes() == before
    words = "is the recording itself; give another", "give a name that ends in .html"
    told = capsys.readouterr().err
    assert any(word in told for word in words)


def test_a_run_is_not_saved_over_its_recording(recording: Path) -> None:
    before = recording.read_bytes()
    run = asap.simulate(asap.read(recording, width=346, height=260), cost=asap.LinearCost(1, 1))
    with pytest.raises(ValueError, match=r"flight\.npz': is the recording itself; give another"):
        run.save(recording)
    assert recording.read_bytes() == before


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
