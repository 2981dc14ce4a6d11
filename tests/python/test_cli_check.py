"""asap check as a user calls it."""

import json
from contextlib import nullcontext

import numpy as np
import pytest

import asap
import corrupt
from asap import _progress, cli
from event_files import write_csv

SENSOR = ("--width", corrupt.WIDTH, "--height", corrupt.HEIGHT)
EVENTS = corrupt.clean_events(2000)


@pytest.fixture
def call(capsys):
    """Calls the verb: exit code, stdout, stderr."""

    def call(*arguments):
        code = cli.main(["check", *(str(argument) for argument in arguments)])
        return (code, *capsys.readouterr())

    return call


@pytest.fixture
def save(tmp_path):
    def save(events):
        path = tmp_path / "flight & co.npy"
        np.save(path, events)
        return path

    return save


def test_a_clean_recording(call, save):
    path = save(EVENTS)
    inspection = asap.check(path, width=corrupt.WIDTH, height=corrupt.HEIGHT)
    assert call(path, *SENSOR) == (0, f"{inspection}\n", "")
    code, out, err = call(path)
    assert (code, err) == (0, "")
    assert "sensor unknown: not checked; addresses up to x = 345, y = 259" in out
    assert "Verdict: ok. Nothing is wrong with this recording. To note: " in out
    assert "--width, --height" in out


def test_how_far_it_has_come_is_told_at_a_terminal(call, save, monkeypatch):
    told = []
    monkeypatch.setattr(_progress, "on_terminal", lambda: nullcontext(lambda *so: told.append(so)))
    assert call(save(corrupt.clean_events(70_000)), *SENSOR)[0] == 0
    assert told == [(1 << 16, None, {}), (70_000, None, {})]


def test_something_wrong(call, save):
    code, out, err = call(save(corrupt.back_steps(EVENTS, 3)), *SENSOR)
    assert (code, err) == (1, "")
    assert out.startswith("flight & co.npy\n")
    assert "\nVerdict: wrong. Problems: back steps.\n  back steps: A run drops and counts" in out


def test_a_truncated_file_is_wrong_and_nothing_else_is_said_about_it(call, save):
    path = save(EVENTS)
    corrupt.cut_file(path, 20_000)
    code, out, err = call(path, *SENSOR)
    assert (code, err) == (1, "")
    assert "first: byte 20,000\n" in out


def test_a_file_cut_before_its_first_event_has_a_table(call, tmp_path):
    path = tmp_path / "a.npz"
    np.savez(path, events=EVENTS)
    corrupt.cut_file(path, 500)
    code, out, err = call(path, *SENSOR)
    assert (code, err) == (3, "")
    assert out.startswith("a.npz\n  format    npz\n") and "first: byte 500\n" in out


@pytest.mark.parametrize(("events", "code"), [(EVENTS, 0), (corrupt.back_steps(EVENTS, 3), 1)])
def test_json_is_the_summary(call, save, events, code):
    path = save(events)
    got, out, err = call(path, *SENSOR, "--json")
    assert (got, err) == (code, "")
    inspection = asap.check(path, width=corrupt.WIDTH, height=corrupt.HEIGHT)
    assert json.loads(out) == json.loads(json.dumps(inspection.summary()))
    assert json.loads(out)["source"]["path"] == str(path)


def test_the_options_of_reading(call, tmp_path):
    path = tmp_path / "events.csv"
    write_csv(path, EVENTS)
    path.write_text(path.read_text().partition("\n")[2])
    assert json.loads(call(path, *SENSOR, "--json")[1])["verdict"] == "ok"
    swapped = json.loads(call(path, *SENSOR, "--order", "tyxp", "--json")[1])
    assert swapped["checks"]["out_of_bounds"]["count"] == np.count_nonzero(EVENTS["x"] >= 260)
    seconds = json.loads(call(path, *SENSOR, "--time-unit", "s", "--json")[1])
    assert seconds["checks"]["gaps"]["count"] == EVENTS.size - 1


def test_report(call, save, tmp_path):
    pytest.importorskip("matplotlib")
    path = tmp_path / "out.html"
    code, out, _ = call(save(corrupt.back_steps(EVENTS, 3)), *SENSOR, "--report", path)
    assert code == 1 and "Verdict: wrong" in out and out.endswith(f"\nwrote {path}\n")
    assert "flight &amp; co.npy" in path.read_text("utf-8")


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        ([], 2, "required: FILE"),
        (["none.npy"], 3, "none.npy: no such file"),
        (["f", "--on-bad", "drop"], 2, "unrecognized arguments: --on-bad drop"),
        (["f", "--report", "no/such/out.html"], 2, "there is no folder no/such"),
    ],
)
def test_wrong_use_says_what_is_right(call, arguments, code, words):
    got, out, err = call(*arguments)
    assert (got, out) == (code, "")
    assert words in err


def test_what_cannot_be_read(call, tmp_path):
    broken = tmp_path / "broken.npy"
    broken.write_bytes(b"no recording")
    code, out, err = call(broken)
    assert (code, out) == (3, "") and "byte 0" in err
    columns = tmp_path / "three.csv"
    columns.write_text("1,2,3\n4,5,6\n")
    code, out, err = call(columns)
    assert (code, out) == (2, "") and "name each, such as order='txy'\n" in err
