"""Runs and comparisons as tables; pandas is no dependency, so a stand-in shows what it gets."""

import csv
import io
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import asap
import streams

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
