"""The processor's share over latency: each knob gives one for the other."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import pytest

from asap_laboratory import cpu_share
from asap_laboratory.study import Batch


def test_each_knob_gives_latency_for_processor_time(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    task = cpu_share.FlightCase(1, duration_s=1.0)

    def batches(form: str) -> Iterator[Batch]:
        yield Batch([task])

    study = dataclasses.replace(cpu_share.CPU_SHARE, batches=batches)
    monkeypatch.setattr(cpu_share, "CPU_SHARE", study)
    assert cpu_share.main([]) == 2 and cpu_share.main([str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert printed in (tmp_path / "cpu_share.md").read_text()
    assert len(printed.splitlines()) == 2 + len(cpu_share.SETTINGS)
    assert "<svg" in (tmp_path / "cpu_share.svg").read_text()
    rows = task.measure()
    for some in (rows[:5], [rows[2], *rows[5:]]):
        assert all(more["cpu"] >= less["cpu"] for more, less in pairwise(some))
        assert all(more["p50"] <= less["p50"] for more, less in pairwise(some))
        assert some[0]["cpu"] > 1.3 * some[-1]["cpu"]
    assert all(row["in_time"] == 1.0 for row in rows)
