"""ASAP as a stranger gets it for Python: sdist, wheel, editable installation."""

from __future__ import annotations

import importlib.metadata
import os
import re
import shutil
import subprocess
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


def packed_again(folder: Path) -> Path:
    """Make a wheel of the installed files: what pip built for this environment."""
    installed = importlib.metadata.distribution("asap-events")
    info = f"asap_events-{asap.__version__}.dist-info"
    added_by_pip = {f"{info}/{name}" for name in ("INSTALLER", "REQUESTED", "direct_url.json")}
    names = [file.as_posix() for file in installed.files or ()]
    names = [name for name in names if name.startswith(("asap/", info)) and name[-4:] != ".pyc"]
    assert any("/_core." in name for name in names), "asap is editable: set ASAP_DIST"
    (tag,) = re.findall(r"^Tag: (.*)$", installed.read_text("WHEEL") or "", re.M)
    path = folder / f"asap_events-{asap.__version__}-{tag}.whl"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in {*names} - added_by_pip - {f"{info}/RECORD"}:
            archive.write(str(installed.locate_file(name)), name)
        rows = "".join(f"{name},,\n" for name in archive.namelist())
        archive.writestr(f"{info}/RECORD", f"{rows}{info}/RECORD,,\n")
    return path


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the wheel in the folder ASAP_DIST, or the installed one."""
    if given := os.environ.get("ASAP_DIST"):
        (path,) = Path(given).resolve().glob("asap_events-*.whl")
        return path
    return packed_again(tmp_path_factory.mktemp("wheel"))


@pytest.fixture(scope="module")
def sdist(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build an sdist of a checkout that holds files of its user too."""
    checkout, folder = tmp_path_factory.mktemp("checkout"), tmp_path_factory.mktemp("dist")
    for name in files_of_the_project() | FILES:
        (checkout / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, checkout / name)
    for name in STRAY:
        (checkout / name).parent.mkdir(parents=True, exist_ok=True)
        (checkout / name).write_text("mine")
    run([sys.executable, "-m", "build", "--sdist", "--outdir", folder, checkout])
    (path,) = folder.glob("*.tar.gz")
    return path


@pytest.fixture(scope="module")
def stranger(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The bin folder of an environment with the wheel and what it requires, no more."""
    folder = tmp_path_factory.mktemp("stranger")
    venv.create(folder, with_pip=True)
    run([folder / "bin" / "pip", "install", wheel])
    return folder / "bin"


def test_wheel_holds_the_package_alone(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    info = f"asap_events-{asap.__version__}.dist-info/"
    assert [name for name in names if not name.startswith(("asap/", info))] == []
    assert {Path(name).suffix for name in names if name.startswith("asap/")} == {
        *(".html", ".py", ".pyi", ".so", ".typed"),
    }
    assert {"asap/py.typed", "asap/_core.pyi", info + "licenses/LICENSE"} <= set(names)


# What a user may have put beside the sources: recordings, logs, environments, builds.
STRAY = (
    *("recording.npy", "notes.log", "venv/x", ".venv/x", "build/x.o", "dist/x.whl", "README.txt"),
    *("tests/python/__pycache__/x.pyc", "python/asap/_core.so"),
)


def names_in(sdist: Path) -> set[str]:
    with tarfile.open(sdist) as archive:
        return {member.name.partition("/")[2] for member in archive if member.isfile()}


def test_sdist_holds_the_sources_and_nothing_else(sdist: Path) -> None:
    names = names_in(sdist)
    assert not (files_of_the_project() | FILES) - names
    tops = {name.split("/")[0] for name in names}
    assert tops == FOLDERS | FILES | ADDED_BY_THE_BACKEND
    assert not names & set(STRAY)


@pytest.mark.full
def test_a_wheel_is_built_from_the_sdist_alone(sdist: Path, wheel: Path, tmp_path: Path) -> None:
    run([sys.executable, "-m", "pip", "wheel", "--no-deps", "-w", tmp_path, sdist])
    (built,) = tmp_path.glob("*.whl")
    assert built.name == wheel.name
    assert {*zipfile.ZipFile(built).namelist()} == {*zipfile.ZipFile(wheel).namelist()}


def test_a_missing_compiler_is_named_in_one_line(tmp_path: Path) -> None:
    command = ["cmake", "-S", ROOT, "-B", tmp_path]
    environment = os.environ | {"CXX": "no-such-compiler"}
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 1
    assert "\n  No C++20 compiler: apt-get install g++, or name yours in CXX.\n" in done.stderr


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
    assert "Bottleneck" in run([stranger / "python", "-c", program], cwd=tmp_path)
    assert "numpy" in run([stranger / "pip", "list"]).lower()


@pytest.mark.full
def test_editable_installation_follows_the_python_sources(sdist: Path, tmp_path: Path) -> None:
    run(["tar", "--extract", "--file", sdist, "--directory", tmp_path])
    (source,) = tmp_path.iterdir()
    venv.create(tmp_path / "venv", with_pip=True)
    binaries = tmp_path / "venv" / "bin"
    run([binaries / "pip", "install", "--editable", source])
    edited = source / "python" / "asap" / "_units.py"
    edited.write_text(edited.read_text() + "\nEDITED = True\n")
    program = (
        "import asap; from asap import _units; print(asap.GammaFilter().position, _units.EDITED)"
    )
    assert run([binaries / "python", "-c", program], cwd=tmp_path) == "0 True\n"


def test_the_laboratory_is_not_in_the_wheel(stranger: Path, tmp_path: Path) -> None:
    program = """if True:
        import importlib.util
        import asap
        names = {*dir(asap), *dir(asap._core)}
        assert not names & {"scenes", "score", "keep_curve", "profiles", "JaerTimer", "SceneLayout"}
        assert importlib.util.find_spec("asap_laboratory") is None
    """
    run([stranger / "python", "-c", program], cwd=tmp_path)


def test_without_matplotlib_a_figure_names_the_extra(stranger: Path, tmp_path: Path) -> None:
    program = """if True:
        import asap
        scene = asap.synthetic.FlightOverChairs(duration_s=0.01)
        asap.simulate(scene, cost=asap.LinearCost(20, 150)).plot()
    """
    output = run([stranger / "python", "-c", program], cwd=tmp_path, check=False)
    assert "asap-events[report]" in output.splitlines()[-1]
