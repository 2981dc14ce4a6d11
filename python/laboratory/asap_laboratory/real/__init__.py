"""The cluster tracker on recordings with boxes: a table, overlays, what went wrong."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from asap_laboratory.page import Rows, Tables, distinct, only
from asap_laboratory.real.mistakes import mistakes
from asap_laboratory.rivals.recordings import CELLS, HEAD, Followed, RecordingCase, followed
from asap_laboratory.rivals.trackers import OURS, RIVALS
from asap_laboratory.scenes import LabelledScene
from asap_laboratory.study import Batch, Study

__all__ = ["RealCase", "real_study"]

_FIGURES = (*(name.removeprefix("box_") for name in HEAD),)


@dataclass(frozen=True)
class RealCase(RecordingCase):
    """Our tracker on one recording, and what it got wrong."""

    labels: tuple[str, ...] = (OURS,)

    def rows(self, found: dict[str, Followed]) -> Rows:
        """Return the figures, and a row for each kind of mistake."""
        one = found[OURS]
        wrong = mistakes(one) or ["Nothing."]
        told = [{"kind": "mistake", "set": one.scene.name, "words": words} for words in wrong]
        return [*super().rows(found), *told]


def real_study(scenes: dict[Path, LabelledScene], left_out: Sequence[str], command: str) -> Study:
    """Make the study of recordings by their folders, as `opened` returns them.

    `left_out`: why other recordings are not among them. Both it and `command` stand on the page.
    """

    def batches(form: str) -> Generator[Batch, Rows, None]:
        yield Batch([RealCase(str(folder.resolve())) for folder in scenes], one_at_a_time=True)

    def figures(tables: Tables) -> dict[str, Any]:
        from asap_laboratory.real import overlays

        return {
            f"real_{scene.name}": overlays.draw(followed(RIVALS[OURS], scene))
            for scene in scenes.values()
        }

    def facts(tables: Tables) -> dict[str, Any]:
        return {"head": HEAD, "names": distinct(tables["real"], "set"), "left_out": left_out}

    return Study(
        name="real",
        command=command,
        template=Path(__file__).with_name("page.md"),
        batches=batches,
        summary=_summary,
        tables=("real", "mistakes"),
        cells=CELLS,
        figures=figures,
        facts=facts,
        shown=lambda tables, writer: writer.listing(tables["real"], HEAD),
    )


def _summary(rows: Rows) -> Tables:
    figures = [{name: row[name] for name in _FIGURES} for row in only(rows, kind="recording")]
    wrong = [{"set": row["set"], "words": row["words"]} for row in only(rows, kind="mistake")]
    return {"real": figures, "mistakes": wrong}
