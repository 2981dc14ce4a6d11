"""ASAP as a stranger gets it for Python: sdist, wheel, editable installation."""

from __future__ import annotations

import os
import shutil
import sys
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest

import asap
from house import ROOT, run

pytestmark = pytest.mark.slow

FOLDERS = {"cpp", "notebooks", "python", "tests"}
FILES = {"CHANGELOG.md", "CMakeLists.txt", "CMakePresets.json", "LICENSE", "README.md"}
FILES |= {".gitignore", "pyproject.toml"}
ADDED_BY_THE_BACKEND = {"PKG-INFO"}


def files_of_the_project() -> set[str]:
    """Return the files in FOLDERS that git does not ignore; without git, all but caches."""
    if (ROOT / ".git").exists():
        git = ["git", "-c", f"safe.directory={ROOT}", "-C", ROOT]
        listed = run([*git, "ls-files", "-z", "-co", "--exclude-standard", *FOLDERS])
        return {name for name in listed.split("\0") if name and (ROOT / name).is_file()}
    found = [path for folder in FOLDERS for path in (ROOT / folder).rglob("*") if path.is_file()]
    names = {path.relative_to(ROOT).as_posix() for path in found}
    return {name for name in names if "__pycache__" not in name and "/." not in name}


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build an sdist of a checkout that holds files of its user too.

    Unless ASAP_DIST is set, also build a wheel from that sdist alone.
    """
    checkout, folder = tmp_path_factory.mktemp("checkout"), tmp_path_factory.mktemp("dist")
    for name in files_of_the_project() | FILES:
        (checkout / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, checkout / name)
    for name in STRAY:
        (checkout / name).parent.mkdir(parents=True, exist_ok=True)
        (checkout / name).write_text("mine")
    parts = ["--sdist"] if "ASAP_DIST" in os.environ else []
    run([sys.executable, "-m", "build", *parts, "--outdir", folder, checkout])
    return folder


@pytest.fixture(scope="module")
def dist(request: pytest.FixtureRequest) -> Path:
    """Return the folder ASAP_DIST, which holds one sdist and one wheel, or build both."""
    given = os.environ.get("ASAP_DIST")
    return Path(given).resolve() if given else request.getfixturevalue("built")


@pytest.fixture(scope="module")
def stranger(dist: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The bin folder of an environment with the wheel and what it requires, no more."""
    folder = tmp_path_factory.mktemp("stranger")
    venv.create(folder, with_pip=True)
    run([folder / "bin" / "pip", "install", *dist.glob("*.whl")])
    return folder / "bin"


def test_wheel_holds_the_package_alone(dist: Path) -> None:
    (wheel,) = dist.glob("*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    info = f"asap_events-{asap.__version__}.dist-info/"
    assert [name for name in names if not name.startswith(("asap/", info))] == []
    assert {Path(name).suffix for name in names if name.startswith("asap/")} == {
        *(".py", ".pyi", ".so", ".typed"),
    }
    assert {"asap/py.typed", "asap/_core.pyi", info + "licenses/LICENSE"} <= set(names)


# What a user may have put beside the sources: recordings, logs, environments, builds.
STRAY = (
    *("recording.npy", "notes.log", "venv/x", ".venv/x", "build/x.o", "dist/x.whl", "README.txt"),
    *("tests/python/__pycache__/x.pyc", "python/asap/_core.so"),
)


@pytest.mark.parametrize("where", ["built", "dist"])
def test_sdist_holds_the_sources_and_nothing_else(
    where: str, request: pytest.FixtureRequest
) -> None:
    (sdist,) = request.getfixturevalue(where).glob("*.tar.gz")
    with tarfile.open(sdist) as archive:
        names = {member.name.partition("/")[2] for member in archive if member.isfile()}
    assert not (files_of_the_project() | FILES) - names
    tops = {name.split("/")[0] for name in names}
    assert tops == FOLDERS | FILES | ADDED_BY_THE_BACKEND
    assert not names & set(STRAY)


@pytest.mark.full
def test_a_wheel_is_built_from_the_sdist_alone(dist: Path, tmp_path: Path) -> None:
    """The wheel in ASAP_DIST may have been built from the checkout."""
    run([sys.executable, "-m", "pip", "wheel", "--no-deps", "-w", tmp_path, *dist.glob("*.tar.gz")])
    (ours,), (theirs,) = tmp_path.glob("*.whl"), dist.glob("*.whl")
    assert ours.name == theirs.name
    assert {*zipfile.ZipFile(ours).namelist()} == {*zipfile.ZipFile(theirs).namelist()}


def test_import_from_elsewhere(stranger: Path, tmp_path: Path) -> None:
    where = run([stranger / "python", "-c", "import asap; print(asap.__file__)"], cwd=tmp_path)
    assert where.startswith(str(stranger.parent))


def test_command(stranger: Path, tmp_path: Path) -> None:
    assert run([stranger / "asap", "--version"], cwd=tmp_path) == f"asap {asap.__version__}\n"


def test_numpy_is_enough_for_a_run(stranger: Path, tmp_path: Path) -> None:
    program = """if True:
        import asap
        scene = asap.synthetic.FlightOverChairs(duration_s=0.1)
        tracker = asap.ClusterTracker(scene.width, scene.height)
        run = asap.simulate(scene, cost=asap.LinearCost(20, 150), algorithm=tracker)
        assert run.ledger.balanced and tracker.clusters.size
        print(run)
    """
    assert "Verdict" in run([stranger / "python", "-c", program], cwd=tmp_path)
    assert "numpy" in run([stranger / "pip", "list"]).lower()


@pytest.mark.full
def test_editable_installation_follows_the_python_sources(dist: Path, tmp_path: Path) -> None:
    run(["tar", "--extract", "--file", *dist.glob("*.tar.gz"), "--directory", tmp_path])
    (source,) = tmp_path.iterdir()
    venv.create(tmp_path / "venv", with_pip=True)
    binaries = tmp_path / "venv" / "bin"
    run([binaries / "pip", "install", "--editable", source])
    edited = source / "python" / "asap" / "units.py"
    edited.write_text(edited.read_text() + "\nEDITED = True\n")
    program = (
        "import asap; from asap import units; print(asap.GammaFilter().position, units.EDITED)"
    )
    assert run([binaries / "python", "-c", program], cwd=tmp_path) == "0 True\n"


def test_without_matplotlib_a_figure_names_the_extra(stranger: Path, tmp_path: Path) -> None:
    program = """if True:
        import asap
        scene = asap.synthetic.FlightOverChairs(duration_s=0.01)
        asap.simulate(scene, cost=asap.LinearCost(20, 150)).plot()
    """
    output = run([stranger / "python", "-c", program], cwd=tmp_path, check=False)
    assert "asap-events[report]" in output.splitlines()[-1]
