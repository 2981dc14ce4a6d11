"""The C++ tests, one layer at a time: built in Release, run by ctest."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest

from house import ROOT, native_build, run

LAYERS = sorted({path.parent.name for path in (ROOT / "tests" / "cpp").glob("*/*_test.cpp")})
LAYERS.append("simulation")


@pytest.mark.slow
@pytest.mark.parametrize("layer", LAYERS)
def test_layer(layer: str, tmp_path: Path) -> None:
    report = tmp_path / "report.xml"
    build = native_build()
    select = ["--tests-regex", rf"^{layer}\.", "--no-tests=error"]
    output = run(
        ["ctest", "--test-dir", build, *select, "--output-junit", report, "--timeout", "600"],
        check=False,
    )
    cases = list(ElementTree.parse(report).iter("testcase"))
    assert cases, output
    failed = [case for case in cases if case.get("status") == "fail"]
    assert not failed, "\n\n".join(
        f"{case.get('name')}\n{case.findtext('system-out')}" for case in failed
    )
