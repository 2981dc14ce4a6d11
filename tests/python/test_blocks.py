"""What a page shows beside Python is understood: shell lines, C++, CMake, paths of the checkout."""

from __future__ import annotations

import json
import re
import shlex
import textwrap
from pathlib import Path

import pytest

from asap import cli
from house import INCLUDE, ROOT, name_of, run

CPP_PAGE = ROOT / "notebooks" / "cpp.md"
ROS_PAGE = "cpp/ros/README.md"
ROS_WORDS = {"cd", "ln", "source", "colcon", "catkin_make", "ros2", "rosrun"}
PAGES = sorted(
    {
        *ROOT.glob("*.md"),
        *(ROOT / "notebooks").rglob("*.md"),
        *(ROOT / "python").glob("*.md"),
        *(ROOT / "python" / "laboratory" / "pages").glob("*.md"),
        ROOT / ROS_PAGE,
    }
)
TEXTS = {name_of(page): page.read_text() for page in PAGES}
PRESETS = json.loads((ROOT / "CMakePresets.json").read_text())
CMAKE_OPTIONS = {"build", "install", "parallel", "prefix", "preset", "workflow"}
PYPROJECT = (ROOT / "pyproject.toml").read_text()


def blocks(language: str) -> list[tuple[str, str]]:
    """Every block in a language, with its page; tests/ros builds and runs the programs of ROS."""
    pattern = rf"^```{language}\n(.*?)^```$"
    return [
        (page, b)
        for page, text in TEXTS.items()
        for b in re.findall(pattern, text, re.M | re.S)
        if language == "sh" or page != ROS_PAGE
    ]


def code_of(text: str) -> str:
    """Blocks and code within the text."""
    return "\n".join(re.findall(r"^```.*?^```$|`[^`\n]+`", text, re.M | re.S))


# ---- shell ----

NOT_RUN = {
    "apt-get": ".ci/run installs what README names; the board's packages, what --full needs",
    "for": ".ci/run --full runs each benchmark",
}


def shell_lines() -> list[str]:
    lines = [line for _, block in blocks("sh") for line in block.splitlines()]
    return sorted({part.strip() for line in lines for part in line.split("&&")})


def assert_installs(what: str) -> None:
    name, _, extras = what.strip("]").partition("[")
    assert name == "asap-events" or (ROOT / name).exists()
    assert all(re.search(rf"^{one} = \[", PYPROJECT, re.M) for one in extras.split(",") if one)


def assert_cmake(words: list[str]) -> None:
    options = re.findall(r"option\((\w+)", (ROOT / "CMakeLists.txt").read_text())
    for word in words:
        if word.startswith("-D"):
            name, value = word.removeprefix("-D").split("=")
            assert name in options or name.startswith("CMAKE_")
            assert name != "CMAKE_TOOLCHAIN_FILE" or (ROOT / value).exists()
        assert not word.startswith("--") or word.removeprefix("--") in CMAKE_OPTIONS


def test_what_the_page_of_ros_names_exists() -> None:
    """Programs and components with their packages, parameters, arguments of launch files."""
    code = code_of(TEXTS[ROS_PAGE])
    files = {path.name: path.read_text() for path in (ROOT / "cpp" / "ros").rglob("*.*")}
    builds = "\n".join(path.read_text() for path in (ROOT / "cpp" / "ros").rglob("CMakeLists.txt"))
    builds += TEXTS[ROS_PAGE]
    programs = re.findall(r"(?:run|load /\w+) (\w+) (\S+)", code)
    programs += re.findall(r'package="(\w+)", executable="(\w+)"', TEXTS[ROS_PAGE])
    arguments = {
        name: re.findall(r'^    "(\w+)": \(', files[name], re.M)
        for name in ("camera.launch.py", "playback.launch.py")
    }
    given = re.findall(r"(\w+\.launch\.py) ([^`\n]+)", code)
    parameters = re.findall(r"(?:-p |\s_|/asap[ /])(\w+)(?::=| \d)", code)
    assert len(programs) > 4 and len(given) > 1 and len(parameters) > 2
    for package, program in programs:
        assert f"project({package} " in builds
        assert re.search(
            rf"^(foreach\(program|add_exec|\w+register_nodes).*\b{program}\b", builds, re.M
        )
    for file, words in given:
        assert {word.split(":=")[0] for word in words.split()} <= {*arguments[file]}
    for name in parameters:
        assert f'Field{{"{name}"' in files["parameters.hpp"]


@pytest.mark.parametrize("line", shell_lines())
def test_a_line_of_the_shell_is_understood(line: str) -> None:
    run(["bash", "-n", "-c", line])
    words = shlex.split(line)
    if words[0] in NOT_RUN:
        return
    if words[0] == "asap" or words[0].endswith("bin/asap"):
        cli._parser().parse_args(words[1:])
    elif words[0].endswith("pip"):
        assert words[1] == "install"
        for what in words[2:]:
            assert_installs(what)
    elif words[0] == "cmake":
        assert_cmake(words[1:])
    elif words[0] in ROS_WORDS:
        assert all(
            (ROOT / path / "package.xml").exists() for path in re.findall(r"~/asap/(\S+)", line)
        )
    else:
        assert Path(words[0]).name in ("python", "python3")
        assert words[1:3] in (["-m", "venv"], ["-m", "pytest"])


@pytest.mark.parametrize("page", TEXTS)
def test_paths_and_presets_of_a_page_exist(page: str) -> None:
    code = code_of(TEXTS[page])
    paths = re.findall(r"(?<![\w./-])((?:cpp|python|tests|notebooks)/[\w./*-]*)", code)
    assert not [path for path in paths if not any(ROOT.glob(path.rstrip("./")))]
    presets = {one["name"] for kind in PRESETS if "Presets" in kind for one in PRESETS[kind]}
    assert {*re.findall(r"--preset ([\w-]+)", code)} <= presets


@pytest.mark.parametrize("page", TEXTS)
def test_options_of_the_laboratory_exist(page: str) -> None:
    parser = pytest.importorskip("asap_laboratory.cli")._parser()
    for command in re.findall(r"`asap-study ([^`]*)`", TEXTS[page]):
        if "..." not in command and command != "--help":
            parser.parse_args(shlex.split(command))


# ---- C++ and CMake ----

# What stands around a part of a program, by a word in it.
AROUND = {
    "asap::Tiled": "void f(asap::EventSpan events, std::span<std::uint8_t> corners) {{\n{}}}\n",
    "on_worker_start": "void f(asap::RunConfig config, asap::Consumer algorithm) {{\n"
    "auto scheme = asap::make_scheme<asap::Deadline>({{}});\n{}}}\n",
}
HEADERS = """#include <pthread.h>

#include <asap/algorithms/corner_detector.hpp>
#include <asap/runner/pipeline.hpp>
#include <asap/runner/tiled.hpp>
#include <asap/schemes/deadline.hpp>
"""
DRIVERS = ROOT / "tests" / "drivers"  # stub headers


def compiled(source: str, folder: Path, *, check: bool = True) -> str:
    """Compile without linking: a driver is a stub."""
    file = folder / "block.cpp"
    file.write_text(source)
    strict = ("-std=c++20", "-fsyntax-only", "-Wall", "-Wextra", "-Wconversion", "-Werror")
    return run(["g++", *strict, f"-I{INCLUDE}", f"-I{DRIVERS}", file], check=check)


@pytest.mark.parametrize(("page", "block"), blocks("cpp"))
def test_a_block_of_cpp_compiles(page: str, block: str, tmp_path: Path) -> None:
    examples = [path.read_text() for path in (ROOT / "cpp" / "examples").glob("*.cpp")]
    if any(textwrap.indent(block, "  ") in text for text in examples):
        return  # built and run
    if "int main(" not in block:
        (around,) = (text for word, text in AROUND.items() if word in block)
        block = HEADERS + around.format(block) + "int main() {}\n"
    compiled(block, tmp_path)


# What the examples of the headers take for granted.
TAKEN = """
using namespace asap;
using namespace std::chrono_literals;
struct Driver {
  void on_events(const std::function<void(EventSpan)>&) {}
};
extern std::vector<Event> events;
extern std::span<const std::byte> bytes;
extern EventSource& source;
extern Scheme& scheme;
extern Consumer algorithm;
extern ClusterTracker tracker;
extern Pipeline pipeline;
extern Simulator simulator;
extern Replay replay;
extern Driver driver;
void draw(auto...) {}
void show(std::span<const float>) {}
void write(const std::string&) {}
void fail(std::string_view) {}
"""
PLAIN = {  # data, tables and bases that no program makes
    *("core/nonblocking.hpp", "core/time.hpp", "formats/decoder.hpp", "runner/tiled.hpp"),
}


def examples_of(header: Path) -> list[str]:
    """The indented paragraphs of what stands before `#pragma once`, of code."""
    head = header.read_text().partition("#pragma once")[0]
    found = re.findall(r"(?:^//   .*\n)+", head, re.M)
    code = [re.sub(r"^//   ", "", text, flags=re.M) for text in found]
    return [text for text in code if re.search(r"[;{}](\s*//.*)?$", text, re.M)]


def test_every_public_header_has_an_example_that_compiles(tmp_path: Path) -> None:
    headers = {path.relative_to(INCLUDE).as_posix(): path for path in INCLUDE.glob("asap/*/*.hpp")}
    parts = [f"#include <{name}>" for name in ("array", "chrono", "functional", *headers)] + [TAKEN]
    for name, path in headers.items():
        if name.removeprefix("asap/") in PLAIN:
            continue
        examples = examples_of(path)
        assert examples, f"{name} has no example"
        for i, text in enumerate(examples):
            parts.append(f"void {re.sub('[^a-z0-9]', '_', name)}_{i}() {{\n{text}}}")
    file = tmp_path / "examples.cpp"
    file.write_text("\n".join(parts))
    run(["g++", "-std=c++20", "-fsyntax-only", f"-I{INCLUDE}", file])


def test_the_stubs_refuse_what_the_driver_has_not(tmp_path: Path) -> None:
    (recipe,) = [block for _, block in blocks("cpp") if "// evk4.cpp" in block]
    output = compiled(recipe.replace("add_callback", "on_events"), tmp_path, check=False)
    assert "error" in output and "on_events" in output


def test_every_example_is_on_the_page() -> None:
    names = {name_of(path) for path in (ROOT / "cpp" / "examples").glob("*.cpp")}
    assert names <= set(re.findall(r"\]\(\.\./(cpp/examples/\w+\.cpp)\)", CPP_PAGE.read_text()))


@pytest.mark.parametrize(("page", "block"), blocks("cmake"))
def test_targets_of_a_block_of_cmake_exist(page: str, block: str) -> None:
    table = re.findall(r"^\| `(asap::\w+)` \|", CPP_PAGE.read_text(), re.M)
    lists = "".join(path.read_text() for path in (ROOT / "cpp").rglob("CMakeLists.txt"))
    known = {name for name in table if f"asap_{name.removeprefix('asap::')}" in lists}
    assert set(re.findall(r"\basap::\w+", block)) <= known == set(table)
