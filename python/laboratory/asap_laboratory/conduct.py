"""The whole study: run what is missing, judge, write tables and figures."""

from __future__ import annotations

from concurrent.futures import Executor
from pathlib import Path
from typing import NamedTuple

from asap import _checks
from asap._progress import OnProgress
from asap_laboratory import document
from asap_laboratory.cases import FORMS, cases
from asap_laboratory.goals import Goal, goals
from asap_laboratory.probes import probes
from asap_laboratory.results import Results
from asap_laboratory.run import run


class Study(NamedTuple):
    """What `study` returns."""

    goals: list[Goal]
    results: Results
    paths: list[Path]  #: files written, the document first
    taken_from_file: int  #: measurements that an earlier call had finished
    seconds: float  #: of processor time, earlier calls included

    @property
    def holds(self) -> bool:
        """Whether no goal was missed."""
        return all(goal.holds is not False for goal in self.goals)


def made_ready(
    out: str | Path,
    form: str,
    *,
    executor: Executor | None,
    workers: int | None,
    fresh: bool,
    figures: bool,
    on_progress: OnProgress | None,
) -> Path:
    """Check what every kind of study is asked for, and make its folder."""
    folder = _checks.folder_or_file("out", out)
    _checks.choice("form", form, FORMS)
    if executor is not None and not hasattr(executor, "submit"):
        raise TypeError(_checks.named("executor", executor, "give a concurrent.futures.Executor"))
    if workers is not None:
        _checks.whole("workers", workers, 1, 10_000, "give at least 1")
    _checks.flag("fresh", fresh)
    _checks.flag("figures", figures)
    _checks.callback("on_progress", on_progress)
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def study(
    out: str | Path,
    *,
    form: str = "default",
    executor: Executor | None = None,
    workers: int | None = None,
    fresh: bool = False,
    figures: bool = True,
    command: str = "asap-study",
    on_progress: OnProgress | None = None,
) -> Study:
    """Compare all schemes over profiles and cost models; write study.md, figures and a state file.

    Parameters
    ----------
    out : path
        Folder to write to; made where it does not exist. What it holds of an earlier call with the
        same build of the library is not run again.
    form : {"quick", "default", "full"}
        Less than 2, 30, 90 minutes on two cores; up to 1, 1.5, 3 GB of memory per process.
    executor : concurrent.futures.Executor, optional
        Where the cases run; a pool of processes unless given. A script that leaves it out needs
        ``if __name__ == "__main__":``.
    workers : int, optional
        Processes of that pool; as many as there are processors unless given.
    fresh : bool
        Run everything again.
    figures : bool
        Whether to draw; needs matplotlib.
    command : str
        Named in the document.
    on_progress : callable, optional
        Called as on_progress(done, total, None), in simulated events.

    Returns
    -------
    Study

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
        [*cases(form), *probes(form)],
        state=out / "state.jsonl",
        executor=executor,
        workers=workers,
        fresh=fresh,
        on_progress=on_progress,
    )
    judged = goals(ran.results)
    drawn: list[Path] = []
    if figures:
        from asap_laboratory import figures as drawing

        drawn = drawing.write(out, ran.results)
    written = document.write(
        out / "study.md",
        ran.results,
        judged,
        form=form,
        command=command,
        seconds=ran.seconds,
        figures=drawn,
    )
    return Study(judged, ran.results, [*written, *drawn], ran.taken_from_file, ran.seconds)
