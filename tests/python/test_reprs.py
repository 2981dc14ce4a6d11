"""One style of repr: how to make it anew, or what it is in angle brackets; never an address."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
import streams
from asap import synthetic
from test_signatures import MADE

COST = asap.LinearCost(100, 300)
AGAIN = [
    *MADE,
    asap.ClusterTracker(20, 10, slots=64),
    asap.ArcStar(20, 10, filter_us=70_000),
    asap.HotPixelMask(20, 10, pixels=[(1, 2)]),
    asap.GammaFilter(seed=3),
    asap.Deadline(latency_ms=5),
    synthetic.ShakenPattern(duration_s=0.1),
]


@pytest.mark.parametrize("made", AGAIN, ids=repr)
def test_it_says_how_to_make_it_anew(made: Any) -> None:
    names = {**vars(asap), **vars(synthetic)}
    again = eval(repr(made), names)
    assert type(again) is type(made)
    assert again.parameters == made.parameters
    assert all(
        getattr(again, side) == getattr(made, side)
        for side in ("width", "height")
        if hasattr(made, side)
    )


def test_it_says_of_an_algorithm_what_is_no_default() -> None:
    assert repr(asap.ClusterTracker(20, 10)) == "ClusterTracker(20, 10)"
    assert repr(asap.ClusterTracker(20, 10, engine="compat")) == (
        "ClusterTracker(20, 10, engine='compat')"
    )
    assert repr(asap.EventImage(20, 10, count=5)) == "EventImage(20, 10, count=5)"


def test_a_class_of_a_user_is_called_by_its_own_name() -> None:
    class Mine(asap.EFast):
        pass

    assert repr(Mine(20, 10)) == "Mine(20, 10)"


def test_what_was_found_stands_in_angle_brackets(tmp_path: Path) -> None:
    events = streams.poisson(10_000, 0.1)
    path = tmp_path / "ev.npy"
    np.save(path, events)
    run = asap.simulate(events, cost=COST)
    found = [
        run,
        run.latency,
        asap.compare(events, cost=COST, schemes=[asap.Greedy()]),
        asap.check(path),
        asap.read(path),
        asap.Pipeline(),
    ]
    for one in found:
        assert re.fullmatch(rf"<{type(one).__name__}: [^\n]+>", repr(one)), repr(one)
        assert not re.search(r"0x[0-9a-f]{6}", repr(one)), repr(one)
    assert repr(run.latency).startswith(f"<LatencyHistogram: {run.latency.count} events, ")
