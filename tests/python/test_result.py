"""Run: ledger, summary, saving, loading, tables."""

import csv
import io
import json
import sys
from dataclasses import replace
from types import SimpleNamespace

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


def test_summary_is_the_documented_object(run):
    summary = run.summary()
    assert json.loads(json.dumps(summary, allow_nan=False)) == summary
    assert set(summary) >= {
        "schema_version", "mode", "source", "scheme", "algorithm", "latency_bound_us", "ledger",
        "kept", "in_time", "latency_us", "packages", "gamma", "cpu", "version", "bound_kept",
        "bound_needed_us", "learned_cost", "estimated_cost", "execution",
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


def of_cost(alpha_us, scheme=None, **options):
    return asap.simulate(
        streams.poisson(1e5, 0.5), cost=asap.LinearCost(alpha_us, 300), scheme=scheme, **options
    )


@pytest.mark.parametrize("scheme", [asap.Deadline, asap.DeadBeat, asap.Greedy])
def test_a_bound_below_the_fixed_cost_is_reported(scheme, tmp_path):
    learns = scheme is not asap.Greedy
    parameters = {"latency_ms": 10} if learns else {"efficiency": 0.97}
    late = of_cost(11_000, scheme(**parameters), latency_ms=10, execution="whole")
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


def test_a_run_keeps_what_its_scheme_had_learned_then():
    scheme = asap.Deadline()
    first = of_cost(500, scheme)
    before = first.summary()
    of_cost(1000, scheme)
    assert scheme.alpha_us == pytest.approx(1000, rel=0.01)
    assert first.summary() == before
    assert before["learned_cost"]["alpha_us"] == pytest.approx(500, rel=0.01)


# ---- as tables: pandas is no dependency, so a stand-in shows what it gets ---------------------

EVENTS = streams.make(np.arange(0, 20_000, 10))
COST = asap.LinearCost(100, 300)


@pytest.fixture
def pandas(monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", SimpleNamespace(DataFrame=lambda given: given))


def runs():
    bounds = (5, 10)
    return [asap.simulate(EVENTS, cost=COST, latency_ms=bound) for bound in bounds]


def test_a_table_has_a_flat_row_for_each_run(tmp_path):
    found = runs()
    rows = asap.table(found)
    assert [row["latency_bound_us"] for row in rows] == [5000, 10_000]
    for row, run in zip(rows, found, strict=True):
        summary = run.summary()
        assert row["ledger.received"] == EVENTS.size
        assert row["latency_us.p99"] == summary["latency_us"]["p99"]
        assert row["scheme.prefer"] == "balanced"
        assert not any(isinstance(value, dict) for value in row.values())
    csv.DictWriter(io.StringIO(), rows[0]).writerows(rows)
    found[0].save(tmp_path / "run.json")
    assert asap.table([asap.load_run(tmp_path / "run.json")])[0]["kept"] == rows[0]["kept"]


@pytest.mark.parametrize("given", [5, "x", None, [ValueError("failed")], runs()[0]])
def test_what_is_no_list_of_runs_is_refused(given):
    with pytest.raises(TypeError, match=r"^runs = "):
        asap.table(given)


def test_pandas_gets_the_packages_of_a_run(pandas):
    run = runs()[0]
    columns = run.to_pandas()
    assert list(columns) == list(run.packages.dtype.names)
    assert columns["size"].tolist() == run.packages["size"].tolist()


def test_pandas_gets_a_row_for_each_scheme(pandas):
    comparison = asap.compare(EVENTS, cost=COST)
    rows = comparison.to_pandas()
    assert [row["label"] for row in rows] == list(comparison)
    assert rows[0]["score"] == comparison.rows[0].score


def test_without_pandas_it_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match="pandas"):
        runs()[0].to_pandas()
