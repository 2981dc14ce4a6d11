"""Pipeline(telemetry=...): one row a package in a file, which never holds the pipeline up."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
import streams
from asap.experiment import telemetry

SENSOR = {"width": 20, "height": 10}
LONG_MS = 1000.0  # a bound that a busy machine keeps


@pytest.fixture(autouse=True)
def every_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(telemetry, "_EVERY_S", 0.0)
    monkeypatch.setattr(telemetry, "_WAITING", 100)


def piped(path: Path, algorithm: Any = None, packages: int = 30) -> asap.Pipeline:
    """Run a pipeline that gets this many packages of ten events, and one event that it rejects."""
    events = streams.make(np.arange(packages * 10) * 100, x=3, y=4)
    scheme = asap.FixedSize(size=10)
    pipeline = asap.Pipeline(algorithm, scheme=scheme, telemetry=path, latency_ms=LONG_MS, **SENSOR)
    with pipeline:
        pipeline.push(events)
        pipeline.push(streams.make([10**6], x=30, y=4))
        pipeline.stop()
        if algorithm is None:
            assert sum(1 for _ in pipeline) == packages
        else:
            pipeline.run()
    return pipeline


def rows_in(path: Path) -> np.ndarray:
    return np.genfromtxt(path, telemetry.TELEMETRY_DTYPE, delimiter=",", skip_header=1)


@pytest.mark.parametrize("algorithm", [None, len, asap.EFast(20, 10)])
def test_each_package_has_a_row_and_the_ledger(tmp_path: Path, algorithm: Any) -> None:
    pipeline = piped(tmp_path / "rows.csv", algorithm)
    rows = rows_in(tmp_path / "rows.csv")
    for name in pipeline.packages.dtype.names:
        np.testing.assert_allclose(rows[name], pipeline.packages[name], rtol=1e-14)
    names = (tmp_path / "rows.csv").read_text().partition("\n")[0].split(",")
    assert tuple(names) == rows.dtype.names
    ends = sum(rows[f"all_{name}"] for name in pipeline.ledger if name != "received")
    np.testing.assert_array_equal(rows["all_received"], ends)
    last = rows[-1]
    assert {name: last[f"all_{name}"] for name in pipeline.ledger} == dict(pipeline.ledger)
    assert last["all_rejected"] == 1 and last["latency_bound_us"] == LONG_MS * 1e3
    assert pipeline.stats()["telemetry"] == {
        "path": str(tmp_path / "rows.csv"),
        "written": 30,
        "lost": 0,
    }


def test_a_stalled_disk_loses_rows_and_counts_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(telemetry, "_WAITING", 3)
    monkeypatch.setattr(telemetry, "_PATIENCE_S", 0.01)
    disk, append = threading.Event(), telemetry.TelemetryFile._append

    def when_it_works(file: Any, rows: Any) -> None:
        assert disk.wait(60)
        append(file, rows)

    monkeypatch.setattr(telemetry.TelemetryFile, "_append", when_it_works)
    pipeline = piped(tmp_path / "rows.csv")  # comes to its end
    (writer,) = (one for one in threading.enumerate() if one.name == "asap telemetry")
    disk.set()
    writer.join(60)
    stats = pipeline.stats()["telemetry"]
    assert stats["lost"] + stats["written"] == 30 == pipeline.stats()["packages"]["count"]
    assert stats["lost"] >= 26 and len(np.atleast_1d(rows_in(tmp_path / "rows.csv"))) <= 4


def test_the_file_is_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(telemetry, "_MAX_ROWS", 12)
    piped(tmp_path / "rows.csv")
    before, newest = rows_in(tmp_path / "rows.csv.1"), rows_in(tmp_path / "rows.csv")
    assert {len(before), len(newest)} <= set(range(1, 13)) and newest["index"][-1] == 29
    assert sorted(path.name for path in tmp_path.iterdir()) == ["rows.csv", "rows.csv.1"]


def test_a_file_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    (tmp_path / "gone").mkdir()
    pipeline = asap.Pipeline(telemetry=tmp_path / "gone" / "rows.csv", **SENSOR)
    (tmp_path / "gone").rmdir()
    with pytest.warns(RuntimeWarning, match=r"rows\.csv: No such file.*lost"), pipeline:
        pipeline.push(streams.make([1, 2], x=3, y=4))
        pipeline.stop()
        assert list(pipeline)
    assert pipeline.stats()["telemetry"]["lost"] == 1


def test_a_second_run_goes_on_in_the_file(tmp_path: Path) -> None:
    pipeline = piped(tmp_path / "rows.csv")
    with pipeline:
        pipeline.push(streams.make(np.arange(20), x=3, y=4))
        pipeline.stop()
        assert len(list(pipeline)) == 2
    assert rows_in(tmp_path / "rows.csv")["index"].tolist() == [*range(30), 0, 1]


@pytest.mark.parametrize("name", ["rows.txt", "missing/rows.csv"])
def test_a_bad_path_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises((ValueError, OSError), match="rows"):
        asap.Pipeline(telemetry=tmp_path / name)
