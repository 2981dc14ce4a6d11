"""notebooks/algorithms: a section for each algorithm, in the table, with an example that runs."""

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
EXAMPLES = {
    page: "".join(re.findall(r"^```python\n(.*?)^```$", page.read_text(), re.M | re.S))
    for page in PAGES
}


def algorithms() -> set[str]:
    kinds = [kind for kind in vars(asap).values() if isinstance(kind, type)]
    return {"Tiled"} | {kind.__name__ for kind in kinds if hasattr(kind, "set_gamma")}


def sections() -> list[tuple[str, str]]:
    """Every section about an algorithm, with its address as the table has it."""
    titles = [
        (title, page.name)
        for page in PAGES
        for title in re.findall(r"^##? (\w+)$", page.read_text(), re.M)
    ]
    return [(title, f"{page}#{title.lower()}") for title, page in titles if title in algorithms()]


def test_every_algorithm_has_a_section_in_the_table() -> None:
    rows = re.findall(r"^\| \[(\w+)\]\((\S+)\) .*\| (?:`(\w+)` )?\|$", INDEX.read_text(), re.M)
    assert sorted((name, link) for name, link, _ in rows) == sorted(sections())
    assert {name for name, *_ in rows} == algorithms()
    commands = {command: name for name, _, command in rows if command}
    assert commands == {key: name for key, name in ALGORITHMS.items() if name in algorithms()}


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_examples_run(page: Path, tmp_path: Path) -> None:
    """The blocks of a page are one program, which uses each algorithm of the page."""
    titles = {name for name, link in sections() if link.startswith(f"{page.name}#")}
    assert titles <= set(re.findall(r"asap\.(\w+)", EXAMPLES[page]))
    script = tmp_path / "example.py"
    script.write_text(EXAMPLES[page])
    run([sys.executable, "-W", "error", script], cwd=tmp_path)
