"""The processor's share over latency: each knob gives one for the other."""

from __future__ import annotations

from itertools import pairwise

from asap_laboratory import cpu_share


def test_each_knob_gives_latency_for_processor_time() -> None:
    rows = cpu_share.FlightCase(1, duration_s=1.0).measure()
    for some in (rows[:5], [rows[2], *rows[5:]]):
        assert all(more["cpu"] >= less["cpu"] for more, less in pairwise(some))
        assert all(more["p50"] <= less["p50"] for more, less in pairwise(some))
        assert some[0]["cpu"] > 1.3 * some[-1]["cpu"]
    assert all(row["in_time"] == 1.0 for row in rows)
