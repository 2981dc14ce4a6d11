"""python/bindings: a new file compiles whatever its neighbours are, and in any batch with them."""

from __future__ import annotations

import shutil
import sysconfig
from pathlib import Path

import pytest

from house import ROOT, run

BINDINGS = ROOT / "python" / "bindings"

NEW = """
#include "per_event.hpp"

namespace asap::python::newcomer {
namespace {

int process(int one, int more) { return one + more; }
int images(int one) { return one; }

void bind(py::module_& m) {
  m.def("process", &process);
  m.def("images", &images);
}

const AlgorithmBinding binding(&bind);

}  // namespace
}  // namespace asap::python::newcomer
"""


@pytest.mark.slow
def test_a_new_file_may_use_the_names_of_its_neighbours(tmp_path: Path) -> None:
    pybind11 = pytest.importorskip("pybind11")
    compiler = shutil.which("c++") or pytest.skip("no compiler")
    (tmp_path / "newcomer.cpp").write_text(NEW)
    neighbours = [BINDINGS / name for name in ("event_image.cpp", "noise_filters.cpp")]
    batch = [neighbours[0], tmp_path / "newcomer.cpp", neighbours[1]]
    unity = tmp_path / "batch.cpp"
    unity.write_text("".join(f'#include "{path}"\n' for path in batch))
    folders = [BINDINGS, ROOT / "cpp" / "include", ROOT / "cpp" / "src"]
    folders += [Path(pybind11.get_include()), Path(sysconfig.get_path("include"))]
    flags = ["-std=c++20", "-fvisibility=hidden", "-fsyntax-only", "-Wall", "-Werror"]
    run([compiler, *flags, *(f"-I{folder}" for folder in folders), unity], cwd=tmp_path)


def test_every_file_that_binds_has_a_namespace_of_its_own() -> None:
    for path in BINDINGS.glob("*.cpp"):
        text = path.read_text()
        if "\nvoid bind(py::module_& m)" in text:
            assert f"\nnamespace asap::python::{path.stem} {{\n" in text, path.name
