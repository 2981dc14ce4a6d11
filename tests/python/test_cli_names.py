"""Names on the command line: a user's own algorithm, completion, examples."""

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


def test_a_class_is_made_for_the_sensor(call: Call, folder: Path) -> None:
    assert call(*RUN, "pack.mine:Detector")[0] == 0
    mine = sys.modules["pack.mine"]
    assert {size for size, _ in mine.seen} == {(20, 10)}
    assert sum(count for _, count in mine.seen) == 200
    assert call(*RUN, "pack.mine:Outer.Inner")[0] == 0
    assert sum(count for _, count in mine.seen) == 400


def test_an_object_and_a_callable_are_used_as_they_are(call: Call, folder: Path) -> None:
    assert call(*RUN, "pack.mine:counter")[0] == 0
    mine = sys.modules["pack.mine"]
    assert mine.counter.events == 100
    code, out, _ = call(*RUN, "pack.mine:called", "--json")
    assert code == 0
    assert sum(map(len, mine.seen)) == 100
    assert json.loads(out)["ledger"]["delivered"] == 100


def test_the_current_directory_comes_first(folder: Path) -> None:
    """As with python -m: also when the command is a script that lies elsewhere."""
    code = "import sys; sys.path.pop(0); from asap import cli; sys.exit(cli.main())"
    given = [str(one) for one in (*RUN, "pack.mine:counter")]
    subprocess.run([sys.executable, "-c", code, *given], check=True, capture_output=True)


@pytest.mark.parametrize(
    ("spec", "code", "words"),
    [
        ("pack.mine:slow", 2, "TypeError: algorithm = "),
        ("pack.mine:Narrow", 2, "TypeError: "),
        ("broken:x", 2, '{folder}/broken.py", line 3, in <module>'),
        ("needs:x", 2, "ModuleNotFoundError: No module named 'no_such_library'"),
        ("wrong:x", 2, '{folder}/wrong.py", line 1'),
        ("pack.mine:failing", 1, "ValueError: the fifth corner"),
    ],
)
def test_own_code_fails_with_its_traceback(
    call: Call, folder: Path, spec: str, code: int, words: str
) -> None:
    got, out, err = call(*RUN, spec)
    assert (got, "pending" in out) == (code, code == 1)  # the run up to there
    assert err.startswith(f"asap: error: --algorithm {spec} failed:\nTraceback (most recent call")
    assert words.format(folder=folder) in err


@pytest.mark.parametrize("spec", ["pack.mine:", ":Detector", "pack.mine:number", "pack.mine:Empty"])
def test_what_is_no_algorithm_is_wrong_use(call: Call, folder: Path, spec: str) -> None:
    code, out, err = call(*RUN, spec)
    assert (code, out) == (2, "")
    assert "Traceback" not in err and "algorithm" in err


def test_an_error_of_the_recording_stays_one(call: Call, folder: Path) -> None:
    (folder / "few.npy").write_bytes((folder / "few.npy").read_bytes()[:100])
    code, _, err = call(*RUN, "pack.mine:counter")
    assert code == 3
    assert "--algorithm" not in err


def test_a_class_needs_to_know_the_sensor(call: Call, folder: Path) -> None:
    code, _, err = call("run", "few.npy", "--cost", "1us+1ns", "--algorithm", "pack.mine:Detector")
    assert (code, err.count("\n")) == (2, 1)
    assert "--width and --height" in err
    arguments = ("run", "few.npy", "--cost", "1us+1ns", "--algorithm", "pack.mine:counter")
    assert call(*arguments)[0] == 0


def verbs() -> dict[str, argparse.ArgumentParser]:
    actions = cli._parser()._actions
    return next(one for one in actions if isinstance(one, argparse._SubParsersAction)).choices


def test_every_verb_has_an_example_that_parses(call: Call) -> None:
    for verb, parser in verbs().items():
        example = (parser.epilog or "").removeprefix("example: ")
        assert example, verb
        words = shlex.split(example.removeprefix('eval "$(').removesuffix(')"'))
        cli._parser().parse_args(words[1:])
        assert example in call(verb, "--help")[1]


@pytest.mark.parametrize("shell", ["bash", "zsh"])
def test_a_script_completes_every_verb_and_option(call: Call, shell: str) -> None:
    pytest.importorskip("shtab")
    code, script, err = call("completion", shell)
    assert (code, err) == (0, "")
    for verb, parser in verbs().items():
        assert verb in script
        assert [one for one in parser._option_string_actions if one not in script] == []
    assert json.loads(call("completion", shell, "--json")[1])["script"] + "\n" == script
    if (program := shutil.which(shell)) is not None:
        subprocess.run([program, "-n"], input=script, text=True, check=True)
