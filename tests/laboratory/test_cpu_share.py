"""The processor's share over latency: what the table says is what the runs say."""

from __future__ import annotations

from itertools import pairwise

import pytest

pytest.importorskip("asap_laboratory")

from asap_laboratory import cpu_share
from asap_laboratory.cpu_share import Setting


@pytest.fixture(scope="module")
def rows() -> list[cpu_share.Row]:
    return cpu_share.measure(seeds=(1,), duration_s=1.0)


def test_each_knob_gives_latency_for_processor_time(rows: list[cpu_share.Row]) -> None:
    by_overhead = [row for row in rows if row.setting.min_interval_ms == 0]
    by_interval = [row for row in rows if row.setting.overhead == 0.25]
    for some in (by_overhead, by_interval):
        assert all(more.cpu >= less.cpu for more, less in pairwise(some))
        assert all(more.p50 <= less.p50 for more, less in pairwise(some))
        assert some[0].cpu > 1.3 * some[-1].cpu
    assert all(row.in_time == 1.0 for row in rows)


def test_table_and_figure_have_every_setting(rows: list[cpu_share.Row]) -> None:
    pytest.importorskip("matplotlib")
    assert len(cpu_share.table(rows).splitlines()) == 2 + len(cpu_share.SETTINGS)
    (axes,) = cpu_share.draw(rows).axes
    assert [len(line.get_xdata()) for line in axes.lines] == [5, 5]


def test_the_command_writes_both(tmp_path, capsys, monkeypatch) -> None:
    pytest.importorskip("matplotlib")
    short = cpu_share.measure([Setting(), Setting(overhead=0.5)], seeds=(1,), duration_s=0.1)
    monkeypatch.setattr(cpu_share, "measure", lambda: short)
    assert cpu_share.main([str(tmp_path)]) == 0
    assert (tmp_path / "cpu_share.md").read_text() == capsys.readouterr().out
    assert "<svg" in (tmp_path / "cpu_share.svg").read_text()
    assert cpu_share.main([]) == 2
