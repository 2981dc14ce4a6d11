"""Pickles: values are equal after a round trip, in every protocol; what has worked is refused."""

from __future__ import annotations

import copy
import inspect
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
from asap import _core, synthetic

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


def test_every_scheme_is_among_them() -> None:
    assert {type(scheme) for scheme in SCHEMES} == {*_core.SCHEMES, asap.SingleEvent}


@pytest.mark.parametrize("protocol", PROTOCOLS)
@pytest.mark.parametrize("scheme", SCHEMES, ids=repr)
def test_schemes(scheme: asap.Scheme, protocol: int) -> None:
    for twin in (again(scheme, protocol), copy.copy(scheme), copy.deepcopy(scheme)):
        assert type(twin) is type(scheme) and twin is not scheme
        assert twin.parameters == scheme.parameters


def test_a_scheme_decides_alike_afterwards() -> None:
    for scheme in SCHEMES:
        runs = [asap.simulate(EVENTS, cost=COST, scheme=one) for one in (again(scheme), scheme)]
        assert same(*(run.packages for run in runs))


@pytest.mark.parametrize("protocol", PROTOCOLS)
@pytest.mark.parametrize(
    "cost",
    [
        COST,
        asap.LinearCost(100, 300, noise=0.2, seed=2, drift=[1.0, 2.5, 0.5]),
        asap.LinearCost(100, 300, outages_ms=[(0.5, 3.0), (20.0, 21.0)]),
    ],
    ids=["plain", "drift", "outages"],
)
def test_costs(cost: asap.LinearCost, protocol: int) -> None:
    twin = again(cost, protocol)
    assert twin.parameters == cost.parameters
    assert same(*(asap.simulate(EVENTS, cost=one).packages for one in (cost, twin)))


ALGORITHMS: list[Callable[[], Any]] = [
    lambda: asap.ClusterTracker(20, 10, confirm_events=9.0, support="off"),
    lambda: asap.ClusterTracker(20, 10, engine="compat", window=300, seed=2**63, motion="kalman"),
    lambda: asap.FeatureTracker(20, 10, detector="e_fast", window=200),
    lambda: asap.BackgroundActivityFilter(20, 10, window_us=700),
    lambda: asap.HotPixelMask(20, 10, pixels=[(3, 4), (0, 9)], learn_events=7),
    lambda: asap.EFast(20, 10),
    lambda: asap.ArcStar(20, 10, filter_us=9),
    lambda: asap.EHarris(20, 10, threshold=7.5),
    lambda: asap.FAHarris(20, 10, filter_us=3, threshold=0.25),
    lambda: asap.ThresholdOrdinalSurface(20, 10, side=5),
    lambda: asap.SpeedInvariantTimeSurface(20, 10, radius=3),
    lambda: asap.PlaneFlow(20, 10, window_us=900, refit=False),
    lambda: asap.EventImage(20, 10, count=50, channels=["on", "off"]),
]


@pytest.mark.parametrize("protocol", PROTOCOLS)
@pytest.mark.parametrize("make", ALGORITHMS, ids=lambda make: repr(type(make()).__name__))
def test_a_new_algorithm(make: Callable[[], Any], protocol: int) -> None:
    made = make()
    for twin in (again(made, protocol), copy.deepcopy(made)):
        assert type(twin) is type(made)
        assert (twin.width, twin.height, twin.parameters) == (20, 10, made.parameters)


@pytest.mark.parametrize("protocol", PROTOCOLS)
def test_a_new_gamma_filter(protocol: int) -> None:
    made = asap.GammaFilter(seed=2**64 - 1)
    twin = again(made, protocol)
    assert twin.parameters == {"seed": 2**64 - 1}
    assert same(twin.mask(EVENTS, 0.3), made.mask(EVENTS, 0.3))


# ---- what has worked ------------------------------------------------------------------------

WORKS: list[Callable[[Any], object]] = [
    lambda made: made.process(EVENTS),
    lambda made: made.set_keep(0.5),
    lambda made: asap.simulate(EVENTS, cost=COST, algorithm=made),
]


@pytest.mark.parametrize("work", WORKS)
@pytest.mark.parametrize("make", ALGORITHMS, ids=lambda make: repr(type(make()).__name__))
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


def test_a_mask_that_has_learned_has_worked() -> None:
    mask = asap.HotPixelMask(20, 10)
    mask.learn(EVENTS)
    with pytest.raises(TypeError, match="it has worked"):
        pickle.dumps(mask)


def test_a_gamma_filter_that_has_worked_says_so() -> None:
    used = asap.GammaFilter()
    used.apply(EVENTS, 0.3)
    with pytest.raises(TypeError, match=r"^cannot pickle GammaFilter: it has worked"):
        pickle.dumps(used)


# ---- streams, recordings --------------------------------------------------------------------


@pytest.mark.parametrize(
    "make",
    [
        lambda: synthetic.ShakenPattern(duration_s=0.05, seed=3, last_rate_hz=2e6),
        lambda: synthetic.FlightOverChairs(duration_s=0.05, t0_us=5),
    ],
)
def test_streams(make: Callable[[], Any]) -> None:
    stream = make()
    twin = again(stream)
    assert (type(twin), twin.name, twin.parameters) == (
        type(stream),
        stream.name,
        stream.parameters,
    )
    assert same(twin.events(), stream.events())


@pytest.mark.parametrize(
    ("name", "text", "options"),
    [
        ("plain.txt", "1 2 3 1\n5 6 7 0\n", {"width": 20, "height": 30}),
        ("seconds.txt", "0.5 2 3 1\n0.6 6 7 0\n", {}),
        ("header.csv", "x,y,other,t_us,p\n2,3,9,500,1\n3,4,9,600,0\n", {}),
        ("yxt.txt", "3 2 1000\n7 6 2000\n", {"order": "yxt", "time_unit": "ns"}),
        ("bad.txt", "9 2 3 1\n8 6 7 0\n", {"reorder_tolerance_us": 3, "on_bad": "clamp"}),
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


def test_every_argument_of_a_recording_is_in_its_pickle(tmp_path: Path) -> None:
    (tmp_path / "plain.txt").write_text("1 2 3 1\n")
    make, _ = asap.read(tmp_path / "plain.txt").__reduce__()
    assert make.func is asap.Recording
    assert {"path", *make.keywords} == {*inspect.signature(asap.Recording).parameters}


def test_a_recording_of_numpy(tmp_path: Path) -> None:
    np.save(tmp_path / "few.npy", np.array([[3, 2, 1.5], [7, 6, 2.5]]))
    recording = asap.read(tmp_path / "few.npy", order="yxt", time_unit="ms", width=9, height=9)
    assert same(*(np.concatenate(list(one)) for one in (recording, again(recording))))


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


def test_a_run_in_real_time() -> None:
    run = asap.run(EVENTS, algorithm=Counting(), speed=10.0)
    twin = again(run)
    assert equal_runs(twin, run)
    assert twin.lateness.state() == run.lateness.state()


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


@pytest.mark.parametrize("name", ["run.npz", "run.json"])
def test_a_run_that_was_loaded(tmp_path: Path, name: str) -> None:
    run = asap.simulate(EVENTS, cost=COST)
    loaded = asap.load_run(run.save(tmp_path / name))
    assert loaded.without_log == again(loaded).without_log == (name == "run.json")
    assert equal_runs(again(loaded), loaded)


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


class Derived(asap.Deadline):
    """May have a state of its own."""


class DerivedTracker(asap.ClusterTracker):
    """The same."""


@pytest.mark.parametrize("made", [Derived(), DerivedTracker(20, 10)], ids=type)
def test_a_derived_class_refuses(made: Any) -> None:
    with pytest.raises(TypeError, match=f"^cannot pickle {type(made).__name__}: it is derived"):
        pickle.dumps(made)


def test_a_pickle_is_read_by_a_process_that_knows_nothing(tmp_path: Path) -> None:
    (tmp_path / "run").write_bytes(pickle.dumps(asap.simulate(EVENTS, cost=COST)))
    code = "import pickle, sys; print(repr(pickle.load(open(sys.argv[1], 'rb'))))"
    command = [sys.executable, "-c", code, str(tmp_path / "run")]
    shown = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    assert shown.startswith("<Run: virtual time, deadline")
