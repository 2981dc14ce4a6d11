"""What Deadline keeps within its bound: cases of the page, on a seed that it does not use."""

from __future__ import annotations

import pytest

from asap_laboratory.bounds import DISTURBED, BoundCase, DisturbedCase


@pytest.mark.parametrize("load", ["load 1.1", "load 1.5"])
def test_a_bound_of_three_fixed_costs_keeps_nine_tenths_of_what_is_possible(load: str) -> None:
    rows = BoundCase(3, load, seed=1).measure()
    assert {row["execution"] for row in rows} == {"anytime", "whole"}
    assert min(row["share"] for row in rows if row["prefer"] == "balanced") > 0.9


@pytest.mark.parametrize("kind", ["flat, interrupted", "1 and 3 in 10 calls three times as long"])
def test_what_cannot_be_gained_by_dropping_is_not_dropped(kind: str) -> None:
    number = next(i for i, case in enumerate(DISTURBED) if case.kind == kind)
    greedy, ours = DisturbedCase(number, seed=1).measure()
    assert (greedy["scheme"], ours["scheme"]) == ("greedy", "deadline")
    assert 0 < greedy["in_time"] <= 1
    assert ours["in_time"] > 0.95 * greedy["in_time"]
