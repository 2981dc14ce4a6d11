"""The tracker on recordings with boxes: real.md with the table, real.html with the overlays."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from asap import _checks
from asap._progress import OnProgress
from asap_laboratory.accuracy.cases import RUNGS
from asap_laboratory.real import document
from asap_laboratory.real.following import Followed, follow
from asap_laboratory.rivals.cases import OURS
from asap_laboratory.scenes import LabelledScene


class RealStudy(NamedTuple):
    """What `real_study` returns."""

    sets: list[Followed]
    paths: list[Path]  #: files written, the document first


def real_study(
    out: str | Path,
    scenes: Sequence[LabelledScene],
    *,
    left_out: Sequence[str] = (),
    figures: bool = True,
    command: str = "asap-study --real",
    on_progress: OnProgress | None = None,
) -> RealStudy:
    """Score the cluster tracker on recordings with boxes; write real.md and real.html.

    Parameters
    ----------
    out : path
        Folder to write to; made where it does not exist.
    scenes : sequence of LabelledScene
        As `asap_laboratory.scenes.labelled` opens them.
    left_out : sequence of str
        Why other recordings are not among them; stands on the page.
    figures : bool
        Whether to write the page; needs matplotlib.
    command : str
        Named in document and page.
    on_progress : callable, optional
        Called as on_progress(done, total, None), in recordings.

    Returns
    -------
    RealStudy
    """
    folder = _checks.folder_or_file("out", out)
    _checks.flag("figures", figures)
    _checks.callback("on_progress", on_progress)
    begin_s = time.process_time()
    sets: list[Followed] = []
    for scene in scenes:
        sets.append(follow({OURS: RUNGS[OURS]}, scene)[OURS])
        if on_progress is not None:
            on_progress(len(sets), len(scenes), None)
    folder.mkdir(parents=True, exist_ok=True)
    seconds = time.process_time() - begin_s
    paths = document.write(folder / "real.md", sets, command=command, seconds=seconds)
    if figures:
        from asap_laboratory.real import page

        paths.append(page.write(folder / "real.html", sets, left_out=left_out, command=command))
    return RealStudy(sets, paths)
