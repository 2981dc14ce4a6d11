"""The ladder study: cost and baselines first, then every consumer under every scheme."""

from __future__ import annotations

from concurrent.futures import Executor
from pathlib import Path
from typing import Any, Literal, NamedTuple

from asap._progress import OnProgress
from asap_laboratory.conduct import made_ready
from asap_laboratory.ladder import document
from asap_laboratory.ladder.cases import LadderCase, LadderReplay, Outcomes, ToldCase
from asap_laboratory.ladder.cost import CostCase, Costs
from asap_laboratory.ladder.results import (
    LadderRow,
    OverLatency,
    Told,
    over_latency,
    row,
    told_rows,
)
from asap_laboratory.ladder.rungs import LATENCY_MS, RUNGS, SLOWDOWN, missing_rungs
from asap_laboratory.ladder.settings import BASELINES, OURS, Setting, best, best_for_all, ours
from asap_laboratory.run import Ran, run

_QUICK = ("BAF", "EFast", "compat", "compat, 2 us")
_SEEDS = {"quick": (0,), "default": (0, 1, 2), "full": (0, 1, 2, 3, 4)}
_OTHER_BOUNDS_MS = (1.0, 2.0, 3.0, 5.0, 10.0, 20.0)
_WITH_OTHER_BOUNDS = ("fast", "compat")
_TOLD_OTHERWISE = ("fast", "fast, 300 ns")


class LadderStudy(NamedTuple):
    """What `ladder_study` returns."""

    rows: list[LadderRow]  #: the cheapest first
    bounds: list[OverLatency]  #: trackers under our scheme with other bounds
    told: list[Told]  #: trackers that were told otherwise
    missing: list[str]  #: consumers that this build does not have
    paths: list[Path]  #: files written, the document first
    taken_from_file: int  #: cases that an earlier call had finished
    seconds: float  #: of processor time, earlier calls included


def ladder_study(
    out: str | Path,
    *,
    form: str = "default",
    executor: Executor | None = None,
    workers: int | None = None,
    fresh: bool = False,
    figures: bool = True,
    command: str = "asap-study --ladder",
    on_progress: OnProgress | None = None,
) -> LadderStudy:
    """Put every consumer to the same overloading stream; write ladder.md, ladder.svg, a state file.

    Parameters
    ----------
    out, executor, workers, fresh, figures, command, on_progress
        As in `study`. What is measured by the clock runs one at a time, whatever `workers` says.
    form : {"quick", "default", "full"}
        Four consumers on a small stream; all of them with three seeds, and with five.

    Returns
    -------
    LadderStudy

    Raises
    ------
    ValueError
        There is no such form.
    """
    out = made_ready(
        out,
        form,
        executor=executor,
        workers=workers,
        fresh=fresh,
        figures=figures,
        on_progress=on_progress,
    )
    if fresh:
        (out / "ladder.jsonl").unlink(missing_ok=True)
    missing = missing_rungs()
    labels = [label for label in (_QUICK if form == "quick" else RUNGS) if label not in missing]
    size = "small" if form == "quick" else "whole"
    options: dict[str, Any] = {"executor": executor, "on_progress": on_progress}

    def ran(tasks: list[Any], workers: int | None = 1) -> Ran:
        return run(tasks, state=out / "ladder.jsonl", workers=workers, **options)

    cost_runs = ran([CostCase(label, size) for label in labels])
    costs = dict(zip(labels, cost_runs.results.of(CostCase), strict=True))
    settings = _settings(costs)
    seeds = _SEEDS[form]
    virtual = ran(_virtual(costs, settings, seeds, size), workers)
    bounds = ran(_other_bounds(costs, seeds, size), workers)
    told = ran(_told_otherwise(costs, settings, seeds, size), workers)
    real = ran(
        [LadderReplay(rung, seed, settings[rung], size) for seed in seeds for rung in labels]
    )
    rows = [
        row(
            label,
            costs[label],
            settings[label],
            _of_rung(virtual, label),
            _of_rung(real, label),
        )
        for label in labels
    ]
    rows.sort(key=lambda one: one.beta_ns)
    all_runs = (cost_runs, virtual, bounds, told, real)
    seconds = sum(one.seconds for one in all_runs)
    over, otherwise = over_latency(bounds.results), told_rows(told.results)
    drawn = [_draw(out / "ladder.svg", rows)] if figures else []
    written = document.write(
        out / "ladder.md",
        rows,
        over,
        otherwise,
        command=command,
        seconds=seconds,
        figures=drawn,
        missing=missing,
    )
    taken = sum(one.taken_from_file for one in all_runs)
    return LadderStudy(rows, over, otherwise, missing, [*written, *drawn], taken, seconds)


def _of_rung(ran: Ran, rung: str) -> list[Outcomes]:
    return [
        outcome
        for task, outcome in ran.results.pairs
        if isinstance(task, (LadderCase, LadderReplay)) and task.rung == rung
        if isinstance(outcome, Outcomes)
    ]


def _settings(costs: dict[str, Costs]) -> dict[str, dict[str, Setting]]:
    """Choose the setting of every scheme for every consumer."""
    ladder = [one.tried for one in costs.values()]
    for_all = {f"{name}, one for all": best_for_all(ladder, name) for name in BASELINES}
    return {
        label: {OURS: ours(), **{name: best(one.tried, name) for name in BASELINES}, **for_all}
        for label, one in costs.items()
    }


def _virtual(
    costs: dict[str, Costs],
    settings: dict[str, dict[str, Setting]],
    seeds: tuple[int, ...],
    size: str,
) -> list[LadderCase]:
    return [
        LadderCase(label, seed, *_on_the_slow_computer(one), settings[label], size, LATENCY_MS)
        for seed in seeds
        for label, one in costs.items()
    ]


def _other_bounds(costs: dict[str, Costs], seeds: tuple[int, ...], size: str) -> list[LadderCase]:
    return [
        LadderCase(
            label, seed, *_on_the_slow_computer(costs[label]), {OURS: ours(bound)}, size, bound
        )
        for label in _WITH_OTHER_BOUNDS
        if label in costs
        for bound in _OTHER_BOUNDS_MS
        for seed in seeds
    ]


def _told_otherwise(
    costs: dict[str, Costs],
    settings: dict[str, dict[str, Setting]],
    seeds: tuple[int, ...],
    size: str,
) -> list[ToldCase]:
    ways: tuple[Literal["nothing", "mean"], ...] = ("nothing", "mean")
    return [
        ToldCase(
            label,
            seed,
            *_on_the_slow_computer(costs[label]),
            {name: settings[label][name] for name in (OURS, *BASELINES)},
            size,
            LATENCY_MS,
            told,
        )
        for label in _TOLD_OTHERWISE
        if label in costs
        for told in ways
        for seed in seeds
    ]


def _on_the_slow_computer(costs: Costs) -> tuple[float, float]:
    return costs.alpha_us * SLOWDOWN, costs.beta_ns * SLOWDOWN


def _draw(path: Path, rows: list[LadderRow]) -> Path:
    from asap import plots
    from asap_laboratory.ladder import figures

    path.write_text(plots.svg(figures.figure(rows)), encoding="utf-8")
    return path
