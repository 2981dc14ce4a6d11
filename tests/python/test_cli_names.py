"""Names on the command line: a user's own algorithm, nearest names, completion, examples."""

from __future__ import annotations

import argparse
import json
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

import asap as package
import streams
from asap import cli

Call = Callable[..., tuple[int, str, str]]

MINE = """
from functools import partial

from helper import doubled

seen = []

class Detector:
    def __init__(self, width, height):
        self.size = (width, height)
    def process(self, events):
        seen.append((self.size, len(doubled(events))))

class Counter:
    def __init__(self):
        self.events = 0
    def process(self, events):
        self.events += len(events)

class Outer:
    class Inner(Detector):
        pass

class Narrow:
    def __init__(self):
        pass
    def process(self, events):
        pass

class Empty:
    def __init__(self, width, height):
        pass

counter = Counter()
called = seen.append
number = 5

def failing(events):
    raise ValueError("the fifth corner")

async def slow(events):
    pass
"""


@pytest.fixture
def asap(capsys: pytest.CaptureFixture[str]) -> Call:
    def call(*arguments: object) -> tuple[int, str, str]:
        code = cli.main([str(argument) for argument in arguments])
        return (code, *capsys.readouterr())

    return call


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A current directory with a package, and a recording of 100 events."""
    (tmp_path / "pack").mkdir()
    (tmp_path / "pack" / "__init__.py").touch()
    (tmp_path / "pack" / "mine.py").write_text(MINE)
    (tmp_path / "helper.py").write_text("def doubled(events):\n    return [*events, *events]\n")
    (tmp_path / "broken.py").write_text("import numpy\n\n1 / 0\n")
    (tmp_path / "needs.py").write_text("import no_such_library\n")
    (tmp_path / "wrong.py").write_text("def (\n")
    np.save(tmp_path / "few.npy", streams.make(np.arange(100) * 100, x=3, y=4))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [one for one in sys.path if one])
    known = set(sys.modules)
    yield tmp_path
    for name in set(sys.modules) - known:
        if name.partition(".")[0] in {"pack", "helper", "broken", "needs", "wrong"}:
            del sys.modules[name]


RUN = ("run", "few.npy", "--width", 20, "--height", 10, "--cost", "1us+1ns", "--algorithm")


def test_a_class_is_made_for_the_sensor(asap: Call, folder: Path) -> None:
    assert asap(*RUN, "pack.mine:Detector")[0] == 0
    mine = sys.modules["pack.mine"]
    assert {size for size, _ in mine.seen} == {(20, 10)}
    assert sum(count for _, count in mine.seen) == 200
    assert asap(*RUN, "pack.mine:Outer.Inner")[0] == 0
    assert sum(count for _, count in mine.seen) == 400


def test_an_object_and_a_callable_are_used_as_they_are(asap: Call, folder: Path) -> None:
    assert asap(*RUN, "pack.mine:counter")[0] == 0
    mine = sys.modules["pack.mine"]
    assert mine.counter.events == 100
    code, out, _ = asap(*RUN, "pack.mine:called", "--json")
    assert code == 0
    assert sum(map(len, mine.seen)) == 100
    assert json.loads(out)["ledger"]["delivered"] == 100


def test_the_current_directory_comes_first(folder: Path) -> None:
    """As with python -m: also when the command is a script that lies elsewhere."""
    code = "import sys; sys.path.pop(0); from asap import cli; sys.exit(cli.main())"
    given = [str(one) for one in (*RUN, "pack.mine:counter")]
    subprocess.run([sys.executable, "-c", code, *given], check=True, capture_output=True)


@pytest.mark.parametrize(
    ("spec", "words"),
    [
        ("no_such:Detector", "there is no module no_such in {folder} or on Python's path"),
        ("pack.mien:Detector", "there is no module pack.mien in {folder}"),
        ("pack.mine:Detectr", "pack/mine.py) has no Detectr; did you mean Detector?"),
        ("pack.mine:Outer.Iner", "has no Iner; did you mean Inner?"),
        ("pack.mine:number", "module pack.mine ({folder}/pack/mine.py) it is neither"),
        ("pack.mine:Empty", "{folder}/pack/mine.py) it is neither callable nor"),
        ("pack.mine:Narrow", "Narrow(20, 10) in module pack.mine ({folder}/pack/mine.py) failed"),
        ("pack.mine:slow", "mine.py): algorithm = <function slow"),
        ("pack.mine:", "write package.module:name"),
        (":Detector", "write package.module:name"),
        ("broken:x", "importing broken failed: ZeroDivisionError"),
        ("broken:x", "{folder}/broken.py:3"),
        ("needs:x", "importing needs failed: ModuleNotFoundError: No module named 'no_such_lib"),
        ("wrong:x", "importing wrong failed: SyntaxError"),
        ("wrong:x", "wrong.py, line 1"),
    ],
)
def test_errors_name_module_and_path(asap: Call, folder: Path, spec: str, words: str) -> None:
    code, out, err = asap(*RUN, spec)
    assert (code, out) == (2, "")
    assert words.format(folder=folder) in err
    assert err.startswith(f"asap: error: --algorithm {spec}") and err.count("\n") == 1


def test_an_error_of_the_algorithm_is_neither_the_recordings_nor_the_options(
    asap: Call, folder: Path
) -> None:
    code, out, err = asap(*RUN, "pack.mine:failing")
    assert (code, out) == (1, "")
    line = MINE[: MINE.index("raise ValueError")].count("\n") + 1
    last = f"ValueError: the fifth corner ({folder}/pack/mine.py:{line})"
    assert err.endswith(f"asap: error: --algorithm pack.mine:failing: {last}\n")
    assert "site-packages" not in err and "Traceback" in err


def test_an_error_of_the_recording_stays_one(asap: Call, folder: Path) -> None:
    (folder / "few.npy").write_bytes((folder / "few.npy").read_bytes()[:100])
    code, _, err = asap(*RUN, "pack.mine:counter")
    assert code == 3
    assert "--algorithm" not in err


def test_a_class_needs_to_know_the_sensor(asap: Call, folder: Path) -> None:
    code, _, err = asap("run", "few.npy", "--cost", "1us+1ns", "--algorithm", "pack.mine:Detector")
    assert (code, err.count("\n")) == (2, 1)
    assert "--width, --height" in err
    arguments = ("run", "few.npy", "--cost", "1us+1ns", "--algorithm", "pack.mine:counter")
    assert asap(*arguments)[0] == 0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["rum", "f"], "invalid choice: 'rum'; did you mean run?"),
        (["xyz"], "'xyz'; choose from demo, run, compare"),
        (["--versoin"], "unknown option --versoin; did you mean --version?"),
        (["run", "f", "--latancy", "10ms"], "unknown option --latancy; did you mean --latency?"),
        (["run", "f", "--latancy=10ms"], "did you mean --latency?"),
        (["compare", "f", "--cots", "1us+1ns"], "unknown option --cots; did you mean --cost?"),
        (["info", "f", "--cost", "1us+1ns"], "unknown option --cost; "),
        (["run", "f", "--scheme", "dedline"], "did you mean deadline?"),
        (["run", "f", "--algorithm", "cluster"], "did you mean clusters?"),
        (["info", "f", "--on-bad", "rise"], "did you mean raise?"),
        (["run", "f", "-q"], "unrecognized arguments: -q"),
        (["run", "f", "--latency", "10"], "latency = 10: the unit is missing"),
        (["run"], "required: FILE"),
    ],
)
def test_wrong_names_take_one_line_with_the_nearest(
    asap: Call, arguments: list[str], words: str
) -> None:
    code, out, err = asap(*arguments)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert err.startswith("asap: error: ") and words in err


def test_options_may_be_shortened_and_files_may_look_like_options(asap: Call, folder: Path) -> None:
    assert asap("run", "few.npy", "--cost", "1us+1ns", "--lat", "5ms", "--js")[0] == 0
    (folder / "few.npy").rename(folder / "--few.npy")
    assert asap("info", "--", "--few.npy")[0] == 0


def verbs() -> dict[str, argparse.ArgumentParser]:
    actions = cli._parser()._actions
    return next(one for one in actions if isinstance(one, argparse._SubParsersAction)).choices


def test_every_verb_has_an_example_that_parses(asap: Call) -> None:
    for verb, parser in verbs().items():
        example = (parser.epilog or "").removeprefix("example: ")
        assert example, verb
        words = shlex.split(example.removeprefix('eval "$(').removesuffix(')"'))
        cli._parser().parse_args(words[1:])
        assert example in asap(verb, "--help")[1]


def completed(script: str, *words: str) -> list[str]:
    line = " ".join(map(shlex.quote, words))
    ask = f'COMP_WORDS=({line}); COMP_CWORD={len(words) - 1}; _asap; echo "${{COMPREPLY[@]}}"'
    command = ["bash", "-c", f"set -u\n{script}\n{ask}"]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()


@pytest.mark.skipif(shutil.which("bash") is None, reason="needs bash")
def test_bash_completes_verbs_options_and_choices(asap: Call) -> None:
    code, script, err = asap("completion", "bash")
    assert (code, err) == (0, "")
    assert {*completed(script, "asap", "")} == {*verbs(), "--help", "--version"}
    assert completed(script, "asap", "comp") == ["compare", "completion"]
    assert completed(script, "asap", "run", "few.npy", "--lat") == ["--latency"]
    assert completed(script, "asap", "run", "few.npy", "--scheme", "dead") == [
        "deadline",
        "dead_beat",
    ]
    assert completed(script, "asap", "run", "few.npy", "--algorithm", "c") == ["clusters"]
    assert completed(script, "asap", "run", "") == []  # files
    assert completed(script, "asap", "run", "f", "--report", "") == []
    assert completed(script, "asap", "completion", "") == ["bash", "zsh"]


def test_zsh_has_the_same_words(asap: Call) -> None:
    bash, zsh = asap("completion", "bash")[1], asap("completion", "zsh")[1]
    assert zsh.startswith("#compdef asap\n")
    cases = [line for line in bash.splitlines() if "found=" in line]
    assert cases and cases == [line for line in zsh.splitlines() if "found='" in line]
    if (shell := shutil.which("zsh")) is not None:
        subprocess.run([shell, "-n"], input=zsh, text=True, check=True)
    assert json.loads(asap("completion", "zsh", "--json")[1])["script"] == zsh


def test_the_names_of_ours_stay() -> None:
    parse = cli._parser().parse_args
    for name in cli.run.ALGORITHMS:
        assert parse(["run", "f", "--algorithm", name]).algorithm == name
    assert package.ClusterTracker
