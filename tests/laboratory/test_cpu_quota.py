"""The flight under a processor quota: the system holds the quota, ASAP its ledger."""

from __future__ import annotations

import pytest

pytest.importorskip("asap_laboratory")

from asap_laboratory import cpu_quota


def test_the_process_has_its_share_and_no_more() -> None:
    try:
        (row,) = cpu_quota.measure(0.25, [(0.8, 0.0)], duration_s=1.0)
    except cpu_quota.NoQuota as reason:
        pytest.skip(str(reason))
    assert 0 < row["cpu"] < 0.35
    assert row["packages_per_s"] > 0
