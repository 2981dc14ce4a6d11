"""The house rules that a machine can check: arrows, versions, banned words."""

from __future__ import annotations

import ast
import graphlib
import importlib.metadata
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import asap
from house import INCLUDE, ROOT, name_of, run, sources

# What a layer may include, besides itself.
MAY_INCLUDE = {
    "core": set(),
    "buffer": {"core"},
    "filter": {"core"},
    "schemes": {"core"},
    "telemetry": {"core"},
    "packager": {"core", "buffer", "filter", "schemes", "telemetry"},
    "runner": {"core", "buffer", "filter", "schemes", "telemetry", "packager"},
    "study": {
        *("core", "buffer", "filter", "schemes", "telemetry", "packager", "runner"),
        *("synthetic", "algorithms"),  # its scenes and rivals are built of their parts
    },
    "oracle": {"core", "schemes", "runner"},
    "formats": {"core"},
    "synthetic": {"core"},
    "algorithms": {"core"},
    "examples": {"runner", "schemes", "synthetic", "algorithms"},
    "ros": {"core", "formats", "schemes", "packager", "runner", "algorithms"},
}

# A module of asap may import those on lines above its own.
PYTHON_LAYERS = (
    {"_core", "_checks", "_process", "_progress", "_units"},
    {"events", "tiled"},
    {"io", "synthetic"},
    {"results"},
    {"analysis", "experiment"},
    {"camera", "inspection", "plots", "viewer"},
    {"cli"},
    {"__main__"},
)
USE_THE_FACADE = {"cli", "__main__"}  # they see `import asap` as a user does

CPP = ROOT / "cpp"
SOURCE = CPP / "src"
TREES = (INCLUDE / "asap", SOURCE, CPP)  # public, private, the laboratory and the bridge
NODES = (CPP / "ros" / "ros1", CPP / "ros" / "ros2")  # they know a middleware, nothing knows them


def headers() -> dict[str, Path]:
    """Every header by its path below its tree, such as runner/replay.hpp."""
    found = [(tree, path) for tree in TREES[:2] for path in tree.rglob("*.hpp")]
    found += [(CPP, path) for path in (CPP / "study").rglob("*.hpp")]
    found += [(CPP, path) for path in (CPP / "ros" / "bridge").rglob("*.hpp")]
    return {path.relative_to(tree).as_posix(): path for tree, path in found}


HEADERS = headers()
PYTHON_ROOT = ROOT / "python"
PRODUCT = sorted((PYTHON_ROOT / "asap").rglob("*.py"))
LABORATORY = PYTHON_ROOT / "laboratory"
PYTHON = [*PRODUCT, *sorted(LABORATORY.rglob("*.py"))]
BINDINGS = ("python/bindings", "python/laboratory")
NATIVE = {".cpp", ".hpp"}
# ---- arrows ---------------------------------------------------------------------------------


def includes(path: Path) -> Iterator[str]:
    for match in re.finditer(r'^\s*#\s*include\s*["<]([^">]+)[">]', path.read_text(), re.M):
        yield match[1]


def layer_of(path: Path) -> str:
    """The folder in cpp/include/asap, cpp/src or cpp itself; "" of a file of their own."""
    tree = next(tree for tree in TREES if path.is_relative_to(tree))
    return path.relative_to(tree).parts[0]


def test_every_layer_is_known() -> None:
    folders = {path.name for tree in TREES[:2] for path in tree.iterdir() if path.is_dir()}
    assert folders | {"study", "examples", "ros"} == set(MAY_INCLUDE)


def test_native_includes_point_down() -> None:
    up = []
    for path in sources("cpp", suffixes=NATIVE):
        layer = layer_of(path)
        for header in includes(path):
            other = header.removeprefix("asap/").split("/")[0]
            if other in MAY_INCLUDE and other != layer and other not in MAY_INCLUDE[layer]:
                up.append(f"{name_of(path)} includes {header}")
    assert not up


def module_of(path: Path) -> str:
    parts = path.relative_to(PYTHON_ROOT).with_suffix("").parts
    return ".".join(parts).removesuffix(".__init__")


MODULES = {module_of(path): path for path in PRODUCT}


def at_load(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes below a node, but those in functions."""
    for below in ast.iter_child_nodes(node):
        if not isinstance(below, (ast.FunctionDef, ast.AsyncFunctionDef)):
            yield below
            yield from at_load(below)


def imports(path: Path) -> Iterator[str]:
    """The modules of asap that a file imports when it is loaded, or for the type checker.

    What a function imports when it is called is no arrow: a result draws itself so.
    """
    package = path.relative_to(PYTHON_ROOT).parent.parts
    for node in at_load(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = list(package[: len(package) + 1 - node.level] if node.level else ())
            base += [node.module] if node.module else []
            names = [".".join([*base, alias.name]) for alias in node.names]
        else:
            names = []
        for name in names:
            if name.partition(".")[0] == "asap":
                is_module = name in MODULES or name == "asap._core"
                yield name if is_module else name.rpartition(".")[0]


def part_of(module: str) -> str:
    """The file or folder in asap that a module is of; "" for asap itself."""
    return f"{module}..".split(".")[1]


def test_python_imports_point_down() -> None:
    rank = {name: i for i, names in enumerate(PYTHON_LAYERS) for name in names}
    up = []
    for module, path in MODULES.items():
        part = part_of(module)
        if part == "":
            continue
        assert part in rank, f"{name_of(path)}: give it a place in PYTHON_LAYERS"
        for one in imports(path):
            other = part_of(one)
            if other == part:
                continue
            facade = other == ""  # a name of asap itself, such as asap.run
            if not (part in USE_THE_FACADE if facade else rank[other] < rank[part]):
                up.append(f"{name_of(path)} imports {one}")
    assert not up


def test_no_module_of_python_is_in_a_circle() -> None:
    graph = {module: set(imports(path)) for module, path in MODULES.items()}
    graphlib.TopologicalSorter(graph).prepare()  # a CycleError names the circle


def test_the_product_does_not_know_the_laboratory() -> None:
    assert not [name_of(path) for path in PRODUCT if "asap_laboratory" in path.read_text()]


# ---- Python ---------------------------------------------------------------------------------


STAMPS = r"f[\"']\{stamps\.dtype\.kind\}8\[.*|stamps\.dtype"
SCALAR = re.compile(rf"int|float|bool|np\.(u?int|float)\d+|np\.bool_|{STAMPS}")


def test_astype_makes_plain_numbers_only() -> None:
    """Between structured dtypes it copies by position and scrambles the columns."""
    structured = []
    for path in PYTHON:
        for node in ast.walk(ast.parse(path.read_text())):
            if (
                isinstance(node, ast.Call)
                and isinstance(node.func, ast.Attribute)
                and node.func.attr == "astype"
                and node.args
            ):
                kind = ast.unparse(node.args[0])
                if not SCALAR.fullmatch(kind):
                    structured.append(f"{name_of(path)}:{node.lineno}: astype({kind})")
    assert not structured


def test_bindings_never_cast_arrays() -> None:
    """pybind11 casts an array_t argument by default, structured ones by position."""
    casts = [
        f"{name_of(path)}: {match[0]}"
        for path in sources(*BINDINGS, suffixes=NATIVE)
        for match in re.finditer(
            r"force" + r"cast|(?:const )?py::array_t<[^;={}()]*>\s*&?\s*\w+\s*[,)]",
            path.read_text(),
        )
    ]
    assert not casts


def test_bindings_cross_the_gil_in_one_place() -> None:
    """Elsewhere the end of the interpreter would catch a thread on the way: see gil.hpp."""
    crossings = {
        name_of(path)
        for path in sources(*BINDINGS, suffixes=NATIVE)
        if "gil_scoped_" in path.read_text()
    }
    assert crossings == {"python/bindings/gil.cpp", "python/bindings/gil.hpp"}


# ---- every file -----------------------------------------------------------------------------

BANNED = {
    "a pickle may run code": r"allow_pickle\s*=\s*" + "True",
    "finish it or leave it out": r"\b(TO" + r"DO|FIX" + r"ME|X" + r"XX)\b",
    "a path of one machine": r"(?<![\w.~$}])/(?:work|root|home|opt)/",
    "tab": r"\t",
    "trailing space": r"[ \t]+$",
}


def test_no_file_holds_what_is_banned() -> None:
    found = [
        f"{name_of(path)}:{text.count(chr(10), 0, match.start()) + 1}: {match[0]!r}: {why}"
        for path in sources()
        for text in [path.read_text(encoding="utf-8")]
        for why, pattern in BANNED.items()
        for match in re.finditer(pattern, text, re.M)
    ]
    assert not found, "\n".join(found)


def test_every_mutant_still_finds_its_line() -> None:
    run([sys.executable, ROOT / "tests" / "mutation" / "mutate.py", "--check"])


# ---- version --------------------------------------------------------------------------------


def test_version_is_the_same_everywhere() -> None:
    written = re.search(r'^version = "([0-9.]+)"$', (ROOT / "pyproject.toml").read_text(), re.M)
    assert written is not None
    assert asap._core.__version__ == written[1]  # C++: asap::kVersion
    assert asap.__version__ == written[1]
    assert importlib.metadata.version("asap-events") == written[1]
    laboratory = (LABORATORY / "pyproject.toml").read_text()
    assert f'version = "{written[1]}"\n' in laboratory
    assert f'"asap-events=={written[1]}"' in laboratory
    assert f"## [{written[1]}]" in (ROOT / "CHANGELOG.md").read_text()
    major, minor, _ = written[1].split(".")
    opened = {
        name
        for folder in ("include", "src")
        for path in (ROOT / "cpp" / folder).rglob("*.[ch]pp*")
        for name in re.findall(
            r"^namespace (asap\b[\w: ]*?)(?:::[a-z]+)? {$", path.read_text(), re.M
        )
    }
    assert opened == {f"asap::inline v{major}_{minor}"}
    for package in NODES:
        if (package / "package.xml").exists():
            assert f"<version>{written[1]}</version>" in (package / "package.xml").read_text()
