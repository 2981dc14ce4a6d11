"""The simulator beside the clock: the same stream in both, and the table of the pairs."""

from __future__ import annotations

import numpy as np
import pytest

import asap
from asap_laboratory import STUDIES, _native, conduct, profiles, realtime

Short = realtime.ClocksCase


def test_both_clocks_get_the_same_events(tmp_path, monkeypatch):
    monkeypatch.setattr(realtime, "PROFILES", ("low",))
    real, virtual = realtime.ClocksCase("low", duration_s=0.1).measure()
    assert (real["clock"], virtual["clock"]) == ("real", "virtual")
    assert virtual["kept"] == virtual["in_time"] == 1 and virtual["late_max_ms"] is None
    assert 0 <= real["in_time"] <= real["kept"] <= 1 and real["late_max_ms"] >= 0
    study = STUDIES["realtime"]
    monkeypatch.setattr(realtime, "ClocksCase", lambda profile: Short(profile, duration_s=0.05))
    found = conduct(study, tmp_path, workers=1)
    row = next(line for line in found.paths[0].read_text().splitlines() if "| low |" in line)
    assert row.count(" / ") == 6 and row.count("|") == 8


def test_a_busy_wait_costs_what_it_says():
    events = profiles.Profile("low", duration_s=0.1).events()
    algorithm = _native.BusyWait(200.0, 1000.0)
    run = asap.run(events, algorithm=algorithm, scheme=asap.FixedSize(size=500))
    rows = run.packages
    assert np.all(rows["processing_us"] >= 200 + rows["size"])


def test_an_algorithm_of_another_extension_runs_natively():
    """Its Python face is not called: the library owns the loop, so a package ends on time."""

    class Untouched(_native.BusyWait):
        def process(self, events):
            raise AssertionError("called")

    events = profiles.Profile("low", duration_s=0.05).events()
    run = asap.run(events, algorithm=Untouched(10.0, 10.0), latency_ms=10)
    assert run.ledger.received == events.size and run.ledger.balanced


@pytest.mark.parametrize(("field", "value"), [("alpha_us", -1.0), ("beta_ns", float("nan"))])
def test_a_bad_cost_is_refused_by_name(field, value):
    with pytest.raises(ValueError, match=field):
        _native.BusyWait(**{"alpha_us": 1.0, "beta_ns": 1.0, field: value})
