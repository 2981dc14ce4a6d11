"""asap compare, and --opaque of asap run, as a user calls them."""

import json

import numpy as np
import pytest

import asap
import streams
from asap import cli

COST = ("--cost", "100us+300ns")


@pytest.fixture
def call(capsys):
    """Calls the command line: exit code, stdout, stderr."""

    def call(*arguments):
        code = cli.main([str(argument) for argument in arguments])
        return (code, *capsys.readouterr())

    return call


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    path = tmp_path_factory.mktemp("recordings") / "flight.npy"
    np.save(path, streams.poisson(4e5, 0.05, seed=1))
    return path


def result(call, *arguments):
    code, out, err = call("compare", *arguments, "--json")
    assert (code, err) == (0, "")
    return json.loads(out)


def test_a_table(call, recording):
    code, out, err = call("compare", recording, *COST)
    assert (code, err) == (0, "")
    assert out.startswith("flight.npy: 8 schemes beside the oracle\n") and "Deadline " in out


def test_json_is_the_summary_of_compare(call, recording):
    got = result(call, recording, *COST, "--latency", "5ms", "--seed", 3)
    expected = asap.compare(recording, cost=asap.LinearCost(100, 300), latency_ms=5, seed=3)
    assert got == json.loads(json.dumps(expected.summary()))


def test_a_recording_with_the_options_of_reading(call, recording):
    got = result(call, recording, *COST, "--width", 100, "--height", 260, "--latency", "20ms")
    with pytest.warns(asap.io.LossWarning, match="out_of_bounds"):
        events = asap.load(recording, width=100, height=260)
    expected = asap.compare(
        recording, cost=asap.LinearCost(100, 300), latency_ms=20, width=100, height=260
    )
    assert got == json.loads(json.dumps(expected.summary()))
    assert 0 < events.size < asap.load(recording).size
    assert expected.received == events.size
    assert got["name"] == "flight.npy"


def test_speed_and_opaque(call, recording):
    got = result(call, recording, *COST, "--speed", 20, "--opaque")
    assert got["speed"] == 20 and got["opaque"]
    assert got["source"]["duration_s"] == pytest.approx(0.05 / 20, rel=0.01)
    best = asap.oracle(
        recording, cost=asap.LinearCost(100, 300), latency_ms=10, opaque=True, speed=20
    )
    assert got["oracle"]["events"] == best


def test_report(call, recording, tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    path = tmp_path / "out.html"
    code, out, _ = call("compare", recording, *COST, "--report", path)
    assert code == 0 and out.startswith("flight.npy: 8") and out.endswith(f"\nwrote {path}\n")
    assert "<table" in path.read_text("utf-8")
    monkeypatch.setattr(asap.Comparison, "report", lambda self, path: path)
    result(call, recording, *COST, "--report", path)  # the object and nothing else


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        ([], 2, "required: --cost"),
        (["--cost", "100us"], 2, "write time per package + time per event"),
        ([*COST, "--latency", "10"], 2, "latency = 10: the unit is missing"),
        ([*COST, "--speed", "0"], 2, "speed = 0.0: must be between"),
        ([*COST, "--seed", "-1"], 2, "seed"),
        ([*COST, "--report", "no/such/out.html"], 2, "there is no folder no/such"),
    ],
)
def test_wrong_use_says_what_is_right(call, recording, arguments, code, words):
    got, out, err = call("compare", recording, *arguments)
    assert (got, out) == (code, "")
    assert words in err


def test_a_file_that_is_not_there_and_one_that_is_no_recording(call, recording, tmp_path):
    missing = recording.with_name("fligth.npy")
    code, _, err = call("compare", missing, *COST)
    assert code == 3 and f"did you mean {recording}?" in err
    assert call("compare", "no/such/flight.npy", *COST)[0] == 3
    broken = tmp_path / "broken.npy"
    broken.write_bytes(b"no recording")
    assert call("compare", broken, *COST)[0] == 3


def test_run_takes_a_package_as_a_whole_if_asked(call, recording):
    options = ("run", recording, *COST, "--latency", "2ms", "--json")
    anytime, opaque = json.loads(call(*options)[1]), json.loads(call(*options, "--opaque")[1])
    alone = asap.simulate(recording, cost=asap.LinearCost(100, 300), latency_ms=2, opaque=True)
    assert opaque == json.loads(json.dumps(alone.summary()))
    assert opaque["packages"] != anytime["packages"]
    code, _, err = call("run", recording, "--opaque")
    assert code == 2 and "--opaque: needs --cost" in err
