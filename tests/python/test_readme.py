"""README.md and the pages below it keep their word: commands, examples, tables."""

from __future__ import annotations

import re
import shlex
import sys
from pathlib import Path

import pytest

import asap
from asap import cli
from house import ROOT, name_of, run

NOTEBOOKS = ROOT / "notebooks"
TEXT = (ROOT / "README.md").read_text()


def blocks_of(text: str) -> list[tuple[str, str]]:
    return re.findall(r"^```(\w*)\n(.*?)^```$", text, re.M | re.S)


BLOCKS = blocks_of(TEXT)
PAGES = {
    name_of(path): blocks_of(path.read_text())
    for path in (*ROOT.glob("*.md"), *NOTEBOOKS.glob("*.md"), ROOT / "python" / "README.md")
}
# Every way to write a command: a line of a block, or code in a text or in a table.
TEXTS = sorted(
    {
        *(ROOT / "README.md", ROOT / "python" / "README.md"),
        *NOTEBOOKS.rglob("*.md"),
        *NOTEBOOKS.glob("*.ipynb"),
        *(ROOT / "cpp" / "ros").rglob("*.md"),
    }
)


def blocks(language: str) -> list[str]:
    return [text for name, text in BLOCKS if name == language]


def first_line_with(word: str) -> str:
    return next(line for line in TEXT.splitlines() if word in line)


@pytest.mark.parametrize("word", ["asap demo", "pytest"])
def test_the_two_lines(word: str) -> None:
    line = first_line_with(word)
    assert f"{line}\n" in blocks("sh"), "it stands alone in its own block"
    assert TEXT.index("apt-get install") < TEXT.index(line)
    assert line.startswith("python3 -m venv .venv && .venv/bin/pip install '.[")
    pyproject = (ROOT / "pyproject.toml").read_text()
    (extras,) = re.findall(r"'\.\[([\w,]+)\]'", line)
    assert all(re.search(rf"^{extra} = \[", pyproject, re.M) for extra in extras.split(","))


def examples() -> list[tuple[str, str]]:
    """Every Python example of the pages, each with its page."""
    return [
        (page, example)
        for page, blocks in PAGES.items()
        for language, example in blocks
        if language == "python"
    ]


@pytest.mark.parametrize(("page", "example"), examples())
def test_python_examples_run(page: str, example: str, tmp_path: Path) -> None:
    if "scheduler_file" in example:
        pytest.skip("test_map_dask runs it on a cluster of its own")
    script = tmp_path / "example.py"
    script.write_text(example)
    run([sys.executable, "-W", "error", script], cwd=tmp_path)


def test_the_page_of_a_package_index_needs_no_file_beside_it() -> None:
    page = (ROOT / "python" / "README.md").read_text()
    targets = re.findall(r"\]\(([^)]*)\)|(?:src|href)=\"([^\"]*)\"", page)
    assert not [found for found in targets if not "".join(found).startswith("https://")]
    assert {text for name, text in blocks_of(page) if name == "python"} <= {*blocks("python")}


def commands() -> list[str]:
    """Every `asap` command with arguments that a page shows; "..." stands for more of them."""
    found = set()
    for path in TEXTS:
        text = path.read_text().replace("\\n", "\n").replace('\\"', '"')
        text = re.sub(r"(?<=\S)\n(?=[^\n]*`)", " ", text) if path.suffix == ".ipynb" else text
        plain = re.sub(r"^```.*?^```$", "", text, flags=re.M | re.S)
        found |= {re.sub(r"\s+", " ", one) for one in re.findall(r"`(asap [a-z]+\s[^`]*)`", plain)}
        for _, block in blocks_of(text):
            found |= set(re.findall(r"^(asap [^#\n]*?)(?: *#.*)?$", block, re.M))
    return sorted(one for one in found if "..." not in one and "VERB" not in one)


@pytest.mark.parametrize("line", commands())
def test_command_is_understood(line: str) -> None:
    try:
        cli._parser().parse_args(shlex.split(line)[1:])
    except SystemExit as end:
        assert end.code == 0 and "--help" in line


def test_every_verb_is_shown() -> None:
    verbs = set(re.findall(r"^    (\w+) ", cli._parser().format_help(), re.M))
    assert verbs and verbs <= {line.split()[1] for line in commands()}


def test_table_of_schemes_is_complete() -> None:
    page = (NOTEBOOKS / "schemes.md").read_text()
    rows = re.findall(r"^\| `(\w+)` \|.*\|([^|]*)\|$", page, re.M)
    described = {name: set(re.findall(r"`(\w+)`", parameters)) for name, parameters in rows}
    schemes = [
        kind
        for kind in vars(asap).values()
        if isinstance(kind, type) and issubclass(kind, asap.Scheme) and kind is not asap.Scheme
    ]
    assert described == {kind.__name__: set(kind().parameters) for kind in schemes}
