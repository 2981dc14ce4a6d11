"""The study of the schemes: what it runs and measures, how it judges, its tables and figures."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import asap
from asap_laboratory import STUDIES, conduct
from asap_laboratory.page import only
from asap_laboratory.profiles import FURTHER, LATENCY_MS
from asap_laboratory.schemes import measure, summary
from asap_laboratory.schemes.cases import FRESH, FRESH_SEEDS, NAMED, Case, cases
from asap_laboratory.schemes.contenders import HINDSIGHT, PRIORS, TABLE, contender
from asap_laboratory.schemes.goals import goals
from asap_laboratory.schemes.probes import BOUNDS, FewProbe, SteadyProbe, mean_latency_us

SMALL = Case("low", "slow", duration_s=0.05, contenders=("Greedy", "Deadline"))
STUDY = STUDIES["study"]


def by_label(rows):
    return {row["contender"]: row for row in rows}


# ---- cases ----------------------------------------------------------------------------------


def test_fresh_seeds_are_no_others():
    full = list(cases("full"))
    fresh = [case for case in full if case.seed in FRESH_SEEDS]
    assert {case.contenders for case in fresh} == {FRESH}
    assert len(fresh) == 20 * len(list(cases("default")))
    assert {case.seed for case in full[: -len(fresh)]} == {1, 2, 3}


def test_every_label_makes_a_scheme_of_its_own():
    cost = SMALL.scenario().cost
    for label in (*TABLE, *PRIORS, *(one for group in HINDSIGHT.values() for one in group)):
        one = contender(label)
        assert one.label == label and one.make(10.0, cost) is not one.make(10.0, cost)
    scheme = contender("Asap2020 a=0.5/beta eps=0.1").make(10.0, cost)
    assert scheme.parameters["rate_bound"] == pytest.approx(0.5 / 300e-9)  # it knows the true beta
    assert contender("Asap2022").make(10.0, cost).parameters["max_size"] == 29_700


# ---- measures -------------------------------------------------------------------------------


def test_case_measures_every_contender():
    found = by_label(SMALL.measure())
    assert set(found) == {"Greedy", "Deadline"}
    one = found["Deadline"]
    assert one["events"] == pytest.approx(5000, rel=0.1) and one["kept"] == one["in_time"] == 1.0
    assert one["score"] == pytest.approx(one["events"] / one["oracle"])
    assert one["p50_ms"] < one["p99_ms"] <= one["max_ms"] < 1.0 and one["settle_ms"] is None
    assert 0.9 < one["cpu"] <= 1.0  # no limit on the overhead: always at work


def test_steps_are_timed():
    case = Case("steps", "slow", duration_s=1.5, contenders=("Deadline", "Greedy"))
    found = by_label(case.measure())
    assert found["Deadline"]["settle_ms"] == 0.0
    assert found["Deadline"]["slowest_recovery_ms"] <= 12.0
    assert found["Greedy"]["settle_ms"] == 496.0


def test_score_is_against_the_oracle_that_lets_cheap_packages_run_on():
    (one,) = Case("high", "slow_ht", duration_s=0.1, contenders=("Greedy",)).measure()
    assert one["score"] == pytest.approx(one["in_time"] * one["events"] / one["oracle"])
    assert one["whole_score"] > 1.2 * one["score"]


def slots(*rows):
    found = np.zeros(len(rows), asap._core.SLOT_DTYPE)
    for name, column in zip(
        ("slot", "received", "delivered", "latency_max_us"), zip(*rows, strict=True), strict=True
    ):
        found[name] = column
    return found


def phase(disturbed, latency_us=1101.0, delivered=10):
    """2 s of slots; those of `disturbed` are late, or lack results."""
    bad, good = (delivered, latency_us), (10, 200.0)
    return slots(*((n, 10, *(bad if n in disturbed else good)) for n in range(2000)))


@pytest.mark.parametrize("time_ms", [measure.settle_ms, measure.recovery_ms])
def test_a_disturbance_lasts_to_the_end_of_its_last_slot(time_ms):
    for disturbed, step, lasts in (
        *(([], 500, 0), ([500], 500, 1), ([499, 500, 507], 500, 8)),
        *(([499, 1000], 500, 0), ([0, 1, 2], 1500, 0)),  # before and after the phase
        ([990, 999], 500, 496),  # never
    ):
        assert time_ms(phase(disturbed), [step], 500, 1000) == [lasts]
    assert time_ms(phase([503], latency_us=1099.0), [500], 500, 1000) == [0]
    assert time_ms(phase([503, 1509]), [500, 1500], 500, 1000) == [4, 10]


def test_to_settle_takes_what_is_in_time_and_to_recover_takes_nearly_all():
    some = phase([504], latency_us=0.0, delivered=9)
    assert measure.settle_ms(some, [500], 500, 1000) == [0]
    assert measure.recovery_ms(some, [500], 500, 1000) == [5]
    few = slots((500, 1000, 980, 0.0), (501, 1000, 979, 0.0))
    assert measure.recovery_ms(few, [500], 500, 1000) == [2]


def test_silence_is_the_longest_run_of_slots_without_a_result():
    rows = [(n, 5, 0 if n in (10, 11, 20, 21, 22, 30, 95) else 5, 0.0) for n in range(100)]
    assert measure.silence_ms(slots(*rows)) == 3
    assert measure.silence_ms(slots(*rows[:20], *rows[21:])) == 2  # an empty slot ends it
    assert measure.silence_ms(slots(*rows), ignore_last=80) == 2
    assert measure.silence_ms(slots(*rows)[:0]) == 0


def test_mean_latency_of_theory():
    assert mean_latency_us(100.0, 300.0, 0.0) == pytest.approx(150.3)  # a package of one event
    assert mean_latency_us(100.0, 300.0, 0.1e6) == pytest.approx(154.94, abs=0.01)
    (one,) = SteadyProbe("slow", 0.5e6, duration_s=0.3).measure()
    assert one["excess"] == pytest.approx(1.0, rel=0.02)


def test_no_scheme_beats_the_exact_clairvoyant():
    for bound in BOUNDS:
        possible, *found = FewProbe(bound, "on and off for 20 ms, load 2.5").measure()
        assert possible["contender"] == "EC(L)/OB(L)" and 0.6 < possible["share"] < 1
        assert len(found) == 4 and all(0.4 < row["share"] <= 1 for row in found)


# ---- goals ----------------------------------------------------------------------------------

GOOD = {
    **{"score": 0.99, "whole_score": 0.99, "in_time": 0.31, "kept": 0.32, "cpu": 0.25},
    **{"p50_ms": 0.5, "p99_ms": 1.9, "max_ms": 2.0, "start_max_ms": 1.5, "gap_ms": 0.5},
    **{"silence_ms": 0, "overflow": 0.0, "packages_per_s": 100.0, "settle_ms": 0.0},
    **{"slowest_recovery_ms": 1.0, "events": 1_000_000, "oracle": 1e6},
}


def rows_of(case):
    what = {name: getattr(case, name) for name in ("cost_model", "profile", "seed", "duration_s")}
    return [{"kind": "run", **what, "contender": label, **GOOD} for label in case.contenders]


def few(arrivals, seed, share):
    what = {"kind": "few", "bound": 5, "arrivals": arrivals, "seed": seed, "share": share}
    return [{**what, "contender": label} for label in ("EC(L)/OB(L)", "Deadline")]


def fake(change=None, **where):
    """Rows of the default form that reach every goal; `change` is made where `where` says."""
    rows = [row for case in cases("default") for row in rows_of(case)]
    rows += [{"kind": "steady", "excess": 1.02, "kept": 1.0}]
    rows += [{"kind": "cap", "greedy": 1.5, "capped": 1.1}]
    rows += [*few("load 3", 1, 0.75), *few("load 3", 2, 0.85), *few("load 1.1", 1, 0.9)]
    for row in only(rows, **where) if change else ():
        row |= change
    return rows


def judged(rows, goal):
    return [row["holds"] for row in goals(rows) if row["goal"] == goal]


def test_every_goal_can_be_reached():
    found = goals(fake())
    ids = [*("G1", "G1b", "G2", "G3", "G4", "G4"), *(f"G{n}" for n in range(5, 13))]
    assert [row["goal"] for row in found] == ids
    assert all(row["holds"] and row["runs"] > 0 for row in found if row["goal"] != "G11")
    assert {row["holds"] for row in goals([])} == {None}  # not run: neither held nor missed


@pytest.mark.parametrize(
    ("goal", "change", "where"),
    [
        ("G1", {"score": 0.96}, ("slow_tv", "steps")),
        ("G1", {"score": 0.98}, (("fast", "slow", "slow_tv"), NAMED)),
        ("G1b", {"score": 0.94}, ("fast", "walk")),
        ("G1b", {"score": 0.965}, (("fast", "slow", "slow_tv"), FURTHER)),
        ("G2", {"score": 0.96}, ("slow", "spikes")),
        ("G3", {"score": 0.95}, ("slow_ht", NAMED)),
        ("G3", {"p99_ms": 10.1}, ("slow_ht", "high")),
        ("G4", {"max_ms": 2.03}, ("fast", "steps60")),
        ("G4", {"max_ms": 10.6}, ("slow", "steps", "whole Deadline")),
        ("G4", {"p99_ms": 10.1}, ("slow", "steps", "whole Deadline")),
        ("G7", {"max_ms": 10.2}, ("slow", "steps")),
        ("G7", {"slowest_recovery_ms": 12.1}, ("slow", "steps")),
        ("G8", {"cpu": 0.9}, ("slow", "low", "Deadline oh.25")),
        ("G9", {"overflow": 1e-6}, ("slow", "high")),
        ("G9", {"gap_ms": 0.51}, ("fast", "train")),
        ("G10", {"start_max_ms": 10.02}, ("slow", "high", PRIORS[0])),
        ("G10", {"score": 0.979}, ("slow", "uav", PRIORS[-1])),
        ("G12", {"in_time": 0.299}, ("slow", "ramp")),
    ],
)
def test_goal_can_be_missed(goal, change, where):
    model, profile, label = (*where, "Deadline")[:3]
    assert False in judged(fake(change, cost_model=model, profile=profile, contender=label), goal)


@pytest.mark.parametrize(
    ("change", "where"),
    [
        # Not what the goals are about: outages, other rows, a load that stays above 0.7.
        ({"max_ms": 30.0, "silence_ms": 20, "overflow": 0.1}, ("slow_ht", "high", "Deadline")),
        ({"score": 0.0, "max_ms": 500.0, "silence_ms": 99}, ("slow", "high", "Greedy")),
        ({"slowest_recovery_ms": 400.0}, ("slow", "steps60", "Deadline")),
        ({"cpu": 1.0}, ("slow", "low", "Deadline")),
        # Overload may take the whole processor: load 3; 0.6, but not all of the time.
        ({"cpu": 1.0, "events": 5e7, "oracle": 17e6}, ("slow", "high", "Deadline oh.25")),
        ({"cpu": 1.0, "events": 1e7, "oracle": 9e6}, ("slow", "high", "Deadline oh.25")),
    ],
)
def test_goal_is_not_missed_for_what_it_leaves_out(change, where):
    model, profile, label = where
    rows = fake(change, cost_model=model, profile=profile, contender=label)
    assert False not in [row["holds"] for row in goals(rows)]


def test_probe_can_miss_its_goal():
    assert judged(fake({"excess": 1.06}, kind="steady"), "G5") == [False]
    assert judged(fake({"kept": 0.9999}, kind="steady"), "G5") == [False]
    two = [*fake(), {"kind": "cap", "greedy": 1.5, "capped": 1.21}]  # mean: 1.155
    assert judged(two, "G6") == [False]


# ---- tables and figures ---------------------------------------------------------------------


def test_tables_have_means_oracles_and_aggregates():
    worst = {"score": 0.5, "p99_ms": 20.0, "cpu": 1.0}
    tables = summary(fake(worst, profile="high", cost_model="slow", contender="Greedy"))
    (one,) = only(tables["study"], cost_model="slow", profile="high", contender="Greedy")
    assert (one["score"], one["p99_ms"]) == (0.5, 20.0)
    oracles = only(tables["study"], contender="OB(L)/input")
    assert len(oracles) == 64 and {row["score"] for row in oracles} == {1.0}
    assert not only(tables["study"], contender=("EC(L)/input", *PRIORS))
    cell = STUDY.cells["aggregate"]
    named = only(tables["aggregates"], further=False, contender="Greedy")
    assert [row["cost_model"] for row in named] == list(LATENCY_MS)
    words = [cell(row) for row in named]
    assert words[:2] == [".990 / .990 / 0.95 / .250", ".936 / .500 / 2 / .333"]
    assert [(row["mean"], row["least"]) for row in tables["few"]] == [
        *(pytest.approx((0.85, 0.8)),) * 2,
    ]


def test_seeds_are_averaged_before_the_least_is_taken_and_hindsight_takes_the_best():
    case = Case("high", "slow", contenders=("Greedy", *HINDSIGHT["Asap2020 best"]))
    rows = rows_of(case) + rows_of(dataclasses.replace(case, seed=2))
    for row in rows:
        row["score"] = {1: 0.2, 2: 0.6}[row["seed"]]
    group = HINDSIGHT["Asap2020 best"]
    only(rows, seed=1, contender=group[3])[0].update(score=0.9, silence_ms=60)
    only(rows, seed=1, contender=group[7])[0].update(score=0.4, silence_ms=59)
    tables = summary(rows)
    found = {row["contender"]: row["score"] for row in tables["study"]}
    assert found == pytest.approx({"OB(L)/input": 1.0, "Greedy": 0.4, "Asap2020 best": 0.5})
    assert [row["least"] for row in tables["aggregates"]] == pytest.approx([0.4, 0.5])


def test_fresh_seeds_are_judged_by_themselves():
    spoiled = {"score": 0.5, "p99_ms": 12.0, "max_ms": 15.0}
    rows = fake()
    for seed in FRESH_SEEDS[:2]:
        rows += rows_of(Case("high", "slow", seed, contenders=FRESH))
        rows += rows_of(Case("low", "slow", seed, contenders=FRESH))
    (one,) = only(rows, seed=FRESH_SEEDS[0], profile="high", contender="whole Deadline")
    one |= spoiled
    tables = summary(rows)
    assert only(tables["study"], contender="whole Deadline", profile="high")[0]["score"] == 0.99
    (found,) = only(tables["fresh"], contender="whole Deadline")
    assert STUDY.cells["on fresh seeds"](found) == ".867±.1732 / .500 / 1.20 / 1.50"
    (whole,) = [row for row in tables["goals"] if row["test"] == "no outages, whole"]
    assert (whole["holds"], whole["fresh_holds"]) == (True, False)
    assert STUDY.cells["fresh"](whole).startswith("**FAIL**: p99 1.200 L (slow/high)")


# ---- the whole ------------------------------------------------------------------------------


# What the default gives up for shorter gaps, and gaps longer than wanted where the cost rises:
# notebooks/evidence.md.
MISSED = {"G1", "G1b", "G3", "G4", "G9"}


@pytest.mark.slow
@pytest.mark.full
def test_quick_form_reaches_the_goals(tmp_path):
    found = conduct(STUDY, tmp_path, form="quick")
    goals = found.tables["goals"]
    assert {row["goal"] for row in goals if row["holds"] is False} == MISSED
    assert [row["goal"] for row in goals if row["holds"] is None] == ["G11"]
