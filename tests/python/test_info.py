"""asap.info: the object of the verb."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import asap
import corrupt
from asap import analysis, cli

EVENTS = corrupt.clean_events(3000)


def test_the_facts(tmp_path: Path) -> None:
    path = tmp_path / "events.npz"
    np.savez(path, events=corrupt.outside_sensor(EVENTS, 60), width=346, height=260)
    facts = asap.info(path)
    found = analysis.describe(asap.read(path))
    assert facts == {
        "schema_version": 1,
        "path": str(path),
        "format": "npz",
        "width": 346,
        "height": 260,
        "events": 2940,
        "duration_s": found.duration_s,
        "on_share": found.on_share,
        "x_max": int(EVENTS["x"].max()),
        "y_max": int(EVENTS["y"].max()),
        "rate_hz": {
            "mean": found.rate_mean_hz,
            "peak_1ms": found.rate_peak_1ms_hz,
            "peak_10ms": found.rate_peak_10ms_hz,
        },
        "rejected": asap.read(path).rejected | {"out_of_bounds": 60},
        "clock_resets": 0,
        "lost_packets": 0,
    }
    assert asap.info(asap.read(path)) == facts


def test_clock_resets_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "events.npy"
    np.save(path, EVENTS)
    assert cli.main(["info", str(path)]) == 0
    assert "clock" not in capsys.readouterr().out
    np.save(path, corrupt.clock_reset(EVENTS, 1000))
    assert asap.info(path)["clock_resets"] == 1
    assert cli.main(["info", str(path)]) == 0
    assert "\n  clock     set back 1 x by 1 s or more: " in capsys.readouterr().out
