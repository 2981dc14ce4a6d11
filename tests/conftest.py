"""Options of the whole suite: long tests, files to a worker, where the C++ tests are run."""

from __future__ import annotations

import os
from collections.abc import Generator

import pytest

from children import LONG


@pytest.hookimpl(optionalhook=True)  # of xdist
def pytest_xdist_auto_num_workers() -> int:
    """Three workers on two cores: a third of the time, tests wait for clocks and children."""
    return (os.cpu_count() or 1) * 3 // 2


def pytest_configure(config: pytest.Config) -> None:
    """Let xdist give each worker whole files: a file's slow fixtures are then made once."""
    if getattr(config.option, "dist", "no") == "load":
        config.option.dist = "loadfile"
        config.option.loadscopereorder = False


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Deselect the tests marked `full` unless ASAP_LONG_TESTS is set; begin with slow files."""
    long = [] if LONG else [item for item in items if item.get_closest_marker("full")]
    if long:
        config.hook.pytest_deselected(items=long)
        items[:] = [item for item in items if not item.get_closest_marker("full")]
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in slow)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_terminal_summary(config: pytest.Config) -> Generator[None, None, None]:
    """Say how to run the C++ tests after all else; pytest's closing line follows."""
    yield
    if config.get_verbosity() > -2:
        reporter = config.pluginmanager.get_plugin("terminalreporter")
        reporter.write_line("C++ tests: cmake --workflow --preset release")
