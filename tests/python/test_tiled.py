"""What `asap.Tiled` promises beyond what every algorithm does; the threads: tests/cpp/runner."""

from __future__ import annotations

import os
import pickle
import re
import signal
from typing import Any

import numpy as np
import pytest

import asap
from golden import golden_stream
from test_algorithms import MADE, TILEABLE, outcome, same

WIDTH, HEIGHT = 346, 260
EVENTS = golden_stream()[:60_000]


@pytest.mark.parametrize("name", TILEABLE)
def test_it_answers_as_one_instance(name: str) -> None:
    kind, parameters = MADE[name]
    tiled = asap.Tiled(kind, WIDTH, HEIGHT, threads=3, **parameters)
    parts = np.array_split(EVENTS, 11)
    assert same(outcome(tiled, *parts), outcome(kind(WIDTH, HEIGHT, **parameters), *parts))


@pytest.mark.parametrize("name", TILEABLE)
def test_its_parameters_rebuild_it(name: str) -> None:
    kind, parameters = MADE[name]
    tiled: Any = asap.Tiled(kind, WIDTH, HEIGHT, threads=2, **parameters)
    assert tiled.parameters == {**kind(WIDTH, HEIGHT, **parameters).parameters, "threads": 2}
    assert (tiled.name, tiled.width, tiled.height) == (name, WIDTH, HEIGHT)
    for again in (eval(repr(tiled), vars(asap).copy()), pickle.loads(pickle.dumps(tiled))):
        assert repr(again) == repr(tiled)


def test_a_filter_stands_in_front_of_a_run() -> None:
    one = asap.BackgroundActivityFilter(WIDTH, HEIGHT)
    tiled = asap.Tiled(asap.BackgroundActivityFilter, WIDTH, HEIGHT, threads=2)
    cost = asap.LinearCost(10, 10)
    runs = [asap.simulate(EVENTS, cost=cost, before=before) for before in (one, tiled)]
    assert runs[0].ledger == runs[1].ledger and runs[0].ledger.filtered > 0


def test_a_process_that_forked_goes_on_alone() -> None:
    tiled = asap.Tiled(asap.EFast, WIDTH, HEIGHT, threads=2)
    corners = tiled.process(EVENTS)
    tiled.reset()
    if (child := os.fork()) == 0:
        signal.alarm(30)
        alone = np.array_equal(tiled.process(EVENTS), corners)
        del tiled
        os._exit(0 if alone else 1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


@pytest.mark.parametrize("kind", [asap.HotPixelMask, asap.ClusterTracker, int])
def test_what_needs_more_than_the_rows_around_is_refused(kind: Any) -> None:
    with pytest.raises(TypeError, match=rf"^algorithm = {kind.__name__}: .*rows around.*EFast"):
        asap.Tiled(kind, WIDTH, HEIGHT)


@pytest.mark.parametrize("given", [asap.EFast(WIDTH, HEIGHT), "EFast", print])
def test_what_is_no_class_is_refused(given: Any) -> None:
    with pytest.raises(TypeError, match=r"must be a class\. .*EFast"):
        asap.Tiled(given, WIDTH, HEIGHT)


@pytest.mark.parametrize(
    "bad", [{"threads": 0}, {"threads": 65}, {"width": 0}, {"height": 20_000}, {"filter_us": -1}]
)
def test_a_bad_parameter_is_refused_by_name(bad: dict[str, int]) -> None:
    ((name, value),) = bad.items()
    with pytest.raises(ValueError, match=re.escape(f"{name} = {value}: ")):
        asap.Tiled(asap.ArcStar, **{"width": 40, "height": 30, "threads": 2, **bad})


def test_an_unknown_parameter_is_named() -> None:
    with pytest.raises(TypeError, match="window"):
        asap.Tiled(asap.EFast, WIDTH, HEIGHT, window=1)
