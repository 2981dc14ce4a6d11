"""The command line as a user calls it: verbs, options, exit codes, what is written where."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import asap
import corrupt
import streams
from asap import _progress, analysis
from asap.cli import demo
from asap.cli.algorithms import ALGORITHMS, algorithm_of, chosen
from event_files import write_csv

Call = Callable[..., tuple[int, str, str]]
SENSOR = ("--width", corrupt.WIDTH, "--height", corrupt.HEIGHT)
COST = ("--cost", "100us+300ns")
EVENTS = corrupt.clean_events(2000)
LINEAR = asap.LinearCost(100, 300)


@pytest.fixture
def flight(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A recording in the current folder."""
    monkeypatch.chdir(tmp_path)
    np.save("flight.npy", streams.poisson(4e5, 0.05, seed=1))
    return Path("flight.npy")


def plain(summary: Any) -> Any:
    return json.loads(json.dumps(summary))


# ---- wrong use ------------------------------------------------------------------------------


def test_version(call: Call) -> None:
    assert call("--version") == (0, f"asap {asap.__version__}\n", "")


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ("", "VERB"),
        ("run", "FILE"),
        ("run f --latency 10", "latency = 10: "),
        ("run f --cost 100us", "cost = 100us: "),
        ("run f --scheme asap2021", "'asap2021'"),
        ("run f --set zz=1", "zz = 1: "),
        ("run f --set latency_ms=fast", "latency_ms = 'fast': "),
        ("run f --report no/such/out.html", "no/such"),
        ("run f --save run.txt", ".npz"),
        ("run flight.npy", "--width and --height"),
        ("run flight.npy --cost 1us+1ns --latency 20ms --set latency_ms=10", "latency"),
        ("compare f", "--cost"),
        ("compare flight.npy --cost 1us+1ns --speed 0", "speed = 0.0: "),
        ("info three.csv", "order = None: "),
        ("convert flight.npy a.xyz", "npy, npz"),
        ("convert flight.npy a.es", "width and height"),
        ("convert flight.npy flight.npy", "is the recording itself"),
        ("convert flight.npy a.raw --format evt4", "'evt4'"),
        ("check f --on-bad drop", "--on-bad"),
    ],
)
def test_wrong_use_exits_with_2_and_names_what_is_wrong(
    call: Call, flight: Path, arguments: str, named: str
) -> None:
    Path("three.csv").write_text("1,2,3\n")
    code, out, err = call(*arguments.split())
    assert (code, out) == (2, "")
    assert named in err


@pytest.mark.parametrize(
    ("arguments", "meant"),
    [
        ("rum flight.npy", "run"),
        ("run flight.npy --latancy 5ms", "--latency"),
        ("run flight.npy --scheme deadlin", "deadline"),
        ("run flight.npy --algorithm cluster", "clusters"),
        ("run flight.npy --algorithm my_algorithms:Detecter", "Detector"),
        ("run flight.npy --algorithm my_algorithm:Detector", "my_algorithms"),
    ],
)
def test_a_word_that_is_nearly_right_is_asked_for(
    call: Call, flight: Path, arguments: str, meant: str
) -> None:
    Path("my_algorithms.py").write_text("class Detector: ...")
    code, out, err = call(*arguments.split())
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert f"did you mean {meant}?" in err


@pytest.mark.parametrize("verb", ["info", "run --cost 1us+1ns", "compare --cost 1us+1ns", "check"])
def test_input_that_cannot_be_read_exits_with_3(call: Call, flight: Path, verb: str) -> None:
    Path("junk.raw").write_bytes(bytes(range(256)))
    Path("cut.npy").write_bytes(flight.read_bytes()[:100])
    for name in ("junk.raw", "cut.npy", "no/such.npy", "fligth.npy"):
        code, out, err = call(*verb.split(), name)
        assert (code, out) == (3, "")
        assert err.startswith(f"asap: error: {name}") and err.count("\n") == 1
    assert "did you mean flight.npy?" in err


def test_bad_events_that_raise_are_input_that_cannot_be_read(call: Call, flight: Path) -> None:
    np.save("bad.npy", corrupt.back_steps(EVENTS, 3))
    code, _, err = call("run", "bad.npy", *COST, "--on-bad", "raise")
    assert code == 3 and "t = " in err


# ---- verbs ----------------------------------------------------------------------------------


def test_run_in_virtual_time_is_simulate(call: Call, flight: Path) -> None:
    run = asap.simulate(flight, cost=LINEAR)
    assert call("run", flight, *COST) == (0, f"{run}\n", "")
    options = (
        "--latency 5ms --seed 7 --width 300 --on-bad clamp --execution whole --scheme asap2020"
    )
    settings = "--set rate_bound=1e6 --set first_size=500 --json"
    code, out, err = call("run", flight, *COST, *options.split(), *settings.split())
    expected = asap.simulate(
        asap.read(flight, width=300, on_bad="clamp"),
        cost=LINEAR,
        scheme=asap.Asap2020(rate_bound=1e6, first_size=500),
        latency_ms=5,
        seed=7,
        execution="whole",
        on_bad="clamp",
    )
    assert (code, err, json.loads(out)) == (0, "", plain(expected.summary()))


def test_run_in_real_time_saves_and_reports(call: Call, flight: Path) -> None:
    options = ("--speed", 2, "--save", "run.npz", "--report", "run.html")
    code, out, err = call("run", flight, *SENSOR, *options)
    assert (code, err) == (0, "")
    assert "real time at 2 times" in out and out.endswith("\nwrote run.npz\nwrote run.html\n")
    assert Path("run.html").read_text("utf-8").startswith("<!doctype html>")
    loaded = asap.load_run("run.npz")
    assert loaded.speed == 2 and loaded.lateness is not None
    assert call("report", "run.npz") == (0, "wrote run.html\n", "")
    code, out, _ = call("report", "run.npz", "-o", "b.html", "--json")
    assert (code, json.loads(out)["file"]) == (0, "b.html")
    assert call("report", "none.npz")[0] == 3


@pytest.mark.parametrize("name", ALGORITHMS)
def test_algorithms_by_name_are_made_for_the_sensor(name: str) -> None:
    text = f"{name}:count=9" if name == "event_image" else name  # the only one that needs more
    algorithm = algorithm_of(chosen(text), SimpleNamespace(width=346, height=260))  # type: ignore[arg-type]
    assert type(algorithm).__name__ == ALGORITHMS[name]
    assert (algorithm.width, algorithm.height) == (346, 260)


def test_threads_are_those_of_tiled(call: Call, flight: Path) -> None:
    run = ("run", flight, "--width", "346", "--height", "260", "--threads", "2")
    code, out, _ = call(*run, "--algorithm", "e_fast", "--json")
    assert (code, json.loads(out)["algorithm"]["threads"]) == (0, 2)
    code, _, said = call(*run)  # of the cluster tracker
    assert code == 2 and "EFast" in said


def test_compare_is_compare(call: Call, flight: Path) -> None:
    options = [
        "--latency",
        "5ms",
        "--seed",
        "3",
        "--speed",
        "20",
        "--execution",
        "whole",
        "--width",
        "300",
    ]
    read = asap.read(flight, width=300)
    options_of = {"latency_ms": 5, "seed": 3, "speed": 20, "execution": "whole"}
    expected = asap.compare(read, cost=LINEAR, **options_of)  # type: ignore[arg-type]
    assert call("compare", flight, *COST, *options) == (0, f"{expected}\n", "")
    code, out, _ = call("compare", flight, *COST, *options, "--json", "--report", "out.html")
    assert (code, json.loads(out)) == (0, plain(expected.summary()))
    assert "<table" in Path("out.html").read_text("utf-8")


@pytest.mark.parametrize(("bad", "code"), [(0, 0), (3, 1)])
def test_check_is_check(call: Call, flight: Path, bad: int, code: int) -> None:
    path = Path("flight & co.npy")
    np.save(path, corrupt.back_steps(EVENTS, bad) if bad else EVENTS)
    found = asap.check(path, width=corrupt.WIDTH, height=corrupt.HEIGHT)
    assert call("check", path, *SENSOR) == (code, f"{found}\n", "")
    got, out, _ = call("check", path, *SENSOR, "--json")
    assert (got, json.loads(out)) == (code, plain(found.summary()))


def test_the_options_of_reading(call: Call, flight: Path) -> None:
    write_csv(Path("a.csv"), EVENTS)
    Path("a.csv").write_text(Path("a.csv").read_text().partition("\n")[2])
    swapped = json.loads(call("check", "a.csv", *SENSOR, "--order", "tyxp", "--json")[1])
    assert swapped["checks"]["out_of_bounds"]["count"] == np.count_nonzero(EVENTS["x"] >= 260)
    Path("b.csv").write_text("0,1,1,1\n1,1,1,1\n")
    assert "duration  1 ms\n" in call("info", "b.csv", "--time-unit", "ms")[1]
    assert "format    csv\n" in call("info", "b.csv", "--file-format", "csv")[1]
    h5py = pytest.importorskip("h5py")
    with h5py.File("a.h5", "w") as file:
        for camera, count in (("left", 2), ("right", 3)):
            file[f"{camera}/events"] = np.ones(count, asap.EVENT_DTYPE)
    assert "events    3, " in call("info", "a.h5", "--stream", "right")[1]


def test_info_is_info(call: Call, flight: Path) -> None:
    code, out, err = call("info", flight, *SENSOR, "--json")
    facts = asap.info(flight, width=corrupt.WIDTH, height=corrupt.HEIGHT)
    assert (code, err, json.loads(out)) == (0, "", plain(facts))
    assert f"{facts['events']:,}, " in call("info", flight, *SENSOR)[1]
    assert "addresses are not checked" in call("info", flight, *SENSOR[:2])[1]


def test_the_facts(call: Call, flight: Path) -> None:
    np.savez("a.npz", events=corrupt.outside_sensor(EVENTS, 60), width=346, height=260)
    found, recording = analysis.describe(asap.read("a.npz")), asap.read("a.npz")
    facts = asap.info("a.npz")
    assert facts == {
        **{"schema_version": 1, "path": "a.npz", "format": "npz", "width": 346, "height": 260},
        **{"events": 1940, "duration_s": found.duration_s, "on_share": found.on_share},
        **{"x_max": int(EVENTS["x"].max()), "y_max": int(EVENTS["y"].max())},
        "rate_hz": {
            "mean": found.rate_mean_hz,
            "peak_1ms": found.rate_peak_1ms_hz,
            "peak_10ms": found.rate_peak_10ms_hz,
        },
        "rejected": recording.rejected | {"out_of_bounds": 60},
        **{"clock_resets": 0, "lost_packets": 0},
    }
    assert asap.info(recording) == facts
    np.save("b.npy", corrupt.clock_reset(EVENTS, 1000))
    assert asap.info("b.npy")["clock_resets"] == 1


def test_demo(call: Call, flight: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run = demo.flight(duration_s=0.3, virtual=True)
    monkeypatch.setattr(demo, "run", lambda out, **_: ([run] * 3, [out / "report.html"]))
    claim = demo.Claim("gamma = 1 throughout.", True, "least gamma 1")
    monkeypatch.setattr(demo, "claims", lambda _: [claim])
    code, out, err = call("demo", "--quick", "--out", "there")
    assert (code, err) == (0, "")
    assert out.count("  holds  gamma = 1 throughout.\n         least gamma 1\n") == 2
    assert out.endswith(f"\n\nwrote {Path('there/report.html')}\n")
    facts = json.loads(call("demo", "--json")[1])
    assert len(facts["runs"]) == 3 and facts["claims"][0][0]["holds"]
    monkeypatch.setattr(demo, "claims", lambda _: [demo.Claim("Pigs fly.", False, "none")])
    code, out, _ = call("demo", "--quick")
    assert code == 1 and "  FAILS  Pigs fly.\n" in out


# ---- what is told, and where ----------------------------------------------------------------


def test_warnings_become_a_line_on_stderr(call: Call, flight: Path) -> None:
    corrupt.cut_file(flight, 20_001)
    code, out, err = call("info", flight, "--json")
    assert code == 0 and 0 < json.loads(out)["events"] < 1250
    assert err.startswith("asap: warning: flight.npy: byte ") and err.count("\n") == 1


@pytest.mark.parametrize("verb", [["demo"], ["run", "f", "--report", "f.html"], ["report", "f"]])
def test_a_missing_matplotlib_is_told_before_the_work(verb: list[str]) -> None:
    code = "import sys; sys.modules['matplotlib'] = None; from asap import cli; "
    command = [sys.executable, "-c", f"{code} sys.exit(cli.main({verb}))"]
    result = subprocess.run(command, capture_output=True, text=True)
    assert (result.returncode, result.stdout) == (2, "")
    assert result.stderr == "asap: error: a figure needs matplotlib: install asap-events[report]\n"


@pytest.mark.parametrize(
    "arguments",
    [
        "run flight.npz --cost 1us+1ns --report flight.npz",
        "run flight.npz --cost 1us+1ns --save flight.npz",
        "compare flight.npz --cost 1us+1ns --report flight.npz",
        "report flight.npz -o flight.npz",
    ],
)
def test_the_recording_is_never_written_over(call: Call, flight: Path, arguments: str) -> None:
    recording = Path("flight.npz")
    np.savez(recording, events=EVENTS)
    before = recording.read_bytes()
    code, _, err = call(*arguments.split())
    assert code == 2 and recording.read_bytes() == before
    words = "is the recording itself; give another", "give a name that ends in .html"
    assert any(word in err for word in words)
    run = asap.simulate(recording, cost=LINEAR)
    with pytest.raises(ValueError, match="is the recording itself"):
        run.save(recording)


def test_progress_is_for_terminals_only(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    with _progress.on_terminal() as on_progress:
        assert on_progress is None
    monkeypatch.setattr(sys, "stderr", None)  # closed
    with _progress.on_terminal() as on_progress:
        assert on_progress is None


# ---- as a process of its own ----------------------------------------------------------------


def process(command: str, **options: Any) -> subprocess.CompletedProcess[str]:
    full = f"{sys.executable} -m asap {command}"
    return subprocess.run(full, shell=True, capture_output=True, text=True, **options)


def test_a_name_that_stdout_cannot_write_is_escaped(flight: Path) -> None:
    flight.rename("fl\u00fcg.npy")
    ran = process("info fl\u00fcg.npy", env={**os.environ, "PYTHONIOENCODING": "ascii"})
    assert (ran.returncode, ran.stderr) == (0, "")
    assert "fl\\xfcg.npy" in ran.stdout


@pytest.mark.parametrize("verb", ["info {}", "run {} --cost 1us+1ns --json", "run --help"])
def test_a_closed_stream_or_pipe_is_no_error(flight: Path, verb: str) -> None:
    command = verb.format(flight)
    said = process(command)
    ran = process(f"{command} >&-")
    assert (ran.returncode, ran.stderr) == (0, "")
    ran = process(f"{command} 2>&-")
    assert (ran.returncode, ran.stdout) == (0, said.stdout)
    assert process(f"{command} | true").stderr == ""
    corrupt.cut_file(flight, 20_001)  # a warning that has nowhere to go
    assert process(f"info {flight} --json 2>&-").stdout.startswith("{")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full")
def test_a_full_disk_is_named(flight: Path) -> None:
    for name in ("full.npz", "full.json"):
        Path(name).symlink_to("/dev/full")
        ran = process(f"run {flight} --cost 1us+1ns --save {name}")
        assert ran.returncode == 2 and "kept" in ran.stdout and "wrote" not in ran.stdout
        said = ran.stderr
        if np.__version__.startswith("1."):  # leaves its archive open, which Python tells first
            said = said[said.index("asap: ") :]
        assert said == f"asap: error: {name}: No space left on device\n"
    ran = process(f"info {flight} >/dev/full")
    assert (ran.returncode, ran.stderr) == (2, "asap: error: stdout: No space left on device\n")
