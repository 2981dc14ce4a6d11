"""asap.simulate: virtual time, from Python, against an independent simulation in plain Python."""

import hashlib

import numpy as np
import pytest

import asap
import streams


def digest(run):
    columns = [run.packages[name] for name in run.packages.dtype.names]
    return hashlib.sha256(b"".join(column.tobytes() for column in columns)).hexdigest()


COST = asap.LinearCost(alpha_us=100, beta_ns=300)


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


# ---- speed ----------------------------------------------------------------------------------


@pytest.mark.parametrize("execution", ["anytime", "whole"])
def test_at_a_speed_it_is_the_run_of_the_compressed_stamps(execution):
    """But for what is on the recording's axis: t_first, t_last, start_us."""
    slow = streams.poisson(0.1e6, 1.0)
    slow["t"] = slow["t"] // 10 * 10  # so that no compressed stamp is rounded
    fast = slow.copy()
    fast["t"] //= 10
    options = {"cost": asap.LinearCost(200, 1500), "latency_ms": 5, "execution": execution}
    found = asap.simulate(slow, speed=10, **options)
    given = asap.simulate(fast, **options)
    assert 0.2 < given.kept < 0.9
    for name in found.packages.dtype.names:
        factor = 10 if name in ("start_us", "t_first", "t_last") else 1
        np.testing.assert_allclose(found.packages[name], factor * given.packages[name], atol=1e-3)
    assert (found.speed, given.speed) == (10, 1)
    assert found.latency.state() == given.latency.state()
    assert found.ledger == given.ledger and found.gap_us == given.gap_us
    same = ("packages", "latency_us", "gap_us", "cpu", "kept", "in_time")
    summaries = found.summary(), given.summary()
    assert [summaries[0][name] for name in same] == [summaries[1][name] for name in same]
    assert "virtual time at" in str(found)


@pytest.mark.parametrize("speed", [0, -1, float("nan"), 1e7])
def test_a_speed_out_of_range_is_refused(speed):
    with pytest.raises(ValueError, match=r"^speed = .*: must be between 0.001 and 1e6"):
        asap.simulate(streams.poisson(1e5, 0.01), cost=asap.LinearCost(1, 1), speed=speed)


# ---- a cost of one's own --------------------------------------------------------------------


@pytest.mark.parametrize("execution", ["anytime", "whole"])
@pytest.mark.parametrize("speed", [1, 2])
def test_a_callable_is_the_cost_that_it_returns(execution, speed):
    events = streams.poisson(0.3e6, 0.3)
    options = {"latency_ms": 2, "execution": execution, "speed": speed, "seed": 3}
    found = asap.simulate(events, cost=lambda n, t_us: 200 + 5 * n, **options)
    linear = asap.simulate(events, cost=asap.LinearCost(200, 5000), **options)
    assert len(found.packages) > 20 and 0.2 < found.kept < 0.8
    assert found.packages["size"].tolist() == linear.packages["size"].tolist()
    np.testing.assert_allclose(
        found.packages["processing_us"], linear.packages["processing_us"], atol=0.02
    )


def test_a_callable_is_told_size_and_start_of_each_package():
    events, calls = streams.poisson(0.3e6, 0.3), []

    def cost(n, t_us):
        calls.append((n, t_us))
        return 100 if t_us < 100_000 else 5000

    run = asap.simulate(events, cost=cost, latency_ms=20, execution="whole", scheme=asap.Greedy())
    assert [n for n, _ in calls] == run.packages["size"].tolist()
    np.testing.assert_allclose([t for _, t in calls], run.packages["start_us"], atol=0.01)
    late = run.packages["start_us"] >= 100_000
    assert set(run.packages["processing_us"][late]) == {5000}
    assert set(run.packages["processing_us"][~late]) == {100}
    assert run.summary()["algorithm"]["name"] == "cost"


@pytest.mark.parametrize(
    ("value", "error", "shown"),
    [
        (float("nan"), ValueError, "nan"),
        (float("inf"), ValueError, "inf"),
        (-1.5, ValueError, "-1.5"),
        (None, TypeError, "None"),
        ("long", TypeError, "'long'"),
    ],
)
def test_a_value_that_is_no_time_is_named_with_its_call(value, error, shown):
    events = streams.make(7_000_000 + np.zeros(5, int))
    with pytest.raises(error, match=rf"^cost\(5, 7000000\) = {shown}: "):
        asap.simulate(events, cost=lambda n, t_us: value, execution="whole", scheme=asap.Greedy())


def test_an_error_of_the_cost_comes_out_unchanged():
    error = ZeroDivisionError("mine")

    def cost(n, t_us):
        raise error

    with pytest.raises(ZeroDivisionError) as caught:
        asap.simulate(streams.poisson(1e5, 0.1), cost=cost)
    assert caught.value is error
    assert asap.last_run().ledger.balanced


def test_what_foresees_the_cost_refuses_a_callable():
    events = streams.poisson(1e5, 0.01)
    for call in (asap.compare, asap.oracle):
        with pytest.raises(TypeError, match=r"give asap\.LinearCost.*asap\.simulate takes any"):
            call(events, cost=lambda n, t_us: 5, latency_ms=10)


# ---- the seed -------------------------------------------------------------------------------


def test_the_seed_stands_in_summary_table_and_file(tmp_path):
    run = asap.simulate(streams.poisson(1e5, 0.01), cost=asap.LinearCost(1, 1), seed=2**64 - 1)
    assert run.seed == run.summary()["seed"] == asap.table([run])[0]["seed"] == 2**64 - 1
    assert f"seed {2**64 - 1}" in str(run)
    for name in ("run.npz", "run.json"):
        assert asap.load_run(run.save(tmp_path / name)).seed == 2**64 - 1
    assert asap.run(streams.poisson(1e5, 0.01), algorithm=len, seed=5).seed == 5
    assert asap.Pipeline(seed=5).stats()["seed"] == 5
