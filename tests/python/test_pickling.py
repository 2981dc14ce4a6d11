"""Pickles: equal after a round trip, in every protocol; another version's is refused by name."""

from __future__ import annotations

import concurrent.futures
import copy
import inspect
import multiprocessing
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
import streams
from asap import _core, _pickling, synthetic

pytest.importorskip("asap_laboratory")

from asap_laboratory import keep_curve, profiles, scenes

EVENTS = streams.make(np.arange(2000) * 50, x=np.arange(2000) % 20, y=3)
COST = asap.LinearCost(100, 300)
PROTOCOLS = range(pickle.HIGHEST_PROTOCOL + 1)


def again(made: Any, protocol: int = pickle.HIGHEST_PROTOCOL) -> Any:
    return pickle.loads(pickle.dumps(made, protocol))


def same(one: Any, other: Any) -> bool:
    """Whether two are equal, arrays, their dtype and read-only flag included."""
    if isinstance(one, np.ndarray):
        return (
            one.dtype == other.dtype
            and one.flags.writeable == other.flags.writeable
            and bool(np.array_equal(one, other, equal_nan=one.dtype.kind == "f"))
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
    [COST, profiles.cost("slow_tv", seed=2, duration_s=3), profiles.cost("slow_ht", duration_s=3)],
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


# ---- algorithms with events in them ---------------------------------------------------------

SCENE = scenes.D(seed=1)
SIZE = (SCENE.width - 6, SCENE.height)  # so that some events lie outside
WORKING: list[Callable[[], Any]] = [
    lambda: asap.ClusterTracker(*SIZE),
    lambda: asap.ClusterTracker(*SIZE, slots=4, support="estimate"),
    lambda: asap.ClusterTracker(*SIZE, engine="compat", window=500, probes=3),
    lambda: asap.ClusterTracker(*SIZE, engine="compat", motion="kalman", min_size=3, seed=7),
    *(
        lambda detector=detector: asap.FeatureTracker(*SIZE, detector=detector)
        for detector in ("every_event", "e_fast", "arc_star", "e_harris", "fa_harris")
    ),
    lambda: asap.BackgroundActivityFilter(*SIZE, window_us=2000),
    lambda: asap.HotPixelMask(*SIZE, pixels=[(3, 4)], learn_events=1000),
    lambda: asap.EFast(*SIZE),
    lambda: asap.ArcStar(*SIZE),
    lambda: asap.EHarris(*SIZE),
    lambda: asap.FAHarris(*SIZE),
    lambda: asap.ThresholdOrdinalSurface(*SIZE, side=5),
    lambda: asap.SpeedInvariantTimeSurface(*SIZE, radius=3),
    lambda: asap.PlaneFlow(*SIZE),
    lambda: asap.PlaneFlow(*SIZE, refit=True),
    lambda: asap.EventImage(*SIZE, count=7000, channels=["on", "time"]),
    lambda: asap.EventImage(*SIZE, period_us=10_000),
]
working = pytest.mark.parametrize("make", WORKING, ids=lambda make: repr(make())[:60])


@pytest.fixture(scope="module")
def halves() -> tuple[Any, Any]:
    events = SCENE.events[:160_000]
    return events[:80_000], events[80_000:]


def told(algorithm: Any) -> dict[str, Any]:
    """All that it says of itself: every property."""
    names = [name for name, item in vars(type(algorithm)).items() if isinstance(item, property)]
    return {name: getattr(algorithm, name) for name in names}


def go_on(algorithm: Any, events: Any) -> tuple[Any, dict[str, Any]]:
    """Take the second half in two packages, thinned."""
    first = algorithm.process(events[:30_001])
    algorithm.set_keep(0.6)
    return [first, algorithm.process(events[30_001:])], told(algorithm)


def equal(one: Any, other: Any) -> bool:
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(equal(one[key], other[key]) for key in one)
    if isinstance(one, (list, tuple)):
        return len(one) == len(other) and all(map(equal, one, other))
    if isinstance(one, np.ndarray) and one.dtype.names is None:
        return one.dtype == other.dtype and np.array_equal(
            one, other, equal_nan=one.dtype.kind == "f"
        )
    return same(one, other)


@working
def test_an_algorithm_goes_on_where_it_was(make: Callable[[], Any], halves: Any) -> None:
    first, second = halves
    unbroken = make()
    unbroken.set_keep(0.8)
    unbroken.process(first)
    before = told(unbroken)
    twins = [*(again(unbroken, protocol) for protocol in (2, 5)), copy.copy(unbroken)]
    twins.append(copy.deepcopy(again(unbroken)))
    twins.append(make())
    twins[-1].process(first[:500])
    twins[-1].restore(unbroken.state())
    expected = go_on(unbroken, second)
    assert not equal(expected[1], before)
    for twin in twins:
        assert type(twin) is type(unbroken) and equal(told(twin), before)
        assert equal(go_on(twin, second), expected)
        assert twin.state() == unbroken.state()


def test_every_algorithm_that_pickles_is_among_them() -> None:
    assert {type(make()) for make in WORKING} == {type(make()) for make in ALGORITHMS}


def test_algorithms_go_on_in_a_process_of_their_own(halves: Any) -> None:
    first, second = halves
    used = [make() for make in WORKING]
    for algorithm in used:
        algorithm.process(first)
    context = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(1, mp_context=context) as executor:
        there = [executor.submit(go_on, algorithm, second[:40_000]) for algorithm in used]
        for algorithm, answer in zip(used, there, strict=True):
            assert equal(answer.result(), go_on(algorithm, second[:40_000]))


def test_a_used_algorithm_of_another_version_is_refused_by_name(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    used = asap.EFast(20, 10)
    used.process(EVENTS)
    monkeypatch.setattr(_core, "__version__", "0.0.7")
    data = pickle.dumps(used)
    monkeypatch.undo()
    with pytest.raises(ValueError, match=r"^pickled EFast = of asap 0\.0\.7: this is asap"):
        pickle.loads(data)


def test_a_state_of_another_version_class_or_configuration_is_refused() -> None:
    used = asap.EFast(20, 10)
    used.process(EVENTS)
    state = used.state()
    with pytest.raises(ValueError, match=r"^state = of EFast: this is EHarris$"):
        asap.EHarris(20, 10).restore(state)
    with pytest.raises(ValueError, match=r"^state = of another EFast: make it with the parameters"):
        asap.EFast(10, 20).restore(state)
    old = state[:-8].replace(asap.__version__.encode(), b"0.0.7", 1)
    total = 0xCBF29CE484222325
    for byte in old:
        total = (total ^ byte) * 0x100000001B3 % 2**64
    with pytest.raises(ValueError, match=r"^state = of asap 0\.0\.7: this is asap"):
        used.restore(old + total.to_bytes(8, sys.byteorder))
    with pytest.raises(
        ValueError, match=r"^state = 4 bytes: these are not what state\(\) returned"
    ):
        used.restore(b"abcd")
    assert used.state() == state


@working
def test_a_state_of_other_parameters_is_refused(make: Callable[[], Any]) -> None:
    made = make()
    others = {
        "width": lambda: type(made)(SIZE[0] + 1, SIZE[1], **made.parameters),
        "height": lambda: type(made)(SIZE[0], SIZE[1] + 1, **made.parameters),
    }
    for name, value in made.parameters.items():
        changed = {bool: False, int: 9, float: 5.5}.get(type(value))
        if changed is None or (name, value) in {("count", 0), ("period_us", 0)}:
            continue
        others[name] = lambda name=name, changed=changed: type(made)(
            *SIZE, **{**made.parameters, name: changed}
        )
    for name, other in others.items():
        try:
            twin = other()
        except ValueError:
            continue  # 9 is none of its values
        assert twin.parameters != made.parameters or name in ("width", "height"), name
        with pytest.raises(ValueError, match=r"^state = of another "):
            twin.restore(made.state())


@pytest.mark.parametrize("make", ALGORITHMS, ids=lambda make: repr(type(make()).__name__))
def test_altered_bytes_are_refused(make: Callable[[], Any]) -> None:
    """Bits flipped, bytes overwritten, taken out, put in, moved, cut off: nothing is restored."""
    used = make()
    used.process(EVENTS[:1000])
    state = used.state()
    random = np.random.default_rng(1)
    for trial in range(250):
        altered = bytearray(state)
        place, other = sorted(int(i) for i in random.integers(0, len(state), 2))
        if trial % 6 == 0:
            altered[place] ^= 1 << int(random.integers(8))
        elif trial % 6 == 1:
            altered[place:other] = random.bytes(other - place)
        elif trial % 6 == 2:
            del altered[place : other + 1]
        elif trial % 6 == 3:
            altered[place:place] = random.bytes(1 + trial)
        elif trial % 6 == 4:
            altered = altered[place:] + altered[:place]
        else:
            del altered[place:]
        if altered == state:
            continue
        with pytest.raises(ValueError, match=r"^state = "):
            used.restore(bytes(altered))
    assert used.state() == state
    used.process(EVENTS[1000:])


def test_a_new_one_is_small() -> None:
    assert len(pickle.dumps(asap.ClusterTracker(1280, 720))) < 5000


def test_an_algorithm_is_new_where_a_used_one_stood() -> None:
    """The extension knows the used ones by their place in memory."""
    for _ in range(100):
        tracker = asap.EFast(20, 10)
        pickle.dumps(tracker)
        tracker.process(EVENTS)
        del tracker


@pytest.mark.parametrize("protocol", PROTOCOLS)
def test_a_gamma_filter_goes_on_where_it_was(protocol: int) -> None:
    made = asap.GammaFilter(seed=2**64 - 1)
    made.apply(EVENTS[:700], 0.3)
    twin = again(made, protocol)
    assert (twin.position, twin.parameters) == (700, {"seed": 2**64 - 1})
    assert same(twin.mask(EVENTS, 0.3), made.mask(EVENTS, 0.3))


@pytest.mark.parametrize(
    "make",
    [
        lambda: profiles.Profile("walk", duration_s=0.2, seed=5),
        lambda: profiles.Profile("high", duration_s=0.1, name="mine", width=20, height=30),
        lambda: profiles.scenario("bursts", "slow", duration_s=0.2).source,
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
    "make",
    [
        lambda: scenes.timing(3, 64, 48, 100.0, seed=2, duration_s=0.1),
        lambda: scenes.corners("fast", duration_s=0.1),
        lambda: scenes.stop_and_go(10.0),
        lambda: scenes.occlusion(50.0),
        lambda: scenes.stop_and_go(10.0).thin(0.3, seed=4),
        lambda: scenes.stop_and_go(10.0).thin(0.3, seed=4).thin(0.5),
    ],
)
def test_scenes(make: Callable[[], Any]) -> None:
    scene = make()
    before = again(scene)
    assert scene.events.size  # made once and kept: not in the pickle
    data = pickle.dumps(scene)
    assert len(data) < 2000
    for twin in (before, pickle.loads(data)):
        assert repr(twin) == repr(scene)
        assert same(twin.events, scene.events) and same(twin.labels, scene.labels)
        assert same(twin.truth(5000.0), scene.truth(5000.0))


def test_a_named_scene() -> None:
    scene = scenes.A(seed=3)
    twin = again(scene)
    assert repr(twin) == repr(scene) and same(next(iter(twin)), next(iter(scene)))
    assert same(twin.truth(5000.0), scene.truth(5000.0))


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
    _, (_, make, _, named) = asap.read(tmp_path / "plain.txt").__reduce__()
    assert make is asap.Recording
    assert {"path", *named} == {*inspect.signature(make).parameters}


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


def test_a_run_with_an_algorithm_of_ours() -> None:
    run = asap.simulate(EVENTS, cost=COST, algorithm=asap.ClusterTracker(20, 10))
    twin = again(run)
    assert equal_runs(twin, run) and repr(twin) == repr(run)
    assert twin.algorithm.state() == run.algorithm.state()


def test_a_run_in_real_time() -> None:
    run = asap.run(EVENTS, algorithm=Counting(), speed=10.0)
    twin = again(run)
    assert equal_runs(twin, run)
    assert twin.lateness.state() == run.lateness.state()


@pytest.mark.parametrize(
    "algorithm",
    [Stubborn(), lambda events: None],
    ids=["stubborn", "lambda"],
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
    assert copy.copy(run).algorithm is algorithm


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


def test_a_keep_curve() -> None:
    scene = scenes.stop_and_go(10.0)
    curve = keep_curve(asap.ClusterTracker, scene, gammas=(1.0, 0.5), seeds=(0,))
    twin = again(curve)
    assert twin.summary() == curve.summary() and repr(twin) == repr(curve)


# ---- refusals -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (asap.Deadline, "Deadline"),
        (lambda: COST, "LinearCost"),
        (lambda: profiles.Profile("high"), "Profile"),
        (scenes.A, "Scene"),
        (lambda: asap.simulate(EVENTS, cost=COST), "Run"),
        (lambda: asap.check(EVENTS), "Inspection"),
    ],
)
def test_another_versions_pickle_is_refused_by_name(
    monkeypatch: pytest.MonkeyPatch, make: Callable[[], Any], name: str
) -> None:
    monkeypatch.setattr(_core, "__version__", "0.0.7")
    data = pickle.dumps(make())
    monkeypatch.undo()
    with pytest.raises(ValueError, match=rf"^pickled {name} = of asap 0\.0\.7: this is asap"):
        pickle.loads(data)


class Derived(asap.Deadline):
    """May have a state of its own."""


class DerivedTracker(asap.ClusterTracker):
    """The same."""


@pytest.mark.parametrize("made", [Derived(), DerivedTracker(20, 10)], ids=type)
def test_a_derived_class_refuses(made: Any) -> None:
    assert not _pickling.can_be_pickled(made)
    with pytest.raises(TypeError, match="pickle"):
        pickle.dumps(made)


def test_a_pickle_is_read_by_a_process_that_knows_nothing(tmp_path: Path) -> None:
    (tmp_path / "run").write_bytes(pickle.dumps(asap.simulate(EVENTS, cost=COST)))
    code = "import pickle, sys; print(repr(pickle.load(open(sys.argv[1], 'rb'))))"
    command = [sys.executable, "-c", code, str(tmp_path / "run")]
    shown = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    assert shown.startswith("<Run: virtual time, deadline")
