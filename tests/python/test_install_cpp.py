"""ASAP as a stranger gets it for C++: find_package, add_subdirectory, pkg-config."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import pytest

import asap
from house import ROOT, cmake, native_build, run

pytestmark = pytest.mark.slow

CONSUMER = ROOT / "tests" / "consumer"
STRICT = "-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror"


@pytest.fixture(scope="module")
def prefix(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An installed asap that was moved after the installation."""
    folder = tmp_path_factory.mktemp("prefix")
    run(["cmake", "--install", native_build(), "--prefix", folder / "installed"])
    return (folder / "installed").rename(folder / "moved")


def eigen() -> dict[str, str]:
    """Where Eigen was found: a consumer has to know it too if it came from a wheel."""
    cache = (native_build() / "CMakeCache.txt").read_text()
    return dict(re.findall(r"^(Eigen3_DIR):PATH=(.*)$", cache, re.M))


def assert_it_works(consumer: Path) -> None:
    output = run([consumer])
    assert re.fullmatch(r"(\d+) received, \1 delivered in \d+ packages, \d+ clusters\n", output)


def assert_it_lives(live: Path) -> None:
    output = run([live])
    found = re.match(r"(\d+) received, (\d+) delivered in \d+ packages, the slowest", output)
    assert found, output
    received, delivered = map(int, found.groups())
    assert 0 < delivered <= received


def test_the_licence_comes_with_the_binaries(prefix: Path) -> None:
    installed = prefix / "share" / "doc" / "asap" / "LICENSE"
    assert installed.read_text() == (ROOT / "LICENSE").read_text()


def test_find_package(prefix: Path, tmp_path: Path) -> None:
    cmake(CONSUMER / "find_package", tmp_path, CMAKE_PREFIX_PATH=prefix, **eigen())
    assert_it_works(tmp_path / "consumer")
    assert_it_lives(tmp_path / "live")


def test_find_package_refuses_another_version(prefix: Path, tmp_path: Path) -> None:
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.22)\nproject(stranger CXX)\n"
        "find_package(asap 99.0 REQUIRED)\n"
    )
    with pytest.raises(AssertionError, match=f"version: {re.escape(asap.__version__)}"):
        cmake(tmp_path, tmp_path / "build", CMAKE_PREFIX_PATH=prefix)


def test_the_core_alone_needs_no_eigen(prefix: Path, tmp_path: Path) -> None:
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.22)\nproject(stranger CXX)\n"
        "find_package(asap REQUIRED COMPONENTS core)\n"
        "add_executable(stranger main.cpp)\ntarget_link_libraries(stranger asap::core)\n"
    )
    (tmp_path / "main.cpp").write_text(
        "#include <asap/schemes/asap2020.hpp>\nint main() { return asap::Asap2020{}.name()[0]; }\n"
    )
    absent = {"CMAKE_DISABLE_FIND_PACKAGE_Eigen3": "ON"}
    cmake(tmp_path, tmp_path / "build", CMAKE_PREFIX_PATH=prefix, **absent)
    assert subprocess.run([tmp_path / "build" / "stranger"], check=False).returncode == ord("a")


def test_the_core_is_built_and_found_where_there_is_no_eigen(tmp_path: Path) -> None:
    absent = {"CMAKE_DISABLE_FIND_PACKAGE_Eigen3": "ON", "ASAP_ALGORITHMS": "OFF"}
    cmake(ROOT, tmp_path / "asap", CMAKE_UNITY_BUILD="ON", **absent)
    run(["cmake", "--install", tmp_path / "asap", "--prefix", tmp_path / "prefix"])
    assert not list((tmp_path / "prefix").rglob("*algorithms*"))
    everything = "#include <asap/asap.hpp>\nint main() { return asap::Asap2020{}.name()[0]; }\n"
    doors = {
        "installed": "find_package(asap REQUIRED)",
        "folder": f'add_subdirectory("{ROOT}" asap EXCLUDE_FROM_ALL)',
    }
    for name, door in doors.items():
        folder = tmp_path / name
        folder.mkdir()
        (folder / "main.cpp").write_text(everything)
        (folder / "CMakeLists.txt").write_text(
            f"cmake_minimum_required(VERSION 3.22)\nproject(stranger CXX)\n{door}\n"
            "add_executable(stranger main.cpp)\ntarget_link_libraries(stranger asap::core)\n"
        )
        cmake(folder, folder / "build", CMAKE_PREFIX_PATH=tmp_path / "prefix", **absent)
        done = subprocess.run([folder / "build" / "stranger"], check=False)
        assert done.returncode == ord("a")


def test_what_needs_the_algorithms_says_so(tmp_path: Path) -> None:
    words = "ASAP_TESTS = ON: needs the algorithms; set ASAP_ALGORITHMS = ON too"
    settings = ["-DASAP_TESTS=ON", "-DASAP_ALGORITHMS=OFF"]
    assert words in run(["cmake", "-S", ROOT, "-B", tmp_path, *settings], check=False)
    absent = "-DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON"
    found = run(["cmake", "-S", ROOT, "-B", tmp_path / "all", absent], check=False)
    assert "build the core alone with -DASAP_ALGORITHMS=OFF" in " ".join(found.split())


@pytest.mark.parametrize("absent", [{"CMAKE_DISABLE_FIND_PACKAGE_Eigen3": "ON"}, {}], ids=len)
def test_algorithms_may_be_optional(absent: dict[str, str], prefix: Path, tmp_path: Path) -> None:
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.22)\nproject(stranger CXX)\n"
        "find_package(asap REQUIRED COMPONENTS core OPTIONAL_COMPONENTS algorithms)\n"
        "set(known FALSE)\nif(TARGET asap::algorithms)\n  set(known TRUE)\nendif()\n"
        "file(WRITE ${CMAKE_BINARY_DIR}/known ${known},${asap_algorithms_FOUND})\n"
    )
    cmake(tmp_path, tmp_path / "build", CMAKE_PREFIX_PATH=prefix, **(absent or eigen()))
    known = (tmp_path / "build" / "known").read_text()
    assert known == ("FALSE," if absent else "TRUE,TRUE")


@pytest.mark.full
def test_add_subdirectory(tmp_path: Path) -> None:
    """With a stranger's strict flags on our headers, and without our optional tools."""
    absent = {
        f"CMAKE_DISABLE_FIND_PACKAGE_{name}": "ON"
        for name in ("GTest", "benchmark", "pybind11", "Python")
    }
    cmake(
        CONSUMER / "add_subdirectory",
        tmp_path,
        ASAP_SOURCE_DIR=ROOT,
        CMAKE_CXX_FLAGS=STRICT,
        **absent,
        **eigen(),
    )
    assert_it_works(tmp_path / "consumer")
    assert_it_lives(tmp_path / "live")


def test_pkg_config(prefix: Path, tmp_path: Path) -> None:
    (folder,) = prefix.rglob("pkgconfig")
    env = {**os.environ, "PKG_CONFIG_PATH": str(folder)}
    flags = run(["pkg-config", "--cflags", "--libs", "asap-algorithms"], env=env).split()
    consumer = tmp_path / "consumer"
    run(["c++", "-std=c++20", "-O1", CONSUMER / "main.cpp", *flags, "-o", consumer])
    assert_it_works(consumer)


@pytest.mark.parametrize("include", ["include", "/elsewhere/include"])
def test_pkg_config_knows_absolute_directories(include: str, tmp_path: Path) -> None:
    places = {"PREFIX": "/prefix", "LIBDIR": "/somewhere/lib", "INCLUDEDIR": include}
    settings = [f"-DCMAKE_INSTALL_{name}={place}" for name, place in places.items()]
    settings += [f"-D{name}={place}" for name, place in eigen().items()]
    run(["cmake", "-S", ROOT, "-B", tmp_path, *settings])
    env = {**os.environ, "PKG_CONFIG_PATH": str(tmp_path / "cpp")}
    for name, place in (("libdir", "/somewhere/lib"), ("includedir", include)):
        found = run(["pkg-config", f"--variable={name}", "asap-core"], env=env).strip()
        assert found == str(Path("/prefix", place))
