"""No test of these is timed: a busy machine is no defect."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from hypothesis import settings

settings.register_profile("untimed", deadline=None)  # the rest as Hypothesis has chosen
settings.load_profile("untimed")

Call = Callable[..., tuple[int, str, str]]

HDF5 = ("h5", "hdf5", "dsec")
LIBRARIES = {"aedat4": "lz4", "mcap": "mcap", **dict.fromkeys(HDF5, "h5py")}


@pytest.fixture(autouse=True)
def library(request: pytest.FixtureRequest) -> None:
    """A format that a library reads and writes is tested where the library is installed."""
    given = getattr(request.node, "callspec", None)
    for name in ("to", "form", "suffix") if given else ():
        if (form := given.params.get(name)) in LIBRARIES:
            pytest.importorskip(LIBRARIES[form])


@pytest.fixture
def call(capsys: pytest.CaptureFixture[str]) -> Call:
    """Call the command line: exit code, stdout, stderr."""
    from asap import cli

    def call(*arguments: object) -> tuple[int, str, str]:
        code = cli.main([str(argument) for argument in arguments])
        return (code, *capsys.readouterr())

    return call
