"""Runs on disk: the archive with the log, the summary, and files that are something else."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
import streams

EVENTS = streams.poisson(2e6, 0.05)
COST = asap.LinearCost(20, 100, noise=0.2)
MAGIC = b"never unpickle this"


@pytest.fixture(scope="module")
def run() -> asap.Run:
    return asap.simulate(EVENTS, cost=COST, scheme=asap.Asap2020(), keep_mask=True)


@pytest.fixture
def path(run: asap.Run, tmp_path: Path) -> Path:
    return run.save(tmp_path / "run.npz")


# ---- forms ----------------------------------------------------------------------------------


def assert_same(again: asap.Run, run: asap.Run) -> None:
    assert again.summary() == run.summary()
    assert again.packages.dtype == run.packages.dtype
    for name in run.packages.dtype.names or ():
        column, expected = again.packages[name], run.packages[name]
        assert column.tobytes() == expected.tobytes(), name
    assert again.latency.state() == run.latency.state()
    assert not again.without_log and str(again) == str(run)


def test_an_archive_holds_log_and_summary(run: asap.Run, path: Path) -> None:
    assert run.packages.dtype.names and "first" in run.packages.dtype.names
    again = asap.load_run(path)
    assert_same(again, run)
    assert not again.packages.flags.writeable


def test_an_empty_run(tmp_path: Path) -> None:
    run = asap.simulate(EVENTS[:0], cost=COST)
    assert_same(asap.load_run(run.save(tmp_path / "run.npz")), run)
    assert asap.load_run(run.save(tmp_path / "run.json")).summary() == run.summary()


def test_json_is_the_summary(run: asap.Run, tmp_path: Path) -> None:
    path = run.save(tmp_path / "run.json")
    assert json.loads(path.read_text()) == run.summary()
    again = asap.load_run(path)
    assert again.without_log and again.packages.size == 0
    assert again.summary() == run.summary()
    assert (again.kept, again.in_time) == (run.kept, run.in_time)
    assert again.latency.quantile(0.99) == run.latency.quantile(0.99)
    with pytest.raises(ValueError, match=r"q = 0\.9: .*npz"):
        again.latency.quantile(0.9)
    assert again.save(tmp_path / "b.json").read_bytes() == path.read_bytes()
    assert "without its packages" in repr(again)
    assert "Bottleneck: not known" in str(again) and "Verdict" in again._repr_html_()


def test_a_summary_says_that_it_has_no_log(run: asap.Run, tmp_path: Path) -> None:
    again = asap.load_run(run.save(tmp_path / "run.json"))
    calls: list[Callable[[], Any]] = [
        lambda: again.save(tmp_path / "b.npz"),
        lambda: asap.analysis.diagnose(again),
        lambda: asap.analysis.time_s(again),
    ]
    for call in calls:
        with pytest.raises(ValueError, match=r"summary.*run\.save\('run\.npz'\)"):
            call()
    assert not (tmp_path / "b.npz").exists()


# ---- lies -----------------------------------------------------------------------------------


class Evil:
    def __reduce__(self) -> tuple[Any, ...]:
        return print, (MAGIC,)


LIES: dict[str, tuple[str, Any, str]] = {
    "a pickle": ("size", np.array([Evil()], object), "allow_pickle"),
    "no summary": ("summary", None, "summary"),
    "no column": ("start_us", None, "start_us"),
    "a short column": ("size", np.ones(3, np.int64), r"size = int64\(3,\)"),
    "another type": ("offered", np.ones(3, np.uint8), r"offered = uint8\(3,\)"),
    "no JSON": ("latencies", np.array("PK"), "Expecting value"),
}


@pytest.mark.parametrize("lie", LIES)
def test_an_archive_that_lies_is_refused(
    path: Path, lie: str, capsys: pytest.CaptureFixture[str]
) -> None:
    name, content, words = LIES[lie]
    with np.load(path) as archive:
        arrays = dict(archive) | {name: content}
    np.savez(path, **{name: array for name, array in arrays.items() if array is not None})
    with pytest.raises(ValueError, match=f"not a run that asap has saved .*{words}") as caught:
        asap.load_run(path)
    assert "run.save(path)" in str(caught.value) and "\n" not in str(caught.value)
    assert not capsys.readouterr().out


def test_any_cut_and_any_changed_byte_is_refused_or_harmless(run: asap.Run, path: Path) -> None:
    good = path.read_bytes()
    rng = np.random.default_rng(1)
    for place in rng.integers(0, len(good), 60):
        for content in (
            good[:place],
            good[:place] + bytes([good[place] ^ 0x55]) + good[place + 1 :],
        ):
            path.write_bytes(content)
            try:
                assert asap.load_run(path).summary() == run.summary()
            except ValueError as error:
                assert "not a run that asap has saved" in str(error)


def test_a_summary_is_read_for_what_does_not_follow_from_the_rest(
    run: asap.Run, tmp_path: Path
) -> None:
    path = tmp_path / "run.json"
    path.write_text(json.dumps(run.summary() | {"kept": None}))
    assert asap.load_run(path).summary() == run.summary()
    summaries = [
        json.dumps(run.summary() | broken)
        for broken in ({"schema_version": 99}, {"scheme": 3}, {"ledger": {"stale?": 1}})
    ]
    for content in (*summaries, "", "[]", "[" * 100_000, '{"schema_version": NaN}'):
        path.write_text(content)
        with pytest.raises(ValueError, match="not a run that asap has saved"):
            asap.load_run(path)
