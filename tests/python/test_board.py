"""The page for boards: its code compiles, the recipes against stub headers of the drivers."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from house import ROOT

PAGE = (ROOT / "notebooks" / "board.md").read_text()
RECIPES = dict(re.findall(r"```cpp\n// (\w+\.cpp):.*?\n(.*?)```", PAGE, re.DOTALL))
COMPILER = shutil.which("c++") or shutil.which("g++")


def compiled(source: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Compile without linking: the driver is a stub."""
    file = folder / "recipe.cpp"
    file.write_text(source)
    includes = (f"-I{ROOT / 'cpp' / 'include'}", f"-I{ROOT / 'tests' / 'drivers'}")
    strict = ("-std=c++20", "-fsyntax-only", "-Wall", "-Wextra", "-Wconversion", "-Werror")
    command = [str(COMPILER), *strict, *includes, str(file)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_the_page_has_a_recipe_for_each_camera() -> None:
    assert set(RECIPES) == {"davis346.cpp", "evk4.cpp"}


@pytest.mark.skipif(COMPILER is None, reason="needs a C++ compiler")
@pytest.mark.parametrize("name", sorted(RECIPES))
def test_a_recipe_compiles(name: str, tmp_path: Path) -> None:
    done = compiled(RECIPES[name], tmp_path)
    assert done.returncode == 0, done.stderr


@pytest.mark.skipif(COMPILER is None, reason="needs a C++ compiler")
def test_the_stubs_refuse_what_the_driver_has_not(tmp_path: Path) -> None:
    done = compiled(RECIPES["evk4.cpp"].replace("add_callback", "on_events"), tmp_path)
    assert "on_events" in done.stderr
