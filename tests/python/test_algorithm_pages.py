"""notebooks/algorithms: a page per algorithm, short, linked, and its example runs."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

import asap
from asap.cli.algorithms import ALGORITHMS
from house import ROOT, name_of, run

FOLDER = ROOT / "notebooks" / "algorithms"
INDEX = FOLDER / "README.md"
PAGES = sorted(set(FOLDER.glob("*.md")) - {INDEX})


def algorithms() -> set[str]:
    kinds = [kind for kind in vars(asap).values() if isinstance(kind, type)]
    return {"Tiled"} | {kind.__name__ for kind in kinds if hasattr(kind, "set_gamma")}


def title(page: Path) -> str:
    return page.read_text().splitlines()[0].removeprefix("# ")


def test_every_algorithm_has_a_page() -> None:
    assert {title(page) for page in PAGES} == algorithms()


def test_the_index_names_all_pages_and_commands() -> None:
    rows = re.findall(r"^\| \[(\w+)\]\((\S+)\) .*\| (?:`(\w+)` )?\|$", INDEX.read_text(), re.M)
    assert [(name, link) for name, link, _ in sorted(rows, key=lambda row: row[1])] == [
        (title(page), page.name) for page in PAGES
    ]
    commands = {command: name for name, _, command in rows if command}
    assert commands == {key: name for key, name in ALGORITHMS.items() if name in algorithms()}


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_example_runs(page: Path, tmp_path: Path) -> None:
    (example,) = re.findall(r"^```python\n(.*?)^```$", page.read_text(), re.M | re.S)
    script = tmp_path / "example.py"
    script.write_text(example)
    run([sys.executable, "-W", "error", script], cwd=tmp_path)
