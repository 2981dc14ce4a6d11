"""ASAP as a stranger gets it for C++: find_package, add_subdirectory, pkg-config."""

from __future__ import annotations

import os
import platform
import re
import shutil
from pathlib import Path

import pytest

import asap
from house import ROOT, cmake, native_build, run

pytestmark = [pytest.mark.slow, pytest.mark.full]  # it builds the library once more

EXAMPLES = ROOT / "cpp" / "examples"
OF_THE_CORE, OF_ALL = EXAMPLES / "own_scheme.cpp", EXAMPLES / "smallest_loop.cpp"
CORE, ALL = "asap::core asap::synthetic", "asap::algorithms asap::synthetic"
NO_EIGEN = {"CMAKE_DISABLE_FIND_PACKAGE_Eigen3": "ON"}
STRICT = "-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror"


@pytest.fixture(scope="module")
def prefix(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An installed asap that was moved after the installation."""
    folder = tmp_path_factory.mktemp("prefix")
    run(["cmake", "--install", native_build(), "--prefix", folder / "installed"])
    return (folder / "installed").rename(folder / "moved")


def eigen() -> dict[str, str]:
    """Where Eigen was found: a stranger has to know it too if it came from a wheel."""
    cache = (native_build() / "CMakeCache.txt").read_text()
    return dict(re.findall(r"^(Eigen3_DIR):PATH=(.*)$", cache, re.M))


def assert_the_examples_work(build: Path) -> None:
    output = run(["ctest", "--test-dir", build, "--output-on-failure"])
    assert f"out of {len(list(EXAMPLES.glob('*.cpp')))}\n" in output


def assert_it_works(program: Path) -> None:
    output = run([program])
    assert output.startswith("periodic: 47 %") or " events received, " in output, output


def stranger(folder: Path, way: str, library: str, program: str, **variables: str | Path) -> None:
    """Build a program on asap, found by this line of CMake, and run it."""
    folder.mkdir(exist_ok=True)
    (folder / "main.cpp").write_text(program)
    (folder / "CMakeLists.txt").write_text(
        f"cmake_minimum_required(VERSION 3.22)\nproject(stranger CXX)\n{way}\n"
        f"add_executable(stranger main.cpp)\ntarget_link_libraries(stranger {library})\n"
    )
    cmake(folder, folder / "build", CMAKE_CXX_FLAGS=STRICT, **variables)
    assert_it_works(folder / "build" / "stranger")


def known_targets(
    folder: Path, prefix: Path, ask: str = "COMPONENTS core OPTIONAL_COMPONENTS algorithms"
) -> str:
    """Return whether asap::algorithms is a target, and whether the package says that it is."""
    folder.mkdir(exist_ok=True)
    (folder / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.22)\nproject(stranger CXX)\n"
        f"find_package(asap REQUIRED {ask})\n"
        "set(known FALSE)\nif(TARGET asap::algorithms)\n  set(known TRUE)\nendif()\n"
        "file(WRITE ${CMAKE_BINARY_DIR}/known ${known},${asap_algorithms_FOUND})\n"
    )
    cmake(folder, folder / "build", CMAKE_PREFIX_PATH=prefix)
    return (folder / "build" / "known").read_text()


def with_one_include(example: Path) -> str:
    """Return an example that includes all of asap by one header."""
    one = "#include <asap/asap.hpp>\n"
    text, count = re.subn(r"(#include <asap/.*>\n)+", one, example.read_text())
    assert count == 1
    return text


def test_the_licence_comes_with_the_binaries(prefix: Path) -> None:
    installed = prefix / "share" / "doc" / "asap" / "LICENSE"
    assert installed.read_text() == (ROOT / "LICENSE").read_text()


def test_find_package(prefix: Path, tmp_path: Path) -> None:
    cmake(EXAMPLES, tmp_path, CMAKE_PREFIX_PATH=prefix, CMAKE_CXX_FLAGS=STRICT, **NO_EIGEN)
    assert_the_examples_work(tmp_path)


def test_one_header_includes_all(prefix: Path, tmp_path: Path) -> None:
    way, program = "find_package(asap REQUIRED)", with_one_include(OF_ALL)
    stranger(tmp_path, way, ALL, program, CMAKE_PREFIX_PATH=prefix, **NO_EIGEN)


def test_one_header_serves_the_core_alone(prefix: Path, tmp_path: Path) -> None:
    way, program = "find_package(asap REQUIRED)", with_one_include(OF_THE_CORE)
    stranger(tmp_path, way, CORE, program, CMAKE_PREFIX_PATH=prefix)


def test_find_package_refuses_another_version(prefix: Path, tmp_path: Path) -> None:
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.22)\nproject(stranger CXX)\n"
        "find_package(asap 99.0 REQUIRED)\n"
    )
    with pytest.raises(AssertionError, match=f"version: {re.escape(asap.__version__)}"):
        cmake(tmp_path, tmp_path / "build", CMAKE_PREFIX_PATH=prefix)


def test_a_component_that_is_there(prefix: Path, tmp_path: Path) -> None:
    minor = ".".join(asap.__version__.split(".")[:2])
    way = f"find_package(asap {minor} REQUIRED COMPONENTS core)"
    stranger(tmp_path, way, CORE, OF_THE_CORE.read_text(), CMAKE_PREFIX_PATH=prefix)


def test_the_core_is_built_and_found_where_there_is_no_eigen(tmp_path: Path) -> None:
    absent = {**NO_EIGEN, "ASAP_ALGORITHMS": "OFF"}
    cmake(ROOT, tmp_path / "asap", CMAKE_UNITY_BUILD="ON", **absent)
    run(["cmake", "--install", tmp_path / "asap", "--prefix", tmp_path / "prefix"])
    assert not list((tmp_path / "prefix").rglob("*algorithms*"))
    everything = with_one_include(OF_THE_CORE)
    ways = {
        "installed": "find_package(asap REQUIRED)",
        "folder": f'add_subdirectory("{ROOT}" asap EXCLUDE_FROM_ALL)',
    }
    for name, way in ways.items():
        folder, installed = tmp_path / name, tmp_path / "prefix"
        stranger(folder, way, CORE, everything, CMAKE_PREFIX_PATH=installed, **absent)
    assert known_targets(tmp_path / "asked", installed) == "FALSE,"
    with pytest.raises(AssertionError, match="ASAP_ALGORITHMS=OFF"):
        known_targets(tmp_path / "required", installed, "COMPONENTS algorithms")


def test_what_needs_the_algorithms_says_so(tmp_path: Path) -> None:
    words = "ASAP_TESTS = ON: needs the algorithms; set ASAP_ALGORITHMS = ON too"
    settings = ["-DASAP_TESTS=ON", "-DASAP_ALGORITHMS=OFF"]
    assert words in run(["cmake", "-S", ROOT, "-B", tmp_path, *settings], check=False)
    absent = [f"-D{name}={value}" for name, value in NO_EIGEN.items()]
    found = run(["cmake", "-S", ROOT, "-B", tmp_path / "all", *absent], check=False)
    assert "build the core alone with -DASAP_ALGORITHMS=OFF" in " ".join(found.split())


def test_shared_libraries_are_refused(tmp_path: Path) -> None:
    found = run(["cmake", "-S", ROOT, "-B", tmp_path, "-DBUILD_SHARED_LIBS=ON"], check=False)
    assert "BUILD_SHARED_LIBS = ON: the libraries are static" in found


def test_the_libraries_hold_no_symbol_of_others(prefix: Path, tmp_path: Path) -> None:
    """A weak symbol of another library would stand for its own in the whole program."""
    libraries = sorted(prefix.rglob("libasap_*.a"))
    names = run(["nm", "--demangle", "--defined-only", *libraries])
    weak = re.findall(r"^[0-9a-f]+ [uVWw] (.*)$", names, re.M)
    assert any("asap::" in name for name in weak)
    own = re.compile(r"\b(asap|std|__gnu_cxx)::|^DW\.ref\.")
    others = [name for name in weak if not own.search(name)]
    assert others == []
    assert not re.search(r"\bEigen::", names)


def test_a_shared_library_exports_none_of_ours(prefix: Path, tmp_path: Path) -> None:
    shared, libraries = tmp_path / "all.so", sorted(prefix.rglob("libasap_*.a"))
    whole = ["-Wl,--whole-archive", *libraries, "-Wl,--no-whole-archive"]
    run(["c++", "-shared", "-pthread", *whole, "-o", shared])
    exported = run(["nm", "--demangle", "--dynamic", "--defined-only", shared])
    assert [line for line in exported.splitlines() if re.match(r"\S+ \S asap::", line)] == []


PART = """#include <asap/runner/pipeline.hpp>
#include <asap/version.hpp>
#include <string>
std::string NAME() {
  asap::Pipeline pipeline{{.capacity = 100}, [](asap::EventSpan) {}};
  const asap::Event event{.x = 1, .y = 1, .p = 1, .t = 1};
  pipeline.push({&event, 1});
  pipeline.stop();
  pipeline.join();
  return std::to_string(pipeline.ledger().delivered) + " by " + std::string(asap::kVersion);
}
"""
MAIN = """#include <cstdio>
#include <string>
std::string ours();
std::string another();
int main() { std::printf("%s, %s", ours().c_str(), another().c_str()); }
"""


def test_two_versions_run_in_one_process(prefix: Path, tmp_path: Path) -> None:
    source = tmp_path / "source"
    shutil.copytree(ROOT / "cpp", source / "cpp")
    for name in ("CMakeLists.txt", "pyproject.toml", "LICENSE"):
        shutil.copy(ROOT / name, source)
    (project := source / "pyproject.toml").write_text(
        project.read_text().replace(f'version = "{asap.__version__}"', 'version = "99.9.0"')
    )
    for path in source.rglob("*.[ch]pp*"):
        path.write_text(re.sub(r"asap::inline v\d+_\d+", "asap::inline v99_9", path.read_text()))
    cmake(source, tmp_path / "build", CMAKE_UNITY_BUILD="ON", ASAP_ALGORITHMS="OFF")
    run(["cmake", "--install", tmp_path / "build", "--prefix", tmp_path / "another"])

    parts = {"ours": prefix, "another": tmp_path / "another"}
    cores = [core for folder in parts.values() for core in folder.rglob("libasap_core.a")]
    compiler = ["c++", "-std=c++20", "-pthread"]
    for name, folder in parts.items():
        (tmp_path / f"{name}.cpp").write_text(PART.replace("NAME", name))
        part = ["-c", tmp_path / f"{name}.cpp", "-o", tmp_path / f"{name}.o"]
        run([*compiler, f"-I{folder / 'include'}", *part])
    (tmp_path / "main.cpp").write_text(MAIN)
    objects = [tmp_path / "main.cpp", *(tmp_path / f"{name}.o" for name in parts)]
    run([*compiler, *objects, *cores, "-o", tmp_path / "both"])
    assert run([tmp_path / "both"]) == f"1 by {asap.__version__}, 1 by 99.9.0"


def test_the_core_holds_neither_formats_nor_scenes(prefix: Path) -> None:
    (core,) = prefix.rglob("libasap_core.a")
    names = run(["nm", "--demangle", "--defined-only", core])
    assert re.search(r"asap::v\d+_\d+::Deadline::Deadline", names)
    assert not re.search(r"asap::\w+::(Evt3Decoder|Encoder|FlightOverChairs)::", names)


def test_algorithms_may_be_optional(prefix: Path, tmp_path: Path) -> None:
    assert known_targets(tmp_path, prefix) == "TRUE,TRUE"


def test_add_subdirectory(tmp_path: Path) -> None:
    """With a stranger's strict flags on our headers, and without our optional tools."""
    absent = {
        f"CMAKE_DISABLE_FIND_PACKAGE_{name}": "ON"
        for name in ("GTest", "benchmark", "pybind11", "Python")
    }
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.22)\nproject(stranger CXX)\nenable_testing()\n"
        f'add_subdirectory("{ROOT}" asap EXCLUDE_FROM_ALL)\n'
        f'add_subdirectory("{EXAMPLES}" examples)\n'
    )
    build = tmp_path / "build"
    cmake(tmp_path, build, CMAKE_CXX_FLAGS=STRICT, **absent, **eigen())
    assert_the_examples_work(build)


def test_a_part_of_a_project_obeys_its_flags_and_installs_nothing(tmp_path: Path) -> None:
    """No exceptions, no build type: the library has exceptions and -O2 of its own."""
    (tmp_path / "main.cpp").write_text((EXAMPLES / "no_exceptions.cpp").read_text())
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.22)\nproject(stranger CXX)\n"
        f'add_subdirectory("{ROOT}" asap)\nadd_executable(stranger main.cpp)\n'
        f"target_link_libraries(stranger {ALL})\ninstall(TARGETS stranger)\n"
    )
    build = tmp_path / "build"
    without = {"CMAKE_CXX_FLAGS": "-fno-exceptions", "CMAKE_EXPORT_COMPILE_COMMANDS": "ON"}
    cmake(tmp_path, build, CMAKE_BUILD_TYPE="", CMAKE_UNITY_BUILD="ON", **without, **eigen())
    assert "Every event is accounted for." in run([build / "stranger"])
    commands = (build / "compile_commands.json").read_text()
    assert re.search(r"-O2.*asap_core", commands)
    run(["cmake", "--install", build, "--prefix", tmp_path / "prefix"])
    installed = [path.name for path in (tmp_path / "prefix").rglob("*") if path.is_file()]
    assert installed == ["stranger"]


@pytest.mark.parametrize(
    ("library", "example"), [("asap-core", OF_THE_CORE), ("asap-algorithms", OF_ALL)]
)
def test_pkg_config(library: str, example: Path, prefix: Path, tmp_path: Path) -> None:
    (folder,) = prefix.rglob("pkgconfig")
    env = {**os.environ, "PKG_CONFIG_PATH": str(folder)}
    flags = run(["pkg-config", "--cflags", "--libs", library, "asap-synthetic"], env=env).split()
    program = tmp_path / "program"
    run(["c++", "-std=c++20", "-O1", *STRICT.split(), example, *flags, "-o", program])
    assert_it_works(program)


@pytest.mark.skipif(platform.machine() != "x86_64", reason="needs a compiler that knows -m32")
def test_a_target_of_32_bits_is_refused(tmp_path: Path) -> None:
    """As on armhf. A compiler for x86 that only compiles shows it without a cross compiler."""
    flags = ["-DCMAKE_CXX_FLAGS=-m32", "-DCMAKE_TRY_COMPILE_TARGET_TYPE=STATIC_LIBRARY"]
    said = run(["cmake", "-S", ROOT, "-B", tmp_path, *flags], check=False)
    assert "asap needs a 64-bit target" in " ".join(said.split())
    assert "reference runs came out different" in " ".join(said.split())


def test_missing_sources_of_googletest_are_named(tmp_path: Path) -> None:
    """This machine as a target of its own: a system that is named counts as another one."""
    flags = ["-DCMAKE_SYSTEM_NAME=Linux", "-DCMAKE_CROSSCOMPILING_EMULATOR=env", "-DASAP_TESTS=ON"]
    flags += [f"-DASAP_GOOGLETEST={tmp_path}", *(f"-D{n}={place}" for n, place in eigen().items())]
    said = run(["cmake", "-S", ROOT, "-B", tmp_path / "build", *flags], check=False)
    assert f"ASAP_GOOGLETEST = {tmp_path}: " in " ".join(said.split())
    assert "apt-get install -y libgtest-dev" in " ".join(said.split())


def test_a_missing_cross_compiler_is_named(tmp_path: Path) -> None:
    script = tmp_path / "without_programs.cmake"
    script.write_text(
        f'set(ENV{{PATH}} "")\ninclude("{ROOT}/cpp/aarch64-linux-gnu.cmake")\n', encoding="utf-8"
    )
    said = run(["cmake", "-P", script], check=False)
    assert "apt-get install -y g++-aarch64-linux-gnu" in said
