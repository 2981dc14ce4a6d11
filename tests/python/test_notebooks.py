"""The notebooks run from top to bottom, and are kept without output but one.

That one is over recordings that are not in the repository: without its output nobody could see it.
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
RECORDINGS = [
    "aedat/cars_davis346.aedat4",
    "aedat/office_davis346.aedat4",
    "text/hands",
    "text/night_davis346.csv",
]

# In a process of its own: the Jupyter libraries warn about one another.
EXECUTE = """if True:
    import sys
    import nbclient, nbformat
    from jupyter_client import KernelManager

    manager = KernelManager(kernel_name="python3")
    manager.kernel_spec.argv[0] = sys.executable
    notebook = nbformat.read(sys.argv[1], as_version=4)
    limits = {"timeout": 900, "startup_timeout": 300}
    nbclient.NotebookClient(notebook, km=manager, **limits).execute(cwd=sys.argv[2])
"""


def test_there_are_notebooks() -> None:
    assert NOTEBOOKS


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=name_of)
def test_notebook_runs(path: Path, tmp_path: Path) -> None:
    run([sys.executable, "-c", EXECUTE, path, tmp_path])


@pytest.mark.slow
@pytest.mark.full
def test_notebook_over_recordings_runs(tmp_path: Path) -> None:
    for name in RECORDINGS:
        recording(name)
    env = {**os.environ, "ASAP_TEST_DATA": str(DATA)}
    run([sys.executable, "-c", EXECUTE, CLUSTERS, tmp_path], env=env)


@pytest.mark.parametrize("path", sorted({*NOTEBOOKS} - {CLUSTERS}), ids=name_of)
def test_notebook_is_kept_without_output(path: Path) -> None:
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    for cell in notebook.cells:
        if cell.cell_type == "code":
            assert cell.outputs == []
            assert cell.execution_count is None


@pytest.mark.parametrize("path", NOTEBOOKS, ids=name_of)
def test_notebook_looks_for_nothing_beside_the_repository(path: Path) -> None:
    cells = nbformat.read(path, as_version=4).cells
    assert not [cell.source for cell in cells if cell.cell_type == "code" and "../" in cell.source]


def test_notebook_over_recordings_is_kept_as_it_ran() -> None:
    notebook = nbformat.read(CLUSTERS, as_version=4)
    nbformat.validate(notebook)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in cells] == [*range(1, len(cells) + 1)]
    outputs = [output for cell in cells for output in cell.outputs]
    assert {output.output_type for output in outputs} == {"stream", "execute_result"}
    written = "".join(output.text for output in outputs if output.output_type == "stream")
    assert {output.get("name", "stdout") for output in outputs} == {"stdout"}
    assert "skipped" not in written and all(
        path.split("/")[1][:4] in written for path in RECORDINGS
    )
    assert CLUSTERS.stat().st_size < 600_000


def test_no_picture_is_kept_of_a_recording_whose_licence_forbids_it() -> None:
    """Night and hands: figures only."""
    for cell in nbformat.read(CLUSTERS, as_version=4).cells:
        if any("image/png" in output.get("data", {}) for output in cell.get("outputs", [])):
            assert "night" not in cell.source and "hands" not in cell.source
