"""The examples in the docstrings of public names run, and the names that a user meets have one."""

from __future__ import annotations

import doctest
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
from asap import _core

FIRST_MET = {"run", "simulate", "compare", "oracle", "read", "load", "as_events", "to_dtype", "map"}
FIRST_MET |= {"open_camera", "SoftwareCamera", "GammaFilter", "LinearCost", "Tiled", "Tracks"}
FIRST_MET |= {"table", "load_run"}


def examples() -> dict[str, doctest.DocTest]:
    """Every public name whose docstring has an example, and that example."""
    names = {"asap": asap, "np": np}
    parse = doctest.DocTestParser().get_doctest
    tests = {
        name: parse(getattr(asap, name).__doc__ or "", names, name, None, None)
        for name in dir(asap)
        if not name.startswith("_")
    }
    return {name: test for name, test in tests.items() if test.examples}


def test_what_a_user_meets_first_has_an_example() -> None:
    kinds: list[Any] = [kind for kind in vars(asap).values() if hasattr(kind, "set_gamma")]
    kinds += _core.SCHEMES
    assert FIRST_MET | {kind.__name__ for kind in kinds} <= examples().keys()


@pytest.mark.parametrize("name", sorted(examples()))
def test_an_example_runs(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert not doctest.DocTestRunner().run(examples()[name]).failed
