"""The study of the schemes: every scheme and rival over profiles and costs, beside the oracle."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Mapping
from pathlib import Path
from statistics import fmean, stdev
from typing import Any

from asap_laboratory.page import (
    Cell,
    Row,
    Rows,
    Tables,
    Writer,
    distinct,
    figure,
    fixed,
    only,
    over_seeds,
    short,
)
from asap_laboratory.profiles import FURTHER, LATENCY_MS
from asap_laboratory.schemes.cases import FRESH_SEEDS, NAMED, cases
from asap_laboratory.schemes.contenders import HINDSIGHT, PRIORS
from asap_laboratory.schemes.goals import goals
from asap_laboratory.schemes.probes import probes
from asap_laboratory.study import Batch, Study

__all__ = ["SCHEMES", "summary"]

_SHARES = ("score", "kept", "overflow", "cpu", "whole_score")
_TIMES = ("p50_ms", "p99_ms", "max_ms", "gap_ms", "settle_ms", "packages_per_s")
_LONG_SILENCE_MS = 60.0
_CASE = ("cost_model", "profile")


def _batches(form: str) -> Generator[Batch, Rows, None]:
    yield Batch([*cases(form), *probes(form)])


def summary(rows: Rows) -> Tables:
    """Make the tables: cells by cost model, profile and contender; their aggregates; goals."""
    fresh = [row for row in rows if row.get("seed") in FRESH_SEEDS]
    rows = [row for row in rows if row.get("seed") not in FRESH_SEEDS]
    runs = [row for row in only(rows, kind="run") if row["contender"] not in PRIORS]
    settings = {label for group in HINDSIGHT.values() for label in group}
    tabled = [row for row in runs if row["contender"] not in settings] + list(_in_hindsight(runs))
    cells = over_seeds(tabled, (*_CASE, "contender"), (*_SHARES, *_TIMES))
    cells.sort(key=lambda row: (*_place(row), row["contender"] in HINDSIGHT))
    kept = (*_CASE, "contender", *_SHARES, *_TIMES)
    return {
        "study": [*_oracles(runs), *({name: row[name] for name in kept} for row in cells)],
        "aggregates": list(_aggregates(cells)),
        "few": list(_few(only(rows, kind="few"))),
        "fresh": list(_on_fresh_seeds(fresh)),
        "goals": [
            {**row, "fresh": again["measured"], "fresh_holds": again["holds"]}
            for row, again in zip(goals(rows), goals(fresh), strict=True)
        ],
    }


def _place(row: Row) -> tuple[int, int]:
    profile = row["profile"]
    place = NAMED.index(profile) if profile in NAMED else len(NAMED)
    return list(LATENCY_MS).index(row["cost_model"]), place


def _in_hindsight(runs: Rows) -> Iterator[Row]:
    """Yield the best setting of each family in each case.

    By the reference's rule a long silence is worth as much as the whole score.
    """
    for best, group in HINDSIGHT.items():
        by_case: dict[tuple[Any, ...], Rows] = {}
        for row in only(runs, contender=group):
            by_case.setdefault((row["cost_model"], row["profile"], row["seed"]), []).append(row)
        for some in by_case.values():
            chosen = max(
                some, key=lambda row: row["score"] - (row["silence_ms"] >= _LONG_SILENCE_MS)
            )
            yield {**chosen, "contender": best}


def _oracles(runs: Rows) -> Iterator[Row]:
    """Yield what is possible at most, as a share of the input: a row like those of contenders."""
    shares = [{**row, "share": row["oracle"] / max(row["events"], 1)} for row in runs]
    for row in sorted(over_seeds(shares, _CASE, ("share",)), key=_place):
        what = {name: row[name] for name in _CASE}
        yield {**what, "contender": "OB(L)/input", "score": row["share"]}


def _together(rows: Rows) -> Iterator[tuple[Row, Rows]]:
    """Yield what a contender has of a cost model's named or further profiles, and what it is."""
    groups: dict[tuple[Any, ...], Rows] = {}
    for row in rows:
        key = row["contender"], row["cost_model"], row["profile"] in FURTHER
        groups.setdefault(key, []).append(row)
    for key, some in groups.items():
        yield dict(zip(("contender", "cost_model", "further"), key, strict=True)), some


def _aggregates(cells: Rows) -> Iterator[Row]:
    for what, some in _together(cells):
        model = what["cost_model"]
        yield {
            **what,
            "mean": fmean(row["score"] for row in some),
            "least": min(row["score"] for row in some),
            "p99_of_bound": max(row["p99_ms"] / LATENCY_MS[model] for row in some),
            "cpu": fmean(row["cpu"] for row in some),
        }


def _on_fresh_seeds(runs: Rows) -> Iterator[Row]:
    """Yield what a contender does with a cost model: its mean over the profiles, seed by seed."""
    for what, some in _together(sorted(runs, key=_place)):
        bound_ms = LATENCY_MS[what["cost_model"]]
        scores = [
            fmean(row["score"] for row in only(some, seed=seed)) for seed in distinct(some, "seed")
        ]
        yield {
            **what,
            "mean": fmean(scores),
            "sd": stdev(scores) if len(scores) > 1 else None,
            "least": min(row["score"] for row in some),
            "p99_of_bound": max(row["p99_ms"] for row in some) / bound_ms,
            "max_of_bound": max(row["max_ms"] for row in some) / bound_ms,
        }


def _few(rows: Rows) -> Iterator[Row]:
    found = over_seeds(rows, ("contender", "bound", "arrivals"), ("share",))
    for contender in dict.fromkeys(row["contender"] for row in found):
        for bound in sorted({row["bound"] for row in found}, reverse=True):
            shares = [row["share"] for row in only(found, contender=contender, bound=bound)]
            mean, least = fmean(shares), min(shares)
            yield {"contender": contender, "bound": bound, "mean": mean, "least": least}


def _figures(tables: Tables) -> Mapping[str, Any]:
    from asap_laboratory.schemes import figures

    return {
        "step_response": figures.step_response(),
        "score_and_latency": figures.score_and_latency(tables["aggregates"]),
        "scores": figures.heat_map(tables["study"]),
    }


def _shown(tables: Tables, writer: Writer) -> str:
    lines = []
    for row in tables["goals"]:
        word = {True: "pass", False: "FAIL", None: "-"}[row["holds"]]
        lines.append(f"{row['goal']:<4} {word:<5} {row['test']}")
        lines.append(f"           {row['measured']}  (goal: {row['target']})")
    return "\n".join(lines)


def _share(value: float | None) -> str:
    return "" if value is None else fixed(value)


def _aggregate(row: Row) -> str:
    scores = f"{fixed(row['mean'])} / {fixed(row['least'])}"
    return f"{scores} / {short(row['p99_of_bound'])} / {fixed(row['cpu'])}"


def _on_fresh(row: Row) -> str:
    mean = fixed(row["mean"]) + ("" if row["sd"] is None else f"±{fixed(row['sd'], 4)}")
    return f"{mean} / {fixed(row['least'])} / {row['p99_of_bound']:.2f} / {row['max_of_bound']:.2f}"


def _judged(measured: str, holds: str) -> Cell:
    return lambda row: ("**FAIL**: " if row[holds] is False else "") + row[measured]


SCHEMES = Study(
    name="study",
    command="asap-study",
    template=Path(__file__).with_name("page.md"),
    batches=_batches,
    summary=summary,
    tables=("study", "aggregates", "few", "fresh", "goals"),
    cells={
        **{name: figure(name, _share) for name in _SHARES},
        **{name: figure(name, short) for name in _TIMES},
        "aggregate": _aggregate,
        "mean and least": lambda row: f"{fixed(row['mean'])} / {fixed(row['least'])}",
        "on fresh seeds": _on_fresh,
        "measured": _judged("measured", "holds"),
        "fresh": _judged("fresh", "fresh_holds"),
    },
    figures=_figures,
    facts=lambda tables: {
        "models": tuple(LATENCY_MS),
        "fresh": f"{FRESH_SEEDS[0]} to {FRESH_SEEDS[-1]}",
    },
    shown=_shown,
)
