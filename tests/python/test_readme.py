"""README.md keeps its word: commands, examples, links, tables."""

from __future__ import annotations

import re
import shlex
import sys
from pathlib import Path

import pytest

import asap
from asap import cli
from house import INCLUDE, ROOT, name_of, run

TEXT = (ROOT / "README.md").read_text()
BLOCKS = re.findall(r"^```(\w*)\n(.*?)^```$", TEXT, re.M | re.S)


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


def test_python_examples_run(tmp_path: Path) -> None:
    examples = blocks("python")
    assert examples
    for number, example in enumerate(examples):
        script = tmp_path / f"example_{number}.py"
        script.write_text(example)
        run([sys.executable, "-W", "error", script], cwd=tmp_path)


def test_cpp_blocks_stand_in_the_examples_that_are_built_and_run() -> None:
    examples = {path: path.read_text() for path in (ROOT / "cpp" / "examples").glob("*.cpp")}
    assert blocks("cpp")
    for block in blocks("cpp"):
        assert any(block in text for text in examples.values()), block
    assert not [path for path in examples if f"]({name_of(path)})" not in TEXT]


def commands() -> list[str]:
    lines = [line for block in blocks("sh") for line in block.splitlines()]
    return [line for line in lines if line.startswith("asap ")]


@pytest.mark.parametrize("line", commands())
def test_command_is_understood(line: str) -> None:
    cli._parser().parse_args(shlex.split(line)[1:])


def test_links_lead_somewhere() -> None:
    targets = re.findall(r"\]\(([^)\s]+)\)", TEXT)
    headings = {
        re.sub(r"[^\w-]", "", heading.lower().replace(" ", "-"))
        for heading in re.findall(r"^#+ (.*)$", TEXT, re.M)
    }
    for target in targets:
        if target.startswith("#"):
            assert target[1:] in headings
        elif not target.startswith("https://"):
            assert (ROOT / target).is_file(), target


def test_table_of_schemes_is_complete() -> None:
    rows = re.findall(r"^\| `(\w+)` \|.*\|([^|]*)\|$", TEXT, re.M)
    described = {name: set(re.findall(r"`(\w+)`", parameters)) for name, parameters in rows}
    schemes = [
        kind
        for kind in vars(asap).values()
        if isinstance(kind, type) and issubclass(kind, asap.Scheme) and kind is not asap.Scheme
    ]
    assert described == {kind.__name__: set(kind().parameters) for kind in schemes}


def test_map_of_the_house_is_complete() -> None:
    (house,) = [text for _, text in BLOCKS if text.startswith("cpp/include/asap/")]
    layers = {path.name for path in (INCLUDE / "asap").iterdir() if path.is_dir()}
    assert layers == set(re.findall(r"^(?:cpp/include/asap/| {17}) {3}(\w+) ", house, re.M))
