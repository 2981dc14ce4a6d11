"""The accuracy study: every algorithm with a score over scenes and gammas; tables and figures."""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import Executor
from pathlib import Path
from typing import NamedTuple

from asap._progress import OnProgress
from asap_laboratory.accuracy import document
from asap_laboratory.accuracy.cases import (
    RUNGS,
    Accuracy,
    AccuracyCase,
    accuracy_cases,
    missing_rungs,
)
from asap_laboratory.conduct import made_ready
from asap_laboratory.results import Results
from asap_laboratory.run import run
from asap_laboratory.scoring import KeepCurve


class AccuracyStudy(NamedTuple):
    """What `accuracy_study` returns."""

    curves: list[KeepCurve]  #: one for each algorithm and scene
    missing: list[str]  #: algorithms that this build does not have
    paths: list[Path]  #: files written, the document first
    taken_from_file: int  #: cases that an earlier call had finished
    seconds: float  #: of processor time, earlier calls included


def accuracy_study(
    out: str | Path,
    *,
    form: str = "default",
    executor: Executor | None = None,
    workers: int | None = None,
    fresh: bool = False,
    figures: bool = True,
    command: str = "asap-study --accuracy",
    on_progress: OnProgress | None = None,
) -> AccuracyStudy:
    """Score all algorithms over scenes and gammas; write accuracy.md, figures and a state file.

    Parameters
    ----------
    out, executor, workers, fresh, figures, command, on_progress
        As in `study`; progress is in events processed.
    form : {"quick", "default", "full"}
        Two scenes, one seed and two gammas; A to E and three seeds; A to G and ten seeds.

    Returns
    -------
    AccuracyStudy

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
    ran = run(
        list(accuracy_cases(form)),
        state=out / "accuracy.jsonl",
        executor=executor,
        workers=workers,
        fresh=fresh,
        on_progress=on_progress,
    )
    curves, missing = curves_of(ran.results), missing_rungs()
    drawn = _draw(out, curves) if figures else []
    written = document.write(
        out / "accuracy.md",
        curves,
        command=command,
        seconds=ran.seconds,
        figures=drawn,
        missing=missing,
    )
    return AccuracyStudy(curves, missing, [*written, *drawn], ran.taken_from_file, ran.seconds)


def curves_of(results: Results) -> list[KeepCurve]:
    """Put the seeds of each algorithm and scene together."""
    curves: dict[tuple[str, str], KeepCurve] = {}
    for case, outcome in results.pairs:
        if not (isinstance(case, AccuracyCase) and isinstance(outcome, Accuracy)):
            continue
        rung = RUNGS[case.rung]
        before = "BAF" if rung.before else None
        empty = KeepCurve(rung.algorithm, case.scene, before, [])
        curves.setdefault((case.rung, case.scene), empty).scored.extend(outcome.scored)
    return list(curves.values())


def _draw(folder: Path, curves: Iterable[KeepCurve]) -> list[Path]:
    from asap import plots
    from asap_laboratory.scoring import report as accuracy_report

    by_scene: dict[str, list[KeepCurve]] = {}
    for curve in curves:
        by_scene.setdefault(curve.scene, []).append(curve)
    paths = []
    for scene, some in by_scene.items():
        paths.append(folder / f"accuracy_{scene}.svg")
        page = accuracy_report.figure(some, title=f"scene {scene}")
        paths[-1].write_text(plots.svg(page), encoding="utf-8")
    return paths
