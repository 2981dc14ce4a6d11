"""No event is no success: shares of nothing are nan, None in JSON, and the reader is told."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
from asap.cli import main

EVENTS = np.zeros(0, asap.EVENT_DTYPE)
COST = asap.LinearCost(100, 300)
SHARES = ("kept", "in_time")


def nothing(events: Any) -> None:
    """Do nothing."""


@pytest.fixture
def flight(tmp_path: Path) -> Path:
    """A recording of 10 ms."""
    path = tmp_path / "flight.npy"
    events = np.zeros(100, asap.EVENT_DTYPE)
    events["t"] = np.arange(100) * 100
    np.save(path, events)
    return path


@pytest.mark.parametrize(
    "run",
    [
        pytest.param(lambda: asap.simulate(EVENTS, cost=COST), id="simulate"),
        pytest.param(lambda: asap.run(EVENTS, algorithm=nothing), id="run"),
    ],
)
def test_a_run_of_nothing_has_no_shares(run: Any, tmp_path: Path) -> None:
    found = run()
    assert math.isnan(found.kept) and math.isnan(found.in_time)
    assert [found.summary()[name] for name in SHARES] == [None, None]
    assert [asap.table([found])[0][name] for name in SHARES] == [None, None]
    assert "No event was received." in str(found) and "100.0 %" not in str(found)
    for name in ("run.npz", "run.json"):
        again = asap.load_run(found.save(tmp_path / name))
        assert math.isnan(again.kept) and math.isnan(again.in_time)
        assert str(again) == str(found)
    page = found.report(tmp_path / "run.html").read_text("utf-8")
    assert "No event was received." in page and "100.0 %" not in page


def test_a_comparison_of_nothing_has_no_scores(tmp_path: Path) -> None:
    found = asap.compare(EVENTS, cost=COST)
    figures = ("score", "kept", "in_time", "overflow")
    assert all(math.isnan(getattr(row, name)) for row in found.rows for name in figures)
    summary = json.loads(found.save(tmp_path / "comparison.json").read_text("utf-8"))
    assert {scheme[name] for scheme in summary["schemes"] for name in figures} == {None}
    assert summary["oracle"]["in_time"] is None
    page = found.report(tmp_path / "comparison.html").read_text("utf-8")
    for words in (str(found), page):
        assert "No event was received." in words
        assert "1.000" not in words and "100.0 %" not in words
    assert "1.000" not in repr(found)


def test_a_score_where_the_oracle_finishes_nothing_is_none() -> None:
    one = np.zeros(1, asap.EVENT_DTYPE)
    found = asap.compare(one, cost=asap.LinearCost(50_000, 0), latency_ms=10)
    assert all(math.isnan(row.score) and row.in_time == 0 for row in found.rows)


def test_a_pipeline_that_got_nothing_has_no_shares() -> None:
    assert [asap.Pipeline().stats()[name] for name in SHARES] == [None, None]


@pytest.mark.filterwarnings("ignore:.*no event from")
@pytest.mark.parametrize("verb", ["run", "compare", "camera"])
def test_the_command_line_ends_with_the_code_for_no_data(
    verb: str, flight: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = {
        "run": ["run", flight, "--cost", "100us+300ns"],
        "compare": ["compare", flight, "--cost", "100us+300ns"],
        "camera": ["run", "--software-camera", flight],
    }[verb]
    size = ["--width", "346", "--height", "260"]
    assert main([*map(str, command), *size, "--from", "5s", "--json"]) == 3
    out, err = capsys.readouterr()
    if verb in ("run", "compare"):
        assert "no event was received" in err
        assert json.loads(out)["source"]["events"] == 0
    else:  # no camera can play it
        assert "source: holds no events" in err


def test_load_of_an_empty_window_warns(flight: Path) -> None:
    with pytest.warns(UserWarning, match=r"flight.npy: no event from 5 s to its end"):
        assert asap.load(flight, start=5).size == 0
    with pytest.warns(UserWarning, match=r"no event from 0\.00501 s to 0\.00505 s"):
        assert asap.load(flight, start=0.00501, stop=0.00505).size == 0
    assert asap.load(flight, start=0.005).size == 50
