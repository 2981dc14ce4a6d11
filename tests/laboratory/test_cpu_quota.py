"""The flight under a processor quota: the system holds the quota, ASAP its ledger."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("asap_laboratory")

from asap_laboratory import cpu_quota


def test_a_system_without_the_controller_is_named(tmp_path: Path) -> None:
    with pytest.raises(cpu_quota.NoQuota, match="no controller cpu"):
        cpu_quota.quota(0.5, tmp_path).__enter__()


def test_a_group_that_cannot_be_made_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "cpu").mkdir()
    (tmp_path / "cpu" / "cpu.shares").touch()

    def refused(**_: object) -> str:
        raise PermissionError("Permission denied")

    monkeypatch.setattr(cpu_quota.tempfile, "mkdtemp", refused)
    with pytest.raises(cpu_quota.NoQuota, match=r"no group can be made in .*Permission denied"):
        cpu_quota.quota(0.5, tmp_path).__enter__()


def test_the_process_has_its_share_and_no_more() -> None:
    try:
        (row,) = cpu_quota.measure(0.25, [(0.8, 0.0)], duration_s=1.0)
    except cpu_quota.NoQuota as reason:
        pytest.skip(str(reason))
    assert 0.05 < row["cpu"] < 0.35
    assert row["packages_per_s"] > 0
