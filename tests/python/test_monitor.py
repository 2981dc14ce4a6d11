"""The monitor: what the rows of a run say, on one screen of text."""

from __future__ import annotations

import io
import json
import os
import pty
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import streams
from asap import cli
from asap.experiment.telemetry import TELEMETRY_DTYPE, TelemetryFile
from asap.viewer import monitor

console = pytest.importorskip("rich.console", reason="needs the extra monitor")


def rows_of(count: int, *, since: int = 0, **columns: Any) -> np.ndarray:
    """Packages of 100 events, one each 10 ms, gamma .5, within a bound of 10 ms."""
    rows = np.zeros(count, TELEMETRY_DTYPE)
    rows["index"] = since + np.arange(count)
    rows["start_us"] = rows["index"] * 10_000
    rows["size"], rows["gamma"], rows["event_rate"] = 100, 0.5, 2e4
    rows["latency_max_us"], rows["latency_bound_us"] = 4000, 10_000
    rows["all_delivered"] = (rows["index"] + 1) * 100
    rows["all_discarded"] = rows["all_delivered"]
    rows["all_received"] = 2 * rows["all_delivered"]
    for name, value in columns.items():
        rows[name] = value
    return rows


def drawn(screen: monitor.Screen, width: int = 80) -> str:
    out = console.Console(record=True, width=width, file=io.StringIO(), color_system="standard")
    out.print(screen)
    return str(out.export_text(styles=False))


def test_the_panels_say_what_the_rows_say() -> None:
    screen = monitor.Screen("flight")
    screen.add(rows_of(500, all_pending=1234))
    text = drawn(screen)
    for words in (
        "flight",
        "20 kev/s",
        "100 ev x 100/s",
        "50.0 %",
        "4 ms of 10 ms",
        "1,234 events",
    ):
        assert words in text
    assert "delivered 50.0 %" in text and "discarded 50.0 %" in text
    assert "100,000 events received" in text and "stale" not in text


@pytest.mark.parametrize("width", [80, 132])
def test_it_is_one_screen(width: int) -> None:
    screen = monitor.Screen("a long name " * 20)
    for begin in range(0, 30_000, 500):
        screen.add(rows_of(500, since=begin, all_rejected=3, all_stale=5, all_filtered=7))
    lines = drawn(screen, width).rstrip("\n").split("\n")
    assert len(lines) <= 24 and max(map(len, lines)) <= width


def test_a_file_is_followed_through_its_changes(tmp_path: Path) -> None:
    path = tmp_path / "rows.csv"
    file = TelemetryFile(path)
    file._append(rows_of(30))
    tail = monitor.Tail(path)
    assert tail.read()["index"].tolist() == list(range(30))
    assert len(tail.read()) == 0
    with path.open("a") as half:
        half.write("30,3000")
    assert len(tail.read()) == 0
    path.rename(tmp_path / "rows.csv.1")
    file._in_file = 0
    file._append(rows_of(5, since=31))
    assert tail.read()["index"].tolist() == list(range(31, 36))


def test_a_file_that_is_being_made_has_no_rows_yet(tmp_path: Path) -> None:
    path = tmp_path / "rows.csv"
    path.touch()
    tail = monitor.Tail(path)
    assert len(tail.read()) == 0
    TelemetryFile(path)._append(rows_of(3))
    assert tail.read()["index"].tolist() == [0, 1, 2]


def test_the_newest_row_as_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    TelemetryFile(tmp_path / "rows.csv")._append(rows_of(7))
    assert cli.main(["monitor", str(tmp_path / "rows.csv"), "--json"]) == 0
    row = json.loads(capsys.readouterr().out)["row"]
    assert row["index"] == 6 and row["gamma"] == 0.5


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        ("monitor missing.csv", 3, "no such file"),
        ("monitor other.csv", 3, "no telemetry"),
        ("monitor rows.csv", 3, "no terminal"),
        ("run flight.npy --width 346 --height 260 --monitor", 3, "no terminal"),
        ("run flight.npy --cost 1us+1ns --monitor", 2, "--cost"),
    ],
)
def test_wrong_use_is_told(
    arguments: str,
    code: int,
    words: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("other.csv").write_text("t,x,y,p\n1,2,3,1\n")
    np.save("flight.npy", streams.poisson(1e5, 0.01))
    TelemetryFile("rows.csv")._append(rows_of(7))
    assert cli.main(arguments.split()) == code
    assert words in capsys.readouterr().err


def on_terminal(folder: Path, command: str) -> tuple[subprocess.Popen[bytes], int]:
    """Begin a verb whose stderr is a terminal, and give the other end of that."""
    np.save(folder / "flight.npy", streams.poisson(2e5, 1.0))
    ours, theirs = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "asap", *command.split()],
        stdout=subprocess.PIPE,
        stderr=theirs,
        cwd=folder,
        env={**os.environ, "TERM": "xterm", "COLUMNS": "100", "LINES": "30"},
    )
    os.close(theirs)
    return process, ours


def rest_of(terminal: int) -> str:
    shown = b""
    with suppress(OSError):  # it is closed
        while part := os.read(terminal, 1 << 16):
            shown += part
    os.close(terminal)
    return shown.decode()


def test_a_run_is_shown_on_its_terminal_and_ends_as_usual(tmp_path: Path) -> None:
    command = "run flight.npy --width 346 --height 260 --monitor --json"
    process, terminal = on_terminal(tmp_path, command)
    assert "waiting in the ring" in rest_of(terminal)
    out, _ = process.communicate()
    assert process.returncode == 0 and json.loads(out)["ledger"]["received"] > 100_000


def test_a_run_that_is_killed_gives_the_terminal_back(tmp_path: Path) -> None:
    command = "run --software-camera flight.npy --width 346 --height 260 --monitor --speed 0.01"
    process, terminal = on_terminal(tmp_path, command)
    shown = ""
    while "no package yet" not in shown and "waiting in" not in shown:
        shown += os.read(terminal, 1 << 16).decode(errors="replace")
    process.kill()
    process.communicate()
    assert rest_of(terminal).endswith("\x1b[?1049l")  # the other screen
