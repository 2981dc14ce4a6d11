"""tests/instructions/count.py: what a rise is, and what it says of one."""

from __future__ import annotations

import importlib.util
import json
from types import ModuleType

import pytest

from house import ROOT

FOLDER = ROOT / "tests" / "instructions"


@pytest.fixture(scope="module")
def count() -> ModuleType:
    spec = importlib.util.spec_from_file_location("count", FOLDER / "count.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_more_than_two_percent_is_a_rise(count: ModuleType) -> None:
    before = {"keep push": 20.0, "keep next": 1.0}
    assert count.risen({"keep push": 20.4, "keep next": 0.5}, before) == []
    (line,) = count.risen({"keep push": 20.41, "keep next": 1.0}, before)
    assert line == "keep push: 20.0 -> 20.41 instructions per event"


def test_a_figure_without_a_predecessor_is_no_rise(count: ModuleType) -> None:
    assert count.risen({"new": 5.0}, {}) == []


def test_every_file_has_a_reason_and_all_figures(count: ModuleType) -> None:
    files = sorted(FOLDER.glob("*.json"))
    assert files
    wanted = {"reason", *(f"{what} {stage}" for what in count.WHAT for stage in count.STAGES)}
    for file in files:
        assert set(json.loads(file.read_text())) == wanted
