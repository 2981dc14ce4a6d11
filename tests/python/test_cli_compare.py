"""asap compare, and --opaque of asap run, as a user calls them."""

import json

import numpy as np
import pytest

import asap
import streams
from asap import cli

PROFILE = ("bursts", "--duration", "50ms")
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


def test_a_profile(call):
    code, out, err = call("compare", *PROFILE, *COST)
    assert (code, err) == (0, "")
    assert out.startswith("bursts: 8 schemes beside the oracle\n346 x 260 px, ")
    assert "Deadline " in out and "jAER timer" not in out


def test_json_is_the_summary_of_compare(call):
    got = result(call, *PROFILE, *COST, "--latency", "5ms", "--seed", 3)
    expected = asap.compare(
        asap.profiles.Profile("bursts", duration_s=0.05, seed=3),
        cost=asap.LinearCost(100, 300),
        latency_ms=5,
        seed=3,
    )
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


def test_speed_and_opaque_and_all(call, recording):
    got = result(call, recording, *COST, "--speed", 20, "--opaque", "--all")
    assert got["speed"] == 20 and got["opaque"]
    assert got["source"]["duration_s"] == pytest.approx(0.05 / 20, rel=0.01)
    assert "jAER timer" in [one["label"] for one in got["schemes"]]
    best = asap.oracle(
        recording, cost=asap.LinearCost(100, 300), latency_ms=10, opaque=True, speed=20
    )
    assert got["oracle"]["events"] == best


@pytest.mark.parametrize("name", ["fast", "slow", "slow_tv", "slow_ht"])
def test_a_cost_model_by_name_brings_its_latency(call, recording, name):
    model = asap.profiles.COSTS[name]
    for source in ((*PROFILE,), (recording,)):
        got = result(call, *source, "--cost", name)
        assert got["latency_bound_us"] == model.latency_ms * 1e3
        assert got["cost"]["alpha_us"] == model.alpha_us
        assert got["cost"]["noise"] == model.noise
        assert ("drift" in got["cost"], "outages_ms" in got["cost"]) == (
            model.drifts,
            model.fails and source == (recording,),  # none in the first 50 ms
        )
    assert result(call, recording, "--cost", name, "--latency", "7ms")["latency_bound_us"] == 7000


def test_a_further_profile_is_scaled_as_in_the_study(call):
    options = ("spikes", "--duration", "20ms")
    fast, slow = (result(call, *options, "--cost", name) for name in ("fast", "slow"))
    assert fast["source"]["events"] > 10 * slow["source"]["events"]


def test_report(call, tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    path = tmp_path / "out.html"
    code, out, _ = call("compare", *PROFILE, *COST, "--report", path)
    assert code == 0 and out.startswith("bursts: 8") and out.endswith(f"\nwrote {path}\n")
    assert "<table" in path.read_text("utf-8")
    monkeypatch.setattr(asap.Comparison, "report", lambda self, path: path)
    result(call, *PROFILE, *COST, "--report", path)  # the object and nothing else


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["bursst", *COST], 2, "bursst: neither a file nor a profile; did you mean bursts?"),
        (["zzz", *COST], 2, "profiles are quiet, low, uav"),
        (["no/such/flight.npy", *COST], 3, "no/such/flight.npy: no such file\n"),
        ([*PROFILE], 2, "--cost is missing: give what the algorithm takes"),
        ([*PROFILE, "--cost", "slwo"], 2, "cost = slwo: no such cost model; did you mean slow?"),
        ([*PROFILE, "--cost", "zzz"], 2, "there are fast, slow, slow_tv, slow_ht"),
        ([*PROFILE, "--cost", "100us"], 2, "write time per package + time per event"),
        ([*PROFILE, *COST, "--latency", "10"], 2, "latency = 10: the unit is missing"),
        ([*PROFILE, *COST, "--speed", "0"], 2, "speed = 0.0: must be between"),
        ([*PROFILE, *COST, "--seed", "-1"], 2, "seed"),
        (["bursts", *COST, "--duration", "1ms"], 2, "duration_s = 0.001"),
        ([*PROFILE, *COST, "--report", "no/such/out.html"], 2, "there is no folder no/such"),
    ],
)
def test_wrong_use_says_what_is_right(call, arguments, code, words):
    got, out, err = call("compare", *arguments)
    assert (got, out) == (code, "")
    assert words in err


def test_a_file_that_is_not_there_and_one_that_is_no_recording(call, recording, tmp_path):
    missing = recording.with_name("fligth.npy")
    code, _, err = call("compare", missing, *COST)
    assert code == 3 and f"did you mean {recording}?" in err
    code, _, err = call("compare", recording, *COST, "--duration", "1s")
    assert code == 2 and "--duration: only a profile has one" in err
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
