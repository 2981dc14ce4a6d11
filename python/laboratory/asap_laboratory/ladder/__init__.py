"""The ladder: every consumer of the library on one stream that overloads the slow ones.

"quick" puts four consumers to a small stream, "default" all of them to the whole one with three
seeds, "full" with five. What is measured by the clock runs one at a time.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping
from pathlib import Path
from typing import Any

from asap_laboratory.ladder.cases import REAL_LATENCY_MS, LadderCase, LadderReplay
from asap_laboratory.ladder.cost import CostCase
from asap_laboratory.ladder.rungs import LATENCY_MS, RUNGS, SLOWDOWN
from asap_laboratory.ladder.settings import BASELINES, OURS, Setting, best, best_for_all, ours
from asap_laboratory.page import (
    Row,
    Rows,
    Tables,
    Writer,
    distinct,
    figure,
    only,
    over_seeds,
    share,
    spread,
)
from asap_laboratory.study import Batch, Study

__all__ = ["LADDER"]

_QUICK = ("BAF", "EFast", "published", "published, 2 us")
_SEEDS = {"quick": (0,), "default": (0, 1, 2), "full": (0, 1, 2, 3, 4)}
_OTHER_BOUNDS_MS = (1.0, 2.0, 3.0, 5.0, 10.0, 20.0)
_WITH_OTHER_BOUNDS = ("ClusterTracker", "published")
_TOLD_OTHERWISE = ("ClusterTracker", "ClusterTracker, 300 ns")
_FIGURES = ("kept", "in_time", "p99_of_bound", "max_of_bound", "overflow", "stale")
_ACCURACY = ("delivered", "in_use")

Settings = dict[str, dict[str, Setting]]


def _batches(form: str) -> Generator[Batch, Rows, None]:
    labels = _QUICK if form == "quick" else tuple(RUNGS)
    size = "small" if form == "quick" else "whole"
    seeds = _SEEDS[form]
    measured = yield Batch([CostCase(label, size) for label in labels], one_at_a_time=True)
    settings = _settings(measured)
    costs = {  # on the slow computer
        row["rung"]: (row["alpha_us"] * SLOWDOWN, row["beta_ns"] * SLOWDOWN)
        for row in only(measured, kind="cost")
    }
    virtual = [
        LadderCase(label, seed, *costs[label], settings[label], size)
        for seed in seeds
        for label in labels
    ]
    bounds = [
        LadderCase(label, seed, *costs[label], {OURS: ours(bound)}, size, bound)
        for label in _WITH_OTHER_BOUNDS
        if label in costs
        for bound in _OTHER_BOUNDS_MS
        for seed in seeds
    ]
    told = [
        LadderCase(
            label,
            seed,
            *costs[label],
            {name: settings[label][name] for name in (OURS, *BASELINES)},
            size,
            told=told,
        )
        for label in _TOLD_OTHERWISE
        if label in costs
        for told in ("nothing", "mean")
        for seed in seeds
    ]
    yield Batch([*virtual, *bounds, *told])
    real = [LadderReplay(rung, seed, settings[rung], size) for seed in seeds for rung in labels]
    yield Batch(real, one_at_a_time=True)


def _settings(measured: Rows) -> Settings:
    """Choose the setting of every scheme for every consumer, from how each did."""
    ladder = {rung: only(measured, kind="tried", rung=rung) for rung in distinct(measured, "rung")}
    for_all = {
        f"{name}, one for all": best_for_all(list(ladder.values()), name) for name in BASELINES
    }
    return {
        rung: {OURS: ours(), **{name: best(tried, name) for name in BASELINES}, **for_all}
        for rung, tried in ladder.items()
    }


def _summary(rows: Rows) -> Tables:
    costs = {row["rung"]: row for row in only(rows, kind="cost")}
    settings = _settings([row for row in rows if row["kind"] in ("cost", "tried")])
    runs = only(rows, kind="run")
    virtual = only(runs, clock="virtual")
    rates = {row["rung"]: row["rate_hz"] for row in over_seeds(virtual, ("rung",), ("rate_hz",))}
    table = over_seeds(runs, ("rung", "clock", "scheme"), (*_FIGURES, *_ACCURACY, "alone"))
    for row in table:
        cost = costs[row["rung"]]
        load = rates[row["rung"]] * cost["beta_ns"] * 1e-9 * SLOWDOWN
        possible = min(1.0, 1 / load)
        row |= {
            "score": RUNGS[row["rung"]].score,
            "alpha_us": None if RUNGS[row["rung"]].stated else cost["alpha_us"],
            "beta_ns": cost["beta_ns"],
            "load": load,
            "possible": possible,
            "of_possible": row["in_time"] / possible,
            "of_possible_sd": None if row["seeds"] == 1 else row["in_time_sd"] / possible,
            "setting": str(settings[row["rung"]][row["scheme"]]),
        }
        for name in _FIGURES:
            del row[f"{name}_sd"]
    table.sort(key=lambda row: float(row["beta_ns"]))
    bounds = over_seeds(only(rows, kind="bound"), ("rung", "latency_ms"), ("kept", *_ACCURACY))
    told = over_seeds(only(rows, kind="told"), ("rung", "told", "scheme"), ("in_use",))
    late = [{"late_ms": max(row["late_us"] for row in only(runs, clock="real")) / 1e3}]
    return {"ladder": table, "bounds": bounds, "told": told, "late": late}


def _facts(tables: Tables) -> dict[str, Any]:
    rows = tables["ladder"]
    virtual = only(rows, clock="virtual")
    settings = {
        one: distinct(only(virtual, scheme=one), "setting") for one in distinct(virtual, "scheme")
    }
    same = {one: found[0] for one, found in settings.items() if len(found) == 1}
    by_scheme = [
        {**row, "told": "what the scheme says"}
        for row in only(virtual, rung=tuple(distinct(tables["told"], "rung")))
        if row["scheme"] in distinct(tables["told"], "scheme")
    ]
    told = [*by_scheme, *tables["told"]]
    return {
        "virtual": virtual,
        "scored": [row for row in virtual if row["score"]],
        "real": only(rows, clock="real"),
        "same": same,
        "own": [row for row in virtual if row["scheme"] not in same],
        "told": sorted(told, key=lambda row: str(row["rung"])),
        "seeds": rows[0]["seeds"],
        "slowdown": SLOWDOWN,
        "latency_ms": LATENCY_MS,
        "real_latency_ms": REAL_LATENCY_MS,
        "late_ms": tables["late"][0]["late_ms"],
    }


def _figures(tables: Tables) -> Mapping[str, Any]:
    from asap_laboratory.ladder import figures

    return {"ladder": figures.figure(only(tables["ladder"], clock="virtual"))}


_IN_TIME = {
    "rung": "",
    "alpha_us": "alpha us",
    "beta_ns": "ns/event",
    "load": "load",
    "possible": "possible",
}


def _shown(tables: Tables, writer: Writer) -> str:
    rows = only(tables["ladder"], clock="virtual")
    in_use = {"rung": "", "score": "", "alone": "all events"}
    parts = [
        "finished within L",
        writer.pivot(rows, _IN_TIME, "scheme", "in_time"),
        "accuracy in use",
        writer.pivot([row for row in rows if row["score"]], in_use, "scheme", "in_use"),
    ]
    return "\n\n".join(parts)


def _beta(row: Row) -> str:
    return f"{row['beta_ns']:.3g}" if row["beta_ns"] < 1000 else f"{row['beta_ns']:.0f}"


def _in_time_and_p99(row: Row) -> str:
    p99 = f"{row['p99_of_bound']:.2f}"
    missed = row["scheme"] == "Deadline" and float(p99) > 1  # the one that aims at L
    return f"{share(row['in_time'])}, " + (f"**{p99}**" if missed else p99)


LADDER = Study(
    name="ladder",
    command="asap-study --ladder",
    template=Path(__file__).with_name("page.md"),
    batches=_batches,
    summary=_summary,
    tables=("ladder", "bounds", "told", "late"),
    cells={
        "alpha_us": lambda row: "stated" if row["alpha_us"] is None else f"{row['alpha_us']:.2f}",
        "beta_ns": _beta,
        "load": figure("load", lambda value: f"{value:.3g}"),
        "latency_ms": figure("latency_ms", lambda value: f"{value:g}"),
        "possible": figure("possible", share),
        "in_time": figure("in_time", share),
        "kept": spread("kept"),
        "latency": lambda row: f"{row['p99_of_bound']:.2f} / {row['max_of_bound']:.2f}",
        "fate": lambda row: " / ".join(share(row[one]) for one in ("kept", "overflow", "stale")),
        "in time, p99": _in_time_and_p99,
        "score": lambda row: {"tracker": "MOTA", "corners": "F"}[row["score"]],
        "alone": spread("alone"),
        "delivered": spread("delivered"),
        "in_use": spread("in_use"),
    },
    figures=_figures,
    facts=_facts,
    shown=_shown,
)
