"""asap.simulate: virtual time, from Python, against an independent simulation in plain Python."""

import hashlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import asap
import streams


def digest(run):
    columns = [run.packages[name] for name in run.packages.dtype.names]
    return hashlib.sha256(b"".join(column.tobytes() for column in columns)).hexdigest()


COST = asap.LinearCost(alpha_us=100, beta_ns=300)


class PlainSimulation:
    """Virtual time in its plainest form: a list of arrivals, one decision after the other.

    Independent of the library: no ring, no packager, times in exact integers (ns).
    """

    def __init__(self, events, decide, alpha_ns, beta_ns, bound_ns):
        self.t = [int(t) * 1000 for t in events["t"]]
        self.decide, self.alpha, self.beta, self.bound = decide, alpha_ns, beta_ns, bound_ns

    def run(self):
        rows, head, now = [], 0, self.t[0]
        while head < len(self.t):
            # The earliest moment from `now` on at which the scheme takes something.
            moments = sorted({now, self.t[head] + self.bound, *self.t[head:]})
            for moment in moments:
                if moment < now or moment < self.t[head]:
                    continue
                arrived = sum(1 for t in self.t[head:] if t <= moment)
                due = moment >= self.t[head] + self.bound or head + arrived == len(self.t)
                taken = self.decide(self.t[head : head + arrived], moment, due)
                if taken:
                    break
            span = self.t[head + taken - 1] - self.t[head]
            cost = self.alpha + self.beta * taken
            rows.append((moment, cost, self.t[head], self.t[head + taken - 1], taken, span))
            head += taken
            now = moment + cost
        return rows


def fixed_size(size):
    return lambda waiting, now, due: min(size, len(waiting)) if due or len(waiting) >= size else 0


def greedy(waiting, now, due):
    return len(waiting)


def fixed_time(period_ns):
    def decide(waiting, now, due):
        boundary = (waiting[0] // period_ns + 1) * period_ns
        return sum(1 for t in waiting if t < boundary) if due or now >= boundary else 0

    return decide


@settings(max_examples=30, deadline=None)
@given(
    gaps=st.lists(st.integers(0, 3000), min_size=1, max_size=60),
    which=st.sampled_from(["fixed_size", "greedy", "single_event"]),
    size=st.integers(1, 20),
)
def test_equals_a_plain_simulation(gaps, which, size):
    events = streams.make(np.cumsum(gaps))
    schemes = {
        "fixed_size": (asap.FixedSize(size=size), fixed_size(size)),
        "greedy": (asap.Greedy(), greedy),
        "single_event": (asap.SingleEvent(), lambda waiting, now, due: 1),
    }
    scheme, decide = schemes[which]
    run = asap.simulate(events, cost=COST, scheme=scheme, latency_ms=10)
    expected = PlainSimulation(events, decide, 100_000, 300, 10_000_000).run()
    got = run.packages
    assert got["size"].tolist() == [row[4] for row in expected]
    np.testing.assert_allclose(got["start_us"], [row[0] / 1e3 for row in expected])
    np.testing.assert_allclose(got["processing_us"], [row[1] / 1e3 for row in expected])
    assert (got["t_first"] * 1000).tolist() == [row[2] for row in expected]
    assert (got["t_last"] * 1000).tolist() == [row[3] for row in expected]
    packages = np.split(events["t"], np.cumsum(got["size"])[:-1])
    latencies = [
        row[0] + row[1] - 1000 * int(t)
        for row, ts in zip(expected, packages, strict=True)
        for t in ts
    ]
    assert run.latency.mean == pytest.approx(np.mean(latencies) / 1e3)
    assert run.latency.max == pytest.approx(max(latencies) / 1e3)
    assert run.latency.within_bound == sum(value <= 10_000_000 for value in latencies)


def test_fixed_time_cuts_at_multiples_of_the_period():
    # 2.5 ms of events every 100 us, from 1.3 ms on; the first period is not whole.
    events = streams.make(np.arange(1300, 3800, 100))
    run = asap.simulate(events, cost=asap.LinearCost(1, 0), scheme=asap.FixedTime(period_ms=1))
    assert run.packages["t_first"].tolist() == [1300, 2000, 3000]
    assert run.packages["t_last"].tolist() == [1900, 2900, 3700]
    # Taken as soon as the period is over; the last one when the recording is.
    assert run.packages["start_us"].tolist() == [2000, 3000, 3700]


def test_log_columns_by_hand():
    # Four events; Greedy takes the first at once, then what has arrived meanwhile.
    events = streams.make([1000, 1050, 1100, 5000])
    run = asap.simulate(events, cost=asap.LinearCost(100, 1000), scheme=asap.Greedy())
    rows = run.packages
    assert rows["size"].tolist() == [1, 2, 1]
    assert rows["offered"].tolist() == [1, 2, 1]
    assert rows["start_us"].tolist() == [1000, 1101, 5000]
    assert rows["processing_us"].tolist() == [101, 102, 101]
    assert rows["margin_us"].tolist() == [101, 102 - 50, 101]
    assert rows["latency_max_us"].tolist() == [101, 1203 - 1050, 101]
    assert rows["rate"].tolist() == [1e6, 2 / 50e-6, 1e6]
    assert rows["gamma"].tolist() == [1, 1, 1]
    assert rows["index"].tolist() == [0, 1, 2]
    assert run.latency.count == 4
    assert run.latency.mean == pytest.approx((101 + 153 + 103 + 101) / 4)
    assert run.kept == run.in_time == 1


@pytest.mark.parametrize(
    "scheme", [asap.Asap2020(), asap.FixedSize(), asap.FixedTime(), asap.Greedy()], ids=repr
)
def test_is_repeatable_and_independent_of_the_cut(scheme):
    events = streams.poisson(3e6, 0.2)
    whole = asap.simulate(events, cost=COST, scheme=scheme, seed=5)
    rng = np.random.default_rng(1)
    cuts = np.sort(rng.integers(0, events.size, 300))
    pieces = asap.simulate(iter(np.split(events, cuts)), cost=COST, scheme=scheme, seed=5)
    assert digest(whole) == digest(pieces)
    assert whole.ledger == pieces.ledger
    assert whole.packages.size > 10


def test_seed_decides_what_is_discarded():
    events = streams.poisson(8e6, 0.1)
    scheme = asap.Asap2020(rate_bound=1e6)
    runs = [asap.simulate(events, cost=COST, scheme=scheme, seed=seed) for seed in (0, 0, 1)]
    assert runs[0].ledger.discarded > 0
    assert digest(runs[0]) == digest(runs[1]) != digest(runs[2])


def test_noise_of_the_cost_is_lognormal_with_mean_1():
    events = streams.poisson(1e6, 0.5)
    cost = asap.LinearCost(100, 0, noise=0.5, seed=3)
    run = asap.simulate(events, cost=cost, scheme=asap.FixedSize(size=100))
    factor = run.packages["processing_us"] / 100
    assert factor.size > 4000
    assert factor.mean() == pytest.approx(1, abs=0.03)
    assert np.log(factor).std() == pytest.approx(0.5, abs=0.02)


def test_overflow_is_counted_exactly():
    events = streams.poisson(5e6, 0.1)
    run = asap.simulate(
        events, cost=asap.LinearCost(1000, 1000), scheme=asap.Greedy(), capacity=1000
    )
    assert run.ledger.overflow > 0
    assert run.ledger.balanced
    assert run.ledger.delivered == run.packages["size"].sum() == run.latency.count
    assert run.packages["overflow"].sum() <= run.ledger.overflow
    assert run.packages["size"].max() <= 1000


def test_algorithm_gets_every_package():
    events = streams.poisson(2e6, 0.1)
    got, keeps = [], []

    class Algorithm:
        def process(self, events):
            got.append(events)

        def set_keep(self, gamma):
            keeps.append(gamma)

    run = asap.simulate(events, cost=COST, algorithm=Algorithm())
    assert [package.size for package in got] == run.packages["size"].tolist()
    assert len(keeps) == len(got)
    assert run.kept == 1
    # Arrays that were kept are still what they were: nothing is overwritten.
    for name in "xypt":
        np.testing.assert_array_equal(np.concatenate([g[name] for g in got]), events[name])
    assert not got[0].flags.writeable


def test_keep_is_smoothed_over_about_20_ms():
    events = streams.poisson(10e6, 0.2)
    keeps = []

    class Algorithm:
        def process(self, events):
            pass

        def set_keep(self, gamma):
            keeps.append(gamma)

    run = asap.simulate(
        events, cost=COST, algorithm=Algorithm(), scheme=asap.Asap2020(rate_bound=1e6)
    )
    keeps = np.array(keeps)
    assert keeps[0] == 1
    assert np.abs(np.diff(keeps)).max() < np.abs(np.diff(run.packages["gamma"])).max()
    assert keeps[-1] == pytest.approx(run.packages["gamma"][-50:].mean(), rel=0.1)


def test_exception_of_the_algorithm_comes_out_unchanged():
    class Broken(Exception):
        pass

    calls = []

    def algorithm(events):
        calls.append(events.size)
        if len(calls) == 3:
            raise Broken("third")

    events = streams.poisson(1e6, 0.1)
    with pytest.raises(Broken, match="third"):
        asap.simulate(events, cost=COST, algorithm=algorithm)
    run = asap.last_run()
    assert run.ledger.balanced
    assert run.ledger.delivered == sum(calls[:2]) == run.packages["size"].sum()
    assert run.ledger.pending > 0


def test_exception_of_the_source_comes_out_unchanged():
    def source():
        yield streams.poisson(1e6, 0.01)
        raise OSError("unplugged")

    with pytest.raises(OSError, match="unplugged"):
        asap.simulate(source(), cost=COST)
    assert asap.last_run().ledger.balanced
    assert asap.last_run().ledger.received > 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"latency_ms": 0}, "latency_ms = 0"),
        ({"latency_ms": float("nan")}, "latency_ms = nan"),
        ({"capacity": 0}, "capacity = 0"),
        ({"seed": -1}, "seed = -1"),
        ({"on_bad": "ignore"}, "on_bad = 'ignore'"),
        ({"width": -3}, "width = -3"),
        ({"seed": 2**64}, "seed = 18446744073709551616"),
        ({"algorithm": 7}, "algorithm"),
        ({"scheme": "greedy"}, "scheme = 'greedy'"),
        ({"cost": 5}, "cost = 5"),
    ],
)
def test_bad_arguments_are_named(arguments, message):
    with pytest.raises((ValueError, TypeError), match=message):
        asap.simulate(streams.make([1, 2, 3]), **{"cost": COST, **arguments})


def test_nothing_received():
    run = asap.simulate(streams.make([]), cost=COST)
    assert run.kept == run.in_time == 1
    assert run.packages.size == 0
    assert run.summary()["latency_us"] == {"mean": 0, "p50": 0, "p99": 0, "max": 0}
    assert "100.0 %" in str(run)


def test_quiet_scene_never_waits_on_a_count():
    # One burst of 10 events, then silence for a second: 990 are missing for a package.
    events = streams.make([*range(0, 100, 10), 1_000_000])
    for scheme in (asap.FixedSize(size=1000), asap.Asap2020(), asap.FixedTime(period_ms=500)):
        run = asap.simulate(events, cost=COST, scheme=scheme, latency_ms=10)
        assert run.packages["size"][0] == 10
        assert run.packages["start_us"][0] == 10_000


@pytest.mark.parametrize("kind", [list, tuple, iter, lambda chunks: (c for c in chunks)])
def test_source_may_be_any_iterable_of_arrays(kind):
    events = streams.poisson(1e5, 0.1)
    run = asap.simulate(kind([events[:100], None, events[100:]]), cost=COST)
    assert run.ledger.delivered == events.size


def test_source_may_be_columns_or_a_foreign_layout():
    events = streams.poisson(1e5, 0.1)
    columns = [events[name] for name in "txyp"]
    foreign = np.zeros(events.size, [("t", "<u8"), ("x", "<u2"), ("y", "<u2"), ("on", "?")])
    for name, other in zip("txyp", ("t", "x", "y", "on"), strict=True):
        foreign[other] = events[name]
    for source in (columns, tuple(columns), dict(zip("txyp", columns, strict=True)), foreign):
        assert asap.simulate(source, cost=COST).ledger.delivered == events.size


def test_the_width_of_a_table_is_not_that_of_a_sensor():
    class Frame(dict):
        columns, width, height = property(list), 4, 10

    events = streams.poisson(1e5, 0.01)
    frame = Frame({name: events[name] for name in "txyp"})
    run = asap.simulate(frame, cost=COST)
    assert (run.source["width"], run.source["height"]) == (None, None)
    assert run.ledger.delivered == events.size


def test_in_time_counts_what_came_within_the_bound():
    # Two packages of one event; the second waits 900 us for the first.
    events = streams.make([0, 100])
    cost = asap.LinearCost(1000, 0)
    run = asap.simulate(events, cost=cost, scheme=asap.Greedy(), latency_ms=1.5)
    assert (run.kept, run.in_time) == (1, 0.5)
    assert run.latency.max == 1900


def test_rejections_of_reader_and_run_add_up(tmp_path):
    path = tmp_path / "events.csv"
    path.write_text("0,1,1,1\n10,400,1,1\ngarbage\n20,2,2,0\n")
    recording = asap.read(path)  # without a sensor: positions are not checked yet
    run = asap.simulate(recording, cost=COST, width=346, height=260)
    assert run.rejected["bad_record"] == run.rejected["out_of_bounds"] == 1
    assert run.ledger.rejected == 2
    assert run.ledger.received == 4
    assert run.ledger.balanced


@pytest.mark.parametrize("opaque", [False, True])
def test_the_mask_leads_back_to_the_users_array(opaque):
    events = streams.poisson(6e6, 0.03, seed=4)
    events["x"] = np.arange(events.size) % 400  # a fifth lies outside the sensor
    got = []
    run = asap.simulate(
        events,
        cost=COST,
        latency_ms=5,
        algorithm=lambda package: got.append(package.copy()),
        opaque=opaque,
        width=320,
        height=65536,
        keep_mask=True,
    )
    assert run.ledger.rejected > 0 and run.ledger.discarded > 0
    assert run.kept_mask.shape == events.shape and not run.kept_mask.flags.writeable
    np.testing.assert_array_equal(events[run.kept_mask], np.concatenate(got))

    first, size = run.packages["first"], run.packages["size"]
    kept = np.flatnonzero(run.kept_mask)
    begin = np.cumsum(size) - size  # of each package, among the kept
    assert (first <= kept[begin]).all()
    assert (first[1:] > kept[begin[1:] - 1]).all()
    assert (events["t"][kept[begin]] == run.packages["t_first"]).all()


def test_no_mask_unless_asked():
    run = asap.simulate(streams.poisson(1e5, 0.01, seed=1), cost=COST)
    assert run.kept_mask is None
    assert "first" not in run.packages.dtype.names


def test_a_saved_run_knows_where_its_packages_begin(tmp_path):
    run = asap.simulate(streams.poisson(1e6, 0.005, seed=1), cost=COST, keep_mask=True)
    run.save(tmp_path / "run.npz")
    loaded = asap.load_run(tmp_path / "run.npz")
    np.testing.assert_array_equal(loaded.packages, run.packages)
    assert loaded.kept_mask is None


def test_a_bad_event_in_front_sets_no_time(tmp_path):
    """An array and its file are one source: of the same events and of the same duration."""
    events = streams.make([-(10**15), 10, 20, 30, 40], x=[999, 1, 2, 3, 4])
    path = tmp_path / "events.npy"
    np.save(path, events)
    late = np.concatenate([events[:1]] * 1000 + [events[1:]])
    for source, received in (
        (events, 5),
        (path, 5),
        (iter([events[:1], events[1:]]), 5),
        (late, 1004),
    ):
        run = asap.simulate(source, cost=COST, width=346, height=260)
        found = run.summary()
        assert (found["source"]["events"], found["ledger"]["received"]) == (received, received)
        assert found["source"]["duration_s"] == pytest.approx(30e-6)
        assert found["packages"]["per_s"] == pytest.approx(run.packages.size / 30e-6)
    clamped = asap.simulate(events[1:], cost=COST, width=2, height=260, on_bad="clamp")
    assert clamped.source["duration_s"] == pytest.approx(30e-6)
    nothing = asap.simulate(events[:1], cost=COST, width=346, height=260)
    assert (nothing.source["events"], nothing.source["duration_s"]) == (1, 0)
