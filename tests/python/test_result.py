"""Run: ledger, summary, saving and loading."""

import json
from dataclasses import asdict, replace

import numpy as np
import pytest

import asap
import streams


@pytest.fixture(scope="module")
def run():
    return asap.simulate(
        streams.poisson(8e6, 0.1),
        cost=asap.LinearCost(100, 150),
        scheme=asap.Asap2020(rate_bound=2e6),
        latency_ms=5,
        width=346,
        height=260,
    )


def test_columns_of_the_log(run):
    assert run.packages.dtype.names == (
        "index", "start_us", "processing_us", "t_first", "t_last", "offered", "size", "gamma",
        "event_rate", "rate", "margin_us", "latency_max_us", "stale", "overflow",
    )  # fmt: skip
    rows = run.packages
    assert not rows.flags.writeable
    for name in rows.dtype.names:
        assert np.isfinite(rows[name]).all(), name
    span = rows["t_last"] - rows["t_first"]
    np.testing.assert_allclose(rows["rate"], rows["size"] / np.maximum(span, 1) * 1e6)
    np.testing.assert_allclose(rows["margin_us"], rows["processing_us"] - span, atol=1e-6)
    latest = rows["start_us"] + rows["processing_us"] - rows["t_first"]
    np.testing.assert_allclose(rows["latency_max_us"], latest, atol=1e-3)
    assert (rows["start_us"][1:] >= (rows["start_us"] + rows["processing_us"])[:-1] - 1e-6).all()


def test_ledger_is_attributes_and_mapping(run):
    ledger = run.ledger
    assert list(ledger) == [
        "received", "rejected", "filtered", "discarded", "stale", "overflow", "delivered",
        "pending",
    ]  # fmt: skip
    assert ledger["received"] == ledger.received > 0
    assert ledger.balanced
    assert ledger.discarded > 0
    assert dict(ledger)["delivered"] == run.packages["size"].sum()
    with pytest.raises(AttributeError, match="lost"):
        _ = ledger.lost
    unbalanced = replace(ledger, pending=ledger.pending + 1)
    assert not unbalanced.balanced
    assert not hasattr(type(ledger), "__getattr__")  # a type checker would take any name
    with pytest.raises(KeyError, match="balanced"):
        ledger["balanced"]
    assert {**ledger} == ledger and repr(ledger).startswith("Ledger(received=")


def test_duration_has_no_more_digits_than_the_stamps():
    run = asap.simulate(streams.make([0, 169_941]), cost=asap.LinearCost(1, 1))
    assert json.dumps(run.summary()["source"]["duration_s"]) == "0.169941"
    with asap.Pipeline() as pipeline:
        elapsed_s = pipeline.stats()["source"]["duration_s"]
    assert elapsed_s == round(elapsed_s, 6)


def test_summary_is_the_documented_object(run):
    summary = run.summary()
    assert json.loads(json.dumps(summary, allow_nan=False)) == summary
    assert set(summary) >= {
        "schema_version", "mode", "source", "scheme", "algorithm", "latency_bound_us", "ledger",
        "kept", "in_time", "latency_us", "packages", "gamma", "cpu", "version", "bound_kept",
        "bound_needed_us", "learned_cost", "estimated_cost", "opaque",
    }  # fmt: skip
    assert summary["schema_version"] == 1
    assert summary["mode"] == "virtual"
    assert set(summary["source"]) == {"path", "format", "width", "height", "events", "duration_s"}
    assert summary["source"]["events"] == run.ledger.received
    assert summary["source"]["duration_s"] == pytest.approx(0.1, rel=0.01)
    assert summary["scheme"]["name"] == "asap2020"
    assert summary["scheme"]["rate_bound"] == 2e6
    assert summary["latency_bound_us"] == 5000
    assert summary["kept"] == run.ledger.delivered / run.ledger.received
    assert set(summary["latency_us"]) == {"mean", "p50", "p99", "max"}
    assert summary["packages"]["count"] == run.packages.size
    assert summary["packages"]["per_s"] == pytest.approx(run.packages.size / 0.1, rel=0.01)
    assert summary["gamma"]["min"] == run.packages["gamma"].min() < summary["gamma"]["mean"] < 1
    assert 0 < summary["cpu"] <= 1
    assert summary["version"] == asap.__version__


def test_the_busy_share_is_of_the_time_of_the_replay(run):
    rows = np.zeros(3, run.packages.dtype)
    rows["start_us"], rows["processing_us"] = (0, 1000, 2000), 250.0
    rows["size"] = rows["gamma"] = 1
    twice = replace(run, packages=rows, speed=2.0)
    assert twice.summary()["cpu"] == pytest.approx(750 / (1000 + 250))


@pytest.mark.parametrize("whole", [np.int64, np.uint16])
def test_numpys_numbers_are_plain_in_every_summary(whole):
    events, cost = streams.poisson(1e5, 0.01), asap.LinearCost(100, 300)
    size = {"width": whole(346), "height": whole(260)}
    speed = np.float32(2)
    for found in (
        asap.simulate(events, cost=cost, seed=whole(1), **size),
        asap.run(events, algorithm=lambda events: None, speed=speed, **size),
        asap.compare(events, cost=cost, seed=whole(1), speed=speed, latency_ms=whole(9), **size),
        asap.check(events, **size),
    ):
        json.dumps(found.summary())
    json.dumps(asap.Pipeline(**size).stats())


class Net:
    """As a torch.nn.Module: what has a meaning here is something else there."""

    def __call__(self, events):
        pass

    def parameters(self):
        return iter(())

    def name(self):
        return "net"


def test_name_and_parameters_may_be_methods_of_a_users_algorithm():
    run = asap.simulate(streams.make([1]), cost=asap.LinearCost(100, 300), algorithm=Net())
    assert run.summary()["algorithm"] == {"name": "Net"}


def test_any_parameters_of_a_users_algorithm_are_saved(tmp_path):
    algorithm = Net()
    algorithm.name, algorithm.parameters = "mine", {
        "name": "x", "window": np.int64(3), "rates": np.ones(2), "late": np.nan, "kind": Net,
    }  # fmt: skip
    run = asap.simulate(streams.make([1]), cost=asap.LinearCost(100, 300), algorithm=algorithm)
    run.save(tmp_path / "run.json")
    expected = {"name": "mine", "window": 3, "rates": [1, 1], "late": None, "kind": str(Net)}
    assert asap.load_run(tmp_path / "run.json").summary()["algorithm"] == expected


def of_cost(alpha_us, scheme=None, **options):
    return asap.simulate(
        streams.poisson(1e5, 0.5), cost=asap.LinearCost(alpha_us, 300), scheme=scheme, **options
    )


@pytest.mark.parametrize("scheme", [asap.Deadline, asap.DeadBeat, asap.Greedy])
def test_a_bound_below_the_fixed_cost_is_reported(scheme, tmp_path):
    learns = scheme is not asap.Greedy
    parameters = {"latency_ms": 10} if learns else {"efficiency": 0.97}
    late = of_cost(11_000, scheme(**parameters), latency_ms=10, opaque=True)
    summary = late.summary()
    assert late.bound_kept is summary["bound_kept"] is False
    assert late.latency.max > 1.01 * 10_000
    assert summary["bound_needed_us"] == pytest.approx(27_500, rel=0.01)
    if learns:
        assert summary["learned_cost"]["alpha_us"] == pytest.approx(11_000, rel=0.01)
    else:
        assert summary["learned_cost"] is None
    late.save(tmp_path / "late.json")
    assert asap.load_run(tmp_path / "late.json").summary() == summary


@pytest.mark.parametrize("opaque", [True, False])
def test_the_summary_has_the_cost_of_the_verdict(opaque, tmp_path):
    events, cost = streams.poisson(1e6, 0.2), asap.LinearCost(100, 300, noise=0.1)
    run = asap.simulate(events, cost=cost, opaque=opaque)
    summary = run.summary()
    assert run.opaque is summary["opaque"] is opaque
    assert summary["estimated_cost"] == asdict(asap.analysis.fit_cost(run))
    assert summary["estimated_cost"] == asdict(asap.analysis.diagnose(run).cost)
    for name in ("run.npz", "run.json"):
        again = asap.load_run(run.save(tmp_path / name))
        assert again.opaque is opaque
        assert again.summary() == summary
    called = asap.run(events[:1000], algorithm=lambda events: None)
    native = asap.run(events[:1000], algorithm=asap.EFast(346, 260))
    assert (called.opaque, native.opaque) == (True, False)


@pytest.mark.parametrize(("late", "kept"), [(1.0, True), (1.009, True), (1.011, False)])
def test_a_bound_is_kept_to_one_in_a_hundred(run, late, kept):
    assert replace(run, latency_bound_us=run.latency.max / late).bound_kept is kept


def test_a_bound_that_was_kept_needs_no_other():
    in_time = of_cost(4200).summary()  # 2.5 alpha > L, but the load is low
    assert in_time["bound_kept"] is True
    assert in_time["bound_needed_us"] is None


def test_a_bound_missed_for_another_reason_needs_no_other():
    run = asap.simulate(
        streams.poisson(1e5, 0.5),
        cost=asap.LinearCost(100, 300, outages_ms=[(100, 200)]),
        scheme=asap.Greedy(),
    )
    assert not run.bound_kept
    assert run.summary()["bound_needed_us"] is None


def test_a_run_keeps_what_its_scheme_had_learned_then():
    scheme = asap.Deadline()
    first = of_cost(500, scheme)
    before = first.summary()
    of_cost(1000, scheme)
    assert scheme.alpha_us == pytest.approx(1000, rel=0.01)
    assert first.summary() == before
    assert before["learned_cost"]["alpha_us"] == pytest.approx(500, rel=0.01)


def test_save_and_load(run, tmp_path):
    again = asap.load_run(run.save(tmp_path / "run.npz"))
    assert again.summary() == run.summary()
    np.testing.assert_array_equal(again.packages, run.packages)
    for q in (0, 0.1, 0.5, 0.99, 1):
        assert again.latency.quantile(q) == run.latency.quantile(q)
    assert again.in_time == run.in_time
    assert again.ledger == run.ledger
    assert str(again) == str(run)


def test_shows_itself_on_one_line_and_is_itself(run, tmp_path):
    assert repr(run).startswith("<Run: virtual time, asap2020, ")
    assert f"kept {run.kept:.4g}" in repr(run)
    assert "\n" not in repr(run)
    assert run == run
    run.save(tmp_path / "run.json")
    assert asap.load_run(tmp_path / "run.json") != run  # compare summaries


@pytest.mark.parametrize(
    "content", ["", "[]", "{}", '{"schema_version": 99}', "\x00\x01", '{"rows": 3}']
)
def test_what_is_no_run_is_refused(content, tmp_path):
    path = tmp_path / "other.json"
    path.write_text(content)
    with pytest.raises(ValueError, match="not a run that asap has saved"):
        asap.load_run(path)


def test_latency_quantiles(run):
    latency = run.latency
    values = [latency.quantile(q) for q in np.linspace(0, 1, 50)]
    assert values == sorted(values)
    assert values[-1] == latency.max
    with pytest.raises(ValueError, match=r"q = 1\.5"):
        latency.quantile(1.5)


def test_plot_and_report(run, tmp_path):
    pytest.importorskip("matplotlib")
    figure = run.plot()
    assert len(figure.axes) >= 4
    run.report(tmp_path / "run.html")
    assert "</html>" in (tmp_path / "run.html").read_text()


def test_schemes_show_name_and_parameters():
    assert asap.Asap2020().parameters == {
        "rate_bound": 5e6, "epsilon": 0.05, "first_size": 1000, "max_size": 50_000, "min_size": 1,
    }  # fmt: skip
    assert asap.FixedSize(size=3).parameters == {"size": 3}
    assert asap.FixedTime().parameters == {"period_ms": 1.0}
    assert [s.name for s in (asap.Greedy(), asap.SingleEvent())] == ["greedy", "single_event"]
    assert repr(asap.FixedSize(size=3)) == "FixedSize(size=3)"
    with pytest.raises(TypeError):
        asap.FixedSize(3)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: asap.FixedSize(size=0), "size = 0"),
        (lambda: asap.FixedSize(size=-1), "size = -1"),
        (lambda: asap.FixedSize(size=2**64), "size = 18446744073709551616"),
        (lambda: asap.Asap2020(max_size=-5), "max_size = -5"),
        (lambda: asap.GammaFilter(seed=-1), "seed = -1"),
        (lambda: asap.LinearCost(1, 1, seed=2**64), "seed = 18446744073709551616"),
        (lambda: asap.ClusterTracker(346, 260, engine="compat", seed=-1), "seed = -1"),
        (lambda: asap.FixedTime(period_ms=0), "period_ms = 0"),
        (lambda: asap.FixedTime(period_ms=float("nan")), "period_ms = nan"),
        (lambda: asap.Asap2020(rate_bound=0), "rate_bound = 0"),
        (lambda: asap.Asap2020(epsilon=1), "epsilon = 1"),
        (lambda: asap.Asap2020(first_size=10, max_size=5), "first_size|max_size"),
        (lambda: asap.LinearCost(-1, 0), "alpha_us = -1"),
        (lambda: asap.LinearCost(1, float("inf")), "beta_ns = inf"),
        (lambda: asap.LinearCost(1, 1, noise=-0.1), "noise = -0.1"),
        (lambda: asap.GammaFilter().apply(streams.make([1]), 1.1), "gamma = 1.1"),
        (lambda: asap.GammaFilter().mask(streams.make([1]), float("nan")), "gamma = nan"),
    ],
)
def test_bad_configuration_names_field_and_value(make, message):
    with pytest.raises(ValueError, match=message):
        make()
