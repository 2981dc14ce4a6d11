"""Pickles: values are equal after a round trip, in every protocol; what has worked is refused."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
import streams
from test_algorithms import MADE

EVENTS = streams.make(np.arange(2000) * 50, x=np.arange(2000) % 20, y=3)
COST = asap.LinearCost(100, 300)
PROTOCOLS = range(pickle.HIGHEST_PROTOCOL + 1)


def again(made: Any, protocol: int = pickle.HIGHEST_PROTOCOL) -> Any:
    return pickle.loads(pickle.dumps(made, protocol))


def same(one: Any, other: Any) -> bool:
    """Whether two are equal, arrays and their dtype included."""
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and bool(
            np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
        )
    if isinstance(one, dict):
        return [*one] == [*other] and all(same(one[name], other[name]) for name in one)
    return bool(one == other)


# ---- what configures a run ------------------------------------------------------------------

SCHEMES = [
    asap.FixedSize(size=7),
    asap.FixedTime(period_ms=2.5),
    asap.SingleEvent(),
    asap.Greedy(),
    asap.Greedy(efficiency=0.9),
    asap.Asap2020(rate_bound=2e6, epsilon=0.1, first_size=5, max_size=100, min_size=2),
    asap.Asap2022(kappa=0.5),
    asap.Deadline(latency_ms=3, overhead=0.1, first_alpha_us=7, first_beta_ns=9, prefer="events"),
    asap.DeadBeat(latency_ms=4, knee=20),
]


@pytest.mark.parametrize("protocol", PROTOCOLS)
@pytest.mark.parametrize("scheme", SCHEMES, ids=repr)
def test_schemes(scheme: asap.Scheme, protocol: int) -> None:
    for twin in (again(scheme, protocol), copy.copy(scheme), copy.deepcopy(scheme)):
        assert type(twin) is type(scheme) and twin is not scheme
        assert twin.parameters == scheme.parameters


ALGORITHMS = [partial(kind, 20, 10, **parameters) for kind, parameters in MADE.values()]
every_algorithm = pytest.mark.parametrize("make", ALGORITHMS, ids=MADE)


@pytest.mark.parametrize("protocol", PROTOCOLS)
@every_algorithm
def test_a_new_algorithm(make: Callable[[], Any], protocol: int) -> None:
    made = make()
    for twin in (again(made, protocol), copy.deepcopy(made)):
        assert type(twin) is type(made)
        assert (twin.width, twin.height, twin.parameters) == (20, 10, made.parameters)


# ---- what has worked ------------------------------------------------------------------------

WORKS: list[Callable[[Any], object]] = [
    lambda made: made.process(EVENTS),
    lambda made: made.set_gamma(0.5),
    lambda made: asap.simulate(EVENTS, cost=COST, algorithm=made),
]


@pytest.mark.parametrize("work", WORKS)
@every_algorithm
def test_an_algorithm_that_has_worked_says_so(
    make: Callable[[], Any], work: Callable[[Any], object]
) -> None:
    used = make()
    work(used)
    for duplicate in (*(partial(pickle.dumps, protocol=one) for one in PROTOCOLS), copy.deepcopy):
        with pytest.raises(TypeError, match=f"^cannot pickle {type(used).__name__}: it has worked"):
            duplicate(used)
    used.reset()
    assert again(used).parameters == make().parameters


def test_a_gamma_filter_that_has_worked_says_so() -> None:
    used = asap.GammaFilter()
    used.apply(EVENTS, 0.3)
    with pytest.raises(TypeError, match=r"^cannot pickle GammaFilter: it has worked"):
        pickle.dumps(used)


# ---- streams, recordings --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "text", "options"),
    [
        ("plain.txt", "1 2 3 1\n5 6 7 0\n", {"width": 20, "height": 30}),
        ("seconds.txt", "0.5 2 3 1\n0.6 6 7 0\n", {}),
        ("header.csv", "x,y,other,t_us,p\n2,3,9,500,1\n3,4,9,600,0\n", {}),
        ("yxt.txt", "3 2 1000\n7 6 2000\n", {"order": "yxt", "time_unit": "ns"}),
        ("text.bin", "1 2 3 1\n5 6 7 0\n", {"file_format": "text"}),
        ("bad.txt", "9 2 7 1\n8 6 3 0\n", {"reorder_tolerance_us": 3, "on_bad": "clamp"}),
    ],
)
def test_recordings_by_path(tmp_path: Path, name: str, text: str, options: Any) -> None:
    path = tmp_path / name
    path.write_text(text)
    recording = asap.read(path, **options)
    for twin in (again(recording), again(again(recording))):
        assert repr(twin) == repr(recording)
        assert (twin.path, twin.format) == (recording.path, recording.format)
        assert same(np.concatenate(list(twin)), np.concatenate(list(recording)))
        assert twin.repaired == recording.repaired


# ---- results --------------------------------------------------------------------------------


class Counting:
    def __init__(self) -> None:
        self.events = 0

    def process(self, events: Any) -> None:
        self.events += len(events)


class Stubborn(Counting):
    name = "stubborn"

    def __reduce__(self) -> Any:
        raise RuntimeError("not this one")


def equal_runs(one: asap.Run, other: asap.Run) -> bool:
    fields = ("packages", "slots", "kept_mask", "rejected", "source", "ledger", "learned")
    return one.summary() == other.summary() and all(
        same(getattr(one, name), getattr(other, name)) for name in fields
    )


@pytest.mark.parametrize("protocol", PROTOCOLS)
def test_a_run_with_its_algorithm(protocol: int) -> None:
    run = asap.simulate(EVENTS, cost=COST, algorithm=Counting(), keep_mask=True)
    twin = again(run, protocol)
    assert equal_runs(twin, run)
    assert twin.algorithm.events == run.algorithm.events == run.ledger.delivered
    assert repr(twin) == repr(run) and str(twin) == str(run)
    assert twin.latency.quantile(0.5) == run.latency.quantile(0.5)


@pytest.mark.parametrize(
    "algorithm",
    [Stubborn(), lambda events: None, asap.ClusterTracker(20, 10)],
    ids=["stubborn", "lambda", "ours"],
)
def test_a_run_without_it_if_that_cannot(algorithm: Any) -> None:
    run = asap.simulate(EVENTS, cost=COST, algorithm=algorithm)
    twin = again(run)
    assert twin.algorithm is None
    assert equal_runs(twin, run)
    name = run.summary()["algorithm"]["name"]
    assert f"pickled without its algorithm {name}" in repr(twin)
    assert "without" not in repr(run) and run.algorithm is algorithm
    assert equal_runs(again(twin), run) and repr(again(twin)) == repr(twin)


def test_a_comparison() -> None:
    comparison = asap.compare(EVENTS, cost=COST)
    twin = again(comparison)
    assert twin.summary() == comparison.summary()
    assert twin.rows == comparison.rows and repr(twin) == repr(comparison)
    assert str(twin) == str(comparison)
    assert all(equal_runs(twin.runs[label], run) for label, run in comparison.runs.items())


def test_an_inspection() -> None:
    inspection = asap.check(EVENTS, width=20, height=10)
    twin = again(inspection)
    assert twin.summary() == inspection.summary()
    assert same(vars(twin), vars(inspection))


# ---- refusals -------------------------------------------------------------------------------


def test_a_pickle_is_read_by_a_process_that_knows_nothing(tmp_path: Path) -> None:
    (tmp_path / "run").write_bytes(pickle.dumps(asap.simulate(EVENTS, cost=COST)))
    code = "import pickle, sys; print(repr(pickle.load(open(sys.argv[1], 'rb'))))"
    command = [sys.executable, "-c", code, str(tmp_path / "run")]
    shown = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    assert shown.startswith("<Run: virtual time, deadline")
