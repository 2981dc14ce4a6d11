import argparse
import io
import json
import os
import re
import subprocess
import sys
import warnings
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

import asap as package
from asap import _progress, cli
from asap.cli.algorithms import ALGORITHMS, algorithm_of
from asap.io import CorruptFile, UnsupportedFormat
from fake_run import fake_run

EVENT_DTYPE = np.dtype([("x", "<u2"), ("y", "<u2"), ("p", "<i2"), ("t", "<i8")], align=True)


class FakeRecording(SimpleNamespace):
    def __iter__(self):
        return iter(self.blocks)


class FakeApi:
    """What the command line asks of the package; remembers how it was asked."""

    def __init__(self):
        events = np.zeros(4, EVENT_DTYPE)
        events["t"], events["p"] = [1000, 1500, 9000, 12_000], [1, 0, 1, 1]
        self.recording = FakeRecording(
            path="flight.npy",
            format="npy",
            width=346,
            height=260,
            rejected={"nonmonotonic": 0, "out_of_bounds": 0},
            clock_resets=0,
            blocks=[events[:3], events[3:]],
        )
        self.result = fake_run(duration_s=0.1)
        self.calls = {}

    def read(self, path, **options):
        self.calls["read"] = {"path": path, **options}
        return self.recording

    def run(self, source, **options):
        self.calls["run"] = options
        return self._finish()

    def simulate(self, source, **options):
        self.calls["simulate"] = options
        return self._finish()

    def last_run(self):
        return self.result

    def load_run(self, path):
        if not path.exists():
            raise FileNotFoundError(2, "No such file or directory", str(path))
        return self.result

    def _finish(self):
        if isinstance(self.result, BaseException):
            raise self.result
        return self.result


@pytest.fixture
def api(monkeypatch):
    fake = FakeApi()
    for name in ("read", "run", "simulate", "last_run", "load_run"):
        monkeypatch.setattr(package, name, getattr(fake, name))
    monkeypatch.setattr(package, "LinearCost", lambda alpha_us, beta_ns: (alpha_us, beta_ns))
    monkeypatch.setattr(
        package, "ClusterTracker", lambda width, height: ("clusters", width, height)
    )
    return fake


@pytest.fixture
def asap(capsys):
    """Calls the command line: exit code, stdout, stderr."""

    def call(*arguments):
        code = cli.main([str(argument) for argument in arguments])
        return (code, *capsys.readouterr())

    return call


def fail_with(monkeypatch, name, error):
    def fail(*_, **__):
        raise error

    monkeypatch.setattr(package, name, fail)


def test_version(api, asap):
    assert asap("--version") == (0, f"asap {package.__version__}\n", "")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "required: VERB"),
        (["fly"], "invalid choice"),
        (["run"], "give one of FILE"),
        (["run", "f", "--latency", "10"], "latency = 10: the unit is missing, for example 10ms"),
        (["run", "f", "--latency", "-1ms"], "expected one argument"),
        (["run", "f", "--cost", "100+300"], "cost, per package = 100: the unit is missing"),
        (["run", "f", "--cost", "100us"], "cost = 100us: write time per package + time per event"),
        (["run", "f", "--scheme", "asap2021"], "invalid choice: 'asap2021'"),
        (["run", "f", "--set", "zz=1"], "zz = 1: Deadline has no such parameter"),
        (["run", "f", "--set", "prefer"], "write NAME=VALUE"),
        (["run", "f", "--set", "latency_ms=fast"], "latency_ms = 'fast': give a number"),
        (["run", "f", "--scheme", "asap2022", "--set", "max_size=2.5"], "give a whole number"),
        (["run", "f", "--cost", "1us+1ns", "--speed", "10"], "--speed: not with --cost"),
        (
            ["run", "f", "--scheme", "asap2020", "--set", "rate_bound=-1"],
            "rate_bound = -1: must be a positive",
        ),
        (["run", "f", "--report", "no/such/folder/out.html"], "there is no folder no/such/folder"),
        (["info", "f", "--on-bad", "ignore"], "invalid choice: 'ignore'"),
    ],
)
def test_wrong_use_exits_with_2_and_says_what_is_right(api, asap, arguments, words):
    code, out, err = asap(*arguments)
    assert (code, out) == (2, "")
    assert words in err
    assert "run" not in api.calls and "simulate" not in api.calls


def parsers():
    parser = cli._parser()
    verbs = next(one for one in parser._actions if isinstance(one, argparse._SubParsersAction))
    return [parser, *verbs.choices.values()]


def test_every_argument_has_a_help_text_with_its_default():
    for parser in parsers():
        for one in parser._actions:
            if isinstance(one, argparse._SubParsersAction):
                continue
            words = f"{parser.prog} {one.dest}: {one.help}"
            assert one.help, words
            if one.default not in (None, False, [], argparse.SUPPRESS):
                shown = f"{one.default:g}" if isinstance(one.default, float) else f"{one.default}"
                assert re.search(rf"default: {shown}\b|default: dropped", one.help), words


@pytest.mark.parametrize(
    ("text", "options", "words"),
    [
        ("1,2,3\n", [], "order = None: the lines of {} have 3 columns; name each, such as "),
        ("a,b,c\n1,2,3\n", [], "order = None: the header of"),
        ("1,2,3\n", ["--order", "txq"], "order = 'txq': name the columns"),
        ("1.0,2.0,3.0,1.0\n", [], "say time_unit='s' or time_unit='us'\n"),
    ],
)
def test_columns_that_are_not_known_are_wrong_use(asap, tmp_path, text, options, words):
    path = tmp_path / "events.csv"
    path.write_text(text)
    code, out, err = asap("info", path, *options)
    assert (code, out) == (2, "")
    assert words.format(path) in err


def test_a_camera_is_chosen_by_its_stream(asap, tmp_path):
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        for camera, count in (("left", 2), ("right", 3)):
            file[f"{camera}/events"] = np.ones(count, EVENT_DTYPE)
    code, _, err = asap("info", path)
    assert code == 2 and "such as stream='left/events'" in err
    assert "events    3, " in asap("info", path, "--stream", "right")[1]


@pytest.mark.parametrize(("unit", "duration"), [("s", "1 s"), ("ms", "1 ms"), ("ns", "1 us")])
def test_units_of_time_are_those_of_the_library(asap, tmp_path, unit, duration):
    path = tmp_path / "events.csv"
    path.write_text("0,1,1,1\n1000,1,1,1\n" if unit == "ns" else "0,1,1,1\n1,1,1,1\n")
    assert f"duration  {duration}\n" in asap("info", path, "--time-unit", unit)[1]


def test_run_prints_the_table(api, asap):
    code, out, err = asap("run", "flight.npy")
    assert (code, err) == (0, "")
    assert "Bottleneck: " in out and "in time" in out
    assert api.calls["run"] == {
        "scheme": None,
        "latency_ms": None,
        "algorithm": ("clusters", 346, 260),
        "on_bad": "drop",
        "seed": 0,
        "speed": 1.0,
        "on_progress": None,
    }


def test_run_hands_its_options_on(api, asap):
    arguments = "--latency 20ms --speed 2 --seed 7 --on-bad clamp --width 100 --height 50"
    more = "--order yxt --time-unit s --stream left --file-format csv"
    more += " --scheme asap2020 --set rate_bound=1e6 --set first_size=500"
    code, _, _ = asap("run", "hands", *arguments.split(), *more.split())
    assert code == 0
    assert api.calls["read"] == {
        "path": "hands",
        "width": 100,
        "height": 50,
        "order": "yxt",
        "time_unit": "s",
        "on_bad": "clamp",
        "stream": "left",
        "file_format": "csv",
    }
    options = api.calls["run"]
    assert (options["latency_ms"], options["speed"], options["seed"]) == (20.0, 2.0, 7)
    parameters = options["scheme"].parameters
    assert (parameters["rate_bound"], parameters["first_size"]) == (1e6, 500)


@pytest.mark.parametrize("name", ALGORITHMS)
def test_algorithms_by_name_are_made_for_the_sensor(name):
    recording = SimpleNamespace(width=346, height=260)
    algorithm = algorithm_of(name, recording)
    assert type(algorithm).__name__ == ALGORITHMS[name]
    assert (algorithm.width, algorithm.height) == (346, 260)


def test_a_cost_means_virtual_time(api, asap):
    assert asap("run", "flight.npy", "--cost", "100us+300ns")[0] == 0
    assert api.calls["simulate"]["cost"] == (100.0, 300.0)
    assert api.calls["simulate"]["algorithm"] is None
    assert "run" not in api.calls


def test_json_is_one_object_and_nothing_else(api, asap):
    for verb in (["run", "f", "--json"], ["run", "f", "--cost", "1us+1ns", "--json"]):
        code, out, err = asap(*verb)
        assert (code, err) == (0, "")
        assert json.loads(out) == api.result.summary()


def test_a_recording_without_geometry_needs_width_and_height(api, asap):
    api.recording.width = api.recording.height = None
    code, out, err = asap("run", "f.txt")
    assert (code, out) == (2, "")
    assert "--width and --height" in err
    assert asap("run", "f.txt", "--cost", "1us+1ns")[0] == 0


@pytest.mark.parametrize(
    "error",
    [
        FileNotFoundError(2, "No such file or directory", "flight.raw"),
        PermissionError(13, "Permission denied", "flight.raw"),
        UnsupportedFormat("flight.raw is RAW"),
        CorruptFile("flight.raw", 17, "broken"),
        RuntimeError("flight.raw needs asap-events[files]"),
    ],
)
@pytest.mark.parametrize("verb", ["run", "info"])
def test_input_that_cannot_be_read_exits_with_3(api, asap, monkeypatch, verb, error):
    fail_with(monkeypatch, "read", error)
    code, out, err = asap(verb, "flight.raw", "--json")
    assert (code, out) == (3, "")
    assert err.startswith("asap: error: flight.raw") and err.count("\n") == 1


def test_input_that_breaks_while_it_is_read_exits_with_3(api, asap):
    api.result = CorruptFile("flight.raw", 17, "broken")
    assert asap("run", "f")[0] == 3
    api.result = ValueError("x = 400: outside the sensor, event 3")
    assert asap("run", "f", "--on-bad", "raise")[0] == 3


def test_a_bound_that_the_scheme_contradicts_is_wrong_use(api, asap):
    api.result = ValueError("latency_ms = 20: the scheme has 10")
    code, _, err = asap("run", "f", "--latency", "20ms")
    assert code == 2
    assert "the scheme has 10" in err


def test_an_interrupted_run_prints_its_ledger_and_exits_with_130(api, asap, monkeypatch):
    fail_with(monkeypatch, "run", KeyboardInterrupt())
    code, out, err = asap("run", "f", "--json")
    assert (code, out) == (130, "")
    assert f"{api.result.ledger.delivered:,}" in err and "received" in err


def test_warnings_become_a_line_on_stderr(api, asap, monkeypatch):
    def read(*_, **__):
        warnings.warn("truncated at byte 99", stacklevel=2)
        return api.recording

    monkeypatch.setattr(package, "read", read)
    code, out, err = asap("info", "f", "--json")
    assert (code, err) == (0, "asap: warning: truncated at byte 99\n")
    json.loads(out)


def test_an_output_that_cannot_be_written_is_told(api, asap, tmp_path):
    code, out, err = asap("run", "f", "--save", tmp_path)
    assert (code, out) == (2, "")
    assert err.endswith(f"error: argument --save: {tmp_path}: a folder; give a file in it\n")


def test_save_and_report_write_their_files(api, asap, tmp_path):
    saved, page = tmp_path / "run.json", tmp_path / "run.html"
    code, out, err = asap("run", "f", "--save", saved, "--report", page)
    assert (code, err) == (0, "")
    assert out.endswith(f"\nwrote {saved}\nwrote {page}\n")
    assert json.loads(saved.read_text()) == api.result.summary()
    assert page.read_text().startswith("<!doctype html>")
    out = asap("run", "f", "--json", "--save", saved, "--report", page)[1]
    assert json.loads(out) == api.result.summary()


def test_info_describes_the_recording(api, asap):
    api.recording.rejected["out_of_bounds"] = 1200
    code, out, err = asap("info", "/data/flight.npy")
    assert (code, err) == (0, "")
    assert out.splitlines() == [
        "flight.npy",
        "  format    npy",
        "  sensor    346 x 260 px",
        "  events    4, 75.0 % ON",
        "  duration  11 ms",
        "  rate      mean 364 ev/s, peak 300 ev/s in 10 ms, 2 kev/s in 1 ms",
        "  rejected  1,200 out_of_bounds",
    ]


def test_info_as_json(api, asap):
    code, out, err = asap("info", "f.npy", "--json")
    assert (code, err) == (0, "")
    facts = json.loads(out)
    assert facts["rate_hz"] == {
        "mean": pytest.approx(4 / 0.011),
        "peak_1ms": 2000,
        "peak_10ms": 300,
    }
    assert facts["rejected"] == {"nonmonotonic": 0, "out_of_bounds": 0}
    assert (facts["schema_version"], facts["events"], facts["duration_s"]) == (1, 4, 0.011)


def test_info_says_when_the_geometry_is_unknown(api, asap):
    api.recording.width = api.recording.height = None
    out = asap("info", "f")[1]
    assert "unknown: addresses are not checked; events reach x = " in out
    assert out.endswith("  rejected  none\n")
    api.recording.width = 346
    assert "  sensor    346 x ? px: addresses are not checked" in asap("info", "f")[1]


def test_report_stands_beside_the_run(api, asap, tmp_path):
    pytest.importorskip("matplotlib")
    (tmp_path / "run.json").write_text("{}")
    assert asap("report", tmp_path / "run.json") == (0, f"wrote {tmp_path / 'run.html'}\n", "")
    assert (tmp_path / "run.html").read_text().startswith("<!doctype html>")
    code, out, _ = asap("report", tmp_path / "run.json", "-o", tmp_path / "b.html", "--json")
    assert code == 0 and json.loads(out)["file"] == str(tmp_path / "b.html")
    assert (tmp_path / "b.html").exists()


def test_report_of_a_missing_run_exits_with_3(api, asap, tmp_path):
    pytest.importorskip("matplotlib")
    code, out, err = asap("report", tmp_path / "none.json")
    assert (code, out) == (3, "")
    assert "none.json: no such file" in err


@pytest.fixture
def demo(api, monkeypatch, tmp_path):
    def run(out_dir, *, quick, on_progress):
        assert (out_dir, quick, on_progress) == (tmp_path, True, None)
        return [api.result] * 3, [tmp_path / "report.html"]

    @dataclass
    class Claim:
        sentence: str
        holds: bool
        seen: str

    fake = SimpleNamespace(run=run, held=[Claim("gamma = 1 throughout.", True, "least gamma 1")])
    fake.claims = lambda run: fake.held
    fake.side_by_side = lambda paper, default: "both"
    fake.Claim = Claim
    monkeypatch.setitem(sys.modules, "asap.demo", fake)
    monkeypatch.setattr(package, "demo", fake, raising=False)
    return fake


def test_demo_prints_a_table_for_each_run_the_claims_and_the_files(api, asap, demo, tmp_path):
    code, out, err = asap("demo", "--quick", "--out", tmp_path)
    assert (code, err) == (0, "")
    assert out.count("Bottleneck: ") == 2
    assert out.count("  holds  gamma = 1 throughout.\n         least gamma 1\n") == 2
    assert out.endswith(f"scheme:\n\nboth\n\nwrote {tmp_path / 'report.html'}\n")


@pytest.mark.parametrize("verb", [["demo"], ["run", "f", "--report", "f.html"], ["report", "f"]])
def test_a_missing_matplotlib_is_told_before_the_work(verb):
    code = "import sys; sys.modules['matplotlib'] = None; from asap import cli; "
    command = [sys.executable, "-c", f"{code} sys.exit(cli.main({verb}))"]
    result = subprocess.run(command, capture_output=True, text=True)
    assert (result.returncode, result.stdout) == (2, "")
    assert result.stderr == "asap: error: a figure needs matplotlib: install asap-events[report]\n"


def test_demo_as_json(api, asap, demo, tmp_path):
    code, out, err = asap("demo", "--quick", "--out", tmp_path, "--json")
    assert (code, err) == (0, "")
    facts = json.loads(out)
    assert facts["runs"] == [api.result.summary()] * 3
    assert len(facts["claims"]) == 2
    assert facts["claims"][0][0]["holds"] is True
    assert facts["files"] == [str(tmp_path / "report.html")]


def test_a_claim_that_fails_is_a_failed_check(api, asap, demo, tmp_path):
    demo.held.append(demo.Claim("Pigs fly.", False, "none seen"))
    code, out, _ = asap("demo", "--quick", "--out", tmp_path)
    assert code == 1
    assert "  FAILS  Pigs fly.\n" in out
    assert asap("demo", "--quick", "--out", tmp_path, "--json")[0] == 1


def test_progress_is_for_terminals_only(monkeypatch):
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    with _progress.on_terminal() as on_progress:
        assert on_progress is None
    monkeypatch.setattr(sys, "stderr", None)  # closed
    with _progress.on_terminal() as on_progress:
        assert on_progress is None


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_progress_without_tqdm_is_a_line_every_ten_seconds(monkeypatch):
    terminal, clock = Terminal(), SimpleNamespace(now_s=0.0)
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setitem(sys.modules, "tqdm", None)
    monkeypatch.setattr(_progress.time, "monotonic", lambda: clock.now_s)
    with _progress.on_terminal() as on_progress:
        for clock.now_s in (1.0, 9.9, 10.0, 12.0, 20.0):
            on_progress(int(clock.now_s * 1000), 50_000, None)
    assert terminal.getvalue().splitlines() == [
        "asap: 10,000 of 50,000 events",
        "asap: 20,000 of 50,000 events",
    ]


def test_progress_with_tqdm_is_a_bar_that_goes_away(monkeypatch):
    tqdm = pytest.importorskip("tqdm").tqdm
    bars = []

    class Bar(tqdm):
        def __init__(self, **options):
            super().__init__(**dict(options, delay=0, mininterval=0))
            bars.append(self)

    monkeypatch.setattr("tqdm.tqdm", Bar)
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with pytest.raises(KeyboardInterrupt), _progress.on_terminal() as on_progress:
        on_progress(1000, 2000, None)
        on_progress(1500, 2000, None)
        raise KeyboardInterrupt
    assert bars[0].n == 1500
    assert "1.00k/2.00k" in terminal.getvalue()
    assert re.search(r"\r +\r$", terminal.getvalue())
    assert not re.search(r"\x1b\[\d*m", terminal.getvalue())


class TestInstalled:
    """The command on the real package, as a stranger calls it."""

    @pytest.fixture
    def recording(self, tmp_path):
        pytest.importorskip("asap._core")
        rng = np.random.default_rng(0)
        events = np.zeros(100_000, EVENT_DTYPE)
        events["t"] = np.sort(rng.integers(0, 100_000, events.size)) + 10**9
        events["x"], events["y"] = rng.integers(0, 64, (2, events.size))
        events["p"] = rng.integers(0, 2, events.size)
        np.save(tmp_path / "flight.npy", events)
        return tmp_path / "flight.npy"

    @staticmethod
    def call(*arguments):
        return subprocess.run(
            [sys.executable, "-m", "asap", *map(str, arguments)],
            capture_output=True,
            text=True,
            env={**os.environ, "PYTHONWARNINGS": ""},
        )

    def test_run_in_virtual_time(self, recording):
        arguments = ("run", recording, "--cost", "100us+300ns", "--scheme", "asap2020", "--json")
        first, second = self.call(*arguments), self.call(*arguments)
        assert (first.returncode, first.stderr) == (0, "")
        assert first.stdout == second.stdout
        summary = json.loads(first.stdout)
        ledger = summary["ledger"]
        assert summary["mode"] == "virtual" and ledger["received"] == 100_000
        assert 2 * ledger["received"] == sum(ledger.values())

    def test_run_in_real_time_saved_and_reported(self, recording, tmp_path):
        saved = tmp_path / "run.npz"
        size = ("--width", 64, "--height", 64)
        ran = self.call("run", recording, *size, "--save", saved)
        assert (ran.returncode, ran.stderr) == (0, "")
        assert "real time" in ran.stdout and "Bottleneck: " in ran.stdout
        pytest.importorskip("matplotlib")
        reported = self.call("report", saved)
        assert (reported.returncode, reported.stderr) == (0, "")
        assert "flight.npy" in saved.with_suffix(".html").read_text("utf-8")

    def test_info(self, recording):
        info = self.call("info", recording, "--json")
        assert (info.returncode, info.stderr) == (0, "")
        facts = json.loads(info.stdout)
        assert facts["events"] == 100_000
        assert facts["rate_hz"]["mean"] == pytest.approx(1e6, rel=0.01)

    @pytest.mark.parametrize("verb", [["info"], ["run", "--cost", "1us+1ns"]])
    def test_what_is_no_recording_exits_with_3(self, recording, tmp_path, verb):
        junk = tmp_path / "junk.raw"
        junk.write_bytes(bytes(range(256)))
        for path in (junk, tmp_path / "absent.npy"):
            result = self.call(verb[0], path, *verb[1:])
            assert (result.returncode, result.stdout) == (3, "")
            assert result.stderr.startswith("asap: error: ") and "Traceback" not in result.stderr

    def test_a_name_that_stdout_cannot_write_is_escaped(self, recording, monkeypatch):
        monkeypatch.setenv("PYTHONIOENCODING", "ascii")
        info = self.call("info", recording.rename(recording.with_name("fl\u00fcg.npy")))
        assert (info.returncode, info.stderr) == (0, "")
        assert "fl\\xfcg.npy" in info.stdout

    def test_a_closed_pipe_is_no_error(self, recording):
        command = f"{sys.executable} -m asap info {recording} | true"
        result = subprocess.run(command, shell=True, capture_output=True, text=True)
        assert result.stderr == ""

    @pytest.mark.parametrize("verb", ["info {}", "run {} --cost 1us+1ns --json"])
    def test_a_closed_stream_is_no_error(self, recording, verb):
        command = f"{sys.executable} -m asap {verb.format(recording)}"
        said = subprocess.run(command, shell=True, capture_output=True, text=True)
        result = subprocess.run(f"{command} >&-", shell=True, capture_output=True, text=True)
        assert (result.returncode, result.stderr) == (0, "")
        result = subprocess.run(f"{command} 2>&-", shell=True, capture_output=True, text=True)
        assert (result.returncode, result.stdout) == (0, said.stdout)

    def test_a_message_for_a_closed_stderr_does_not_take_stdout(self, recording):
        recording.write_bytes(recording.read_bytes()[:-1])
        command = f"{sys.executable} -m asap info {recording} --json 2>&-"
        result = subprocess.run(command, shell=True, capture_output=True, text=True)
        assert json.loads(result.stdout)["events"] == 99_999

    @pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full")
    def test_a_full_disk_is_named(self, recording):
        virtual = ("run", recording, "--cost", "1us+1ns")
        for name in ("full.npz", "full.json"):
            full = recording.parent / name
            full.symlink_to("/dev/full")
            result = self.call(*virtual, "--save", full)
            assert (result.returncode, result.stdout) == (2, "")
            assert result.stderr == f"asap: error: {full}: No space left on device\n"
        command = f"{sys.executable} -m asap info {recording} >/dev/full"
        result = subprocess.run(command, shell=True, capture_output=True, text=True)
        assert result.returncode == 2
        assert result.stderr == "asap: error: stdout: No space left on device\n"
