"""The notebooks run from top to bottom; those that a reader sees first are kept with their outputs.

The quick start is what a new user reads; the clusters are over recordings that are not distributed.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import nbformat
import pytest

from event_files import DATA, recording
from house import ROOT, name_of, run

NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))
CLUSTERS = ROOT / "notebooks" / "clusters.ipynb"
QUICK_START = ROOT / "notebooks" / "quickstart.ipynb"
KEPT = [CLUSTERS, QUICK_START]  # by tests/python/execute_notebook.py
RECORDINGS = [
    "aedat/cars_davis346.aedat4",
    "aedat/office_davis346.aedat4",
    "text/hands",
    "text/night_davis346.csv",
]

EXECUTE = ROOT / "tests" / "python" / "execute_notebook.py"


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=name_of)
def test_notebook_runs(path: Path, tmp_path: Path) -> None:
    run([sys.executable, EXECUTE, path, tmp_path / path.name])


@pytest.mark.slow
@pytest.mark.full
def test_notebook_over_recordings_runs(tmp_path: Path) -> None:
    for name in RECORDINGS:
        recording(name)
    env = {**os.environ, "ASAP_TEST_DATA": str(DATA)}
    run([sys.executable, EXECUTE, CLUSTERS, tmp_path / CLUSTERS.name], env=env)


@pytest.mark.parametrize("path", sorted({*NOTEBOOKS} - {*KEPT}), ids=name_of)
def test_notebook_is_kept_without_output(path: Path) -> None:
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    for cell in notebook.cells:
        if cell.cell_type == "code":
            assert cell.outputs == []
            assert cell.execution_count is None


def outputs_of(path: Path) -> list[nbformat.NotebookNode]:
    cells = nbformat.read(path, as_version=4).cells
    return [output for cell in cells if cell.cell_type == "code" for output in cell.outputs]


@pytest.mark.parametrize("path", KEPT, ids=name_of)
def test_notebook_is_kept_as_it_ran(path: Path) -> None:
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in cells] == [*range(1, len(cells) + 1)]
    assert {output.output_type for output in outputs_of(path)} == {"stream", "execute_result"}
    assert {output.get("name", "stdout") for output in outputs_of(path)} == {"stdout"}
    assert path.stat().st_size < 600_000


def test_no_picture_is_kept_of_a_recording_whose_licence_forbids_it() -> None:
    """Night and hands: figures only."""
    for cell in nbformat.read(CLUSTERS, as_version=4).cells:
        if any("image/png" in output.get("data", {}) for output in cell.get("outputs", [])):
            assert "night" not in cell.source and "hands" not in cell.source
