"""Sphinx: the pages of this repository and a reference as a site, without a network.

    pip install '.[docs]' && sphinx-build -W -c notebooks . build/site

Two kinds of blocks in the pages of `reference` become what they list: `{names}`, documented from
docstrings, and `{headers}` of folders.
"""

import itertools
import re
from pathlib import Path
from typing import Any

import asap
from asap import _core

ROOT = Path(__file__).parents[1]
HEADERS = ROOT / "cpp" / "include" / "asap"

project = "ASAP"
author = "The ASAP authors"
copyright = "2026, the ASAP authors"
version = release = asap.__version__

root_doc = "notebooks/index"
include_patterns = [
    "*.md",
    "cpp/**.md",
    "notebooks/**",
    "python/laboratory/pages/**",
    "tests/*/*.md",
]
exclude_patterns = ["build", "dist", "**/.*", "tests/fuzz/corpus", "**/__pycache__"]
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]

nb_execution_mode = "off"  # the tests execute the notebooks
myst_heading_anchors = 4
myst_enable_extensions = ["html_image"]
autodoc_typehints = "none"  # the signature has them
autodoc_member_order = "groupwise"
autodoc_default_options = {"exclude-members": "NotebookFigure"}  # matplotlib's, but for its pickle
default_role = "code"
napoleon_use_param = False
napoleon_use_ivar = True
add_module_names = False

highlight_language = "none"  # of a block that names none

html_theme = "furo"
html_title = f"ASAP {version}"
html_copy_source = False
html_theme_options = {"light_css_variables": {"code-font-size": "0.75rem"}}  # 100 columns fit
suppress_warnings = ["ref.python"]  # a type named like two attributes, such as `path`

documented: set[str] = set()


def python(names: list[str]) -> str:
    """Document these names of `asap`, its `algorithms` or `filters`, or the rest: `...`."""
    filters = [kind.__name__ for kind in _core.FILTERS]
    algorithms = [kind.__name__ for kind in _core.ALGORITHMS if kind not in _core.FILTERS]
    lists = {"algorithms": algorithms, "filters": filters}
    chosen = [one for name in names for one in lists.get(name, [name])]
    if names == ["..."]:
        chosen = sorted({*asap.__all__} - documented)
    documented.update(chosen)
    lines = []
    for name in chosen:
        thing = getattr(asap, name)
        if isinstance(thing, type):
            lines += [f".. autoclass:: asap.{name}", "   :members:", ""]
        elif callable(thing):
            lines += [f".. autofunction:: asap.{name}", ""]
        elif hasattr(thing, "__path__") or hasattr(thing, "__file__"):
            lines += [f".. automodule:: asap.{name}", "   :members:", ""]
    return "\n".join(["```{eval-rst}", *lines, "```"])


def mark(found: re.Match[str]) -> str:
    """Mark a character that Markdown would read; code stays as it is."""
    return found[0] if len(found[0]) > 1 else "\\" + found[0]


def prose(comment: str) -> str:
    """Return the first comment of a header as Markdown; indented lines are code."""
    parts = []
    for code, lines in itertools.groupby(
        (line[3:] for line in comment.splitlines()), lambda line: line.startswith("  ")
    ):
        text = "\n".join(lines)
        parts.append(f"```cpp\n{text}\n```" if code else re.sub(r"`[^`]*`|[*_<>$[\]]", mark, text))
    return "\n".join(parts)


def cpp(layers: list[str]) -> str:
    """Show the public headers of these layers: the first comment as text, then declarations."""
    parts = []
    for header in (path for layer in layers for path in sorted((HEADERS / layer).glob("*.hpp"))):
        comment, _, rest = header.read_text(encoding="utf-8").partition("#pragma once\n")
        code = rest[rest.index("namespace asap") :].strip()
        code = re.sub(r"^ (?:private|protected):\n.*?(?=^};)", "", code, flags=re.M | re.S)
        parts.append(f"## `asap/{header.parent.name}/{header.name}`\n\n{prose(comment)}\n")
        parts.append(f"```cpp\n{code}\n```\n")
    return "\n".join(parts)


def expand(_app: Any, page: str, source: list[str]) -> None:
    """Put contents in the place of the two kinds of blocks."""
    if page.startswith("notebooks/reference/"):
        source[0] = re.sub(
            r"^```\{(names|headers)\}\n(.*?)\n```$",
            lambda found: {"names": python, "headers": cpp}[found[1]](found[2].split()),
            source[0],
            flags=re.M,
        )


def fields(_app: Any, what: str, _name: str, _thing: Any, _options: Any, lines: list[str]) -> None:
    """Make a list of the fields that a property's docstring names line by line."""
    if what == "property":
        lines[:] = (
            re.sub(r"^(\w[\w, ]*) : (.*(?:\n +.*)*)", r"* **\1**: \2", "\n".join(lines), flags=re.M)
            .replace("\n    ", "\n  ")
            .split("\n")
        )


def front_door(app: Any, _error: object) -> None:
    """Lead the site's address to its first page."""
    (Path(app.outdir) / "index.html").write_text(
        f'<!doctype html><meta http-equiv="refresh" content="0; url={root_doc}.html">\n'
    )


def setup(app: Any) -> None:
    """Sphinx calls this."""
    app.connect("source-read", expand)
    app.connect("build-finished", front_door)
    app.connect("autodoc-process-docstring", fields, priority=1)
