"""The rivals' study: the cluster tracker beside its rivals, on scenes and on recordings."""

from __future__ import annotations

from concurrent.futures import Executor
from pathlib import Path
from typing import NamedTuple

from asap._progress import OnProgress
from asap_laboratory.conduct import made_ready
from asap_laboratory.real.folders import at_hand
from asap_laboratory.results import Results
from asap_laboratory.rivals import document
from asap_laboratory.rivals.cases import RIVALS, RecordingCase, Rivalry, RivalsCase, rivals_cases
from asap_laboratory.run import run
from asap_laboratory.scoring.result import KeepCurve, Scored


class RivalsStudy(NamedTuple):
    """What `rivals_study` returns."""

    curves: list[KeepCurve]  #: one for each tracker and scene, all at gamma = 1
    recordings: dict[str, dict[str, dict[str, float]]]  #: figures by recording and tracker
    paths: list[Path]  #: files written, the document first
    taken_from_file: int  #: cases that an earlier call had finished
    seconds: float  #: of processor time, earlier calls included


def rivals_study(
    out: str | Path,
    *,
    form: str = "default",
    executor: Executor | None = None,
    workers: int | None = None,
    fresh: bool = False,
    figures: bool = True,
    command: str = "asap-study --rivals",
    on_progress: OnProgress | None = None,
) -> RivalsStudy:
    """Score and time the cluster tracker and its rivals; write rivals.md, a figure, a state file.

    Parameters
    ----------
    out, executor, workers, fresh, figures, command, on_progress
        As in `study`; progress is in millionths of about a second.
    form : {"quick", "default", "full"}
        A and E with one seed; A to K with the seeds 1000 to 1019, and the labelled recordings that
        are here; twice as many seeds.

    Returns
    -------
    RivalsStudy

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
    folders = [] if form == "quick" else at_hand()
    ran = run(
        [*rivals_cases(form), *(RecordingCase(str(folder.resolve())) for folder in folders)],
        state=out / "rivals.jsonl",
        executor=executor,
        workers=workers,
        fresh=fresh,
        on_progress=on_progress,
    )
    curves, recordings = curves_of(ran.results), recordings_of(ran.results)
    figure = None
    if figures:
        from asap_laboratory.rivals import figures as drawing

        figure = drawing.write(out / "rivals.svg", curves, recordings)
    paths = document.write(
        out / "rivals.md", curves, recordings, command=command, seconds=ran.seconds, figure=figure
    )
    paths += [figure] if figure else []
    return RivalsStudy(curves, recordings, paths, ran.taken_from_file, ran.seconds)


def recordings_of(results: Results) -> dict[str, dict[str, dict[str, float]]]:
    """Return the figures on recordings, by recording and tracker."""
    return {
        case.recording: outcome.rivals
        for case, outcome in results.pairs
        if isinstance(case, RecordingCase) and isinstance(outcome, Rivalry)
    }


def curves_of(results: Results) -> list[KeepCurve]:
    """Put the seeds of each tracker and scene together."""
    curves: dict[tuple[str, str], KeepCurve] = {}
    for case, outcome in results.pairs:
        if not (isinstance(case, RivalsCase) and isinstance(outcome, Rivalry)):
            continue
        for label, figures in outcome.rivals.items():
            rung = RIVALS[label]
            empty = KeepCurve(rung.algorithm, case.scene, "BAF" if rung.before else None, [])
            curve = curves.setdefault((case.scene, label), empty)
            curve.scored.append(Scored(1.0, None, case.seed, figures))
    return list(curves.values())
