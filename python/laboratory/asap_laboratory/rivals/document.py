"""The cluster tracker beside its rivals as a document: accuracy, processor time, recordings."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from asap_laboratory import writer
from asap_laboratory.accuracy.document import label_of, rows_of
from asap_laboratory.real.document import HEAD, figure_cells
from asap_laboratory.rivals.cases import OURS
from asap_laboratory.scoring import KeepCurve
from asap_laboratory.scoring import table as accuracy_table
from asap_laboratory.tables import markdown

NO_RECORDINGS = "Not measured: no labelled recordings were here."

_OPENING = """\
Does another tracker do better on the same events? `fast` is `asap.ClusterTracker` as it comes; its
rivals are rebuilt from their published rules, two with a noise filter in front. MOTA is 1 where a
tracker makes no error; processor time is that of filter and tracker for an event that enters. The
scenes A to K are [synthetic](scenes.md), with seeds on which nothing was chosen; the recordings
have boxes drawn by hand."""

_TRACKERS = (
    ("fast", "`asap.ClusterTracker`"),
    (
        "frames",
        "images of 10 or 20 ms: pixels with an event and two or three neighbours, their connected "
        "components, Kalman filters, Hungarian method (EBBIOT 2019, SORT 2016); scipy, called from "
        "Python",
    ),
    ("compat", "the published rule (ICRA 2020) as its launch file sets it"),
    ("compat steady", "the same with S 2000, R 20, no probes, alpha .05"),
    (
        "jAER-type core",
        "the rules of jAER's RectangularClusterTracker, built anew and with an index, so that the "
        "number of boxes costs it nothing (jAER itself was not run)",
    ),
    ("BAF +", "`asap.BackgroundActivityFilter` with 5 ms in front"),
)

_ACCURACY = """\
MOTA, mean over the seeds; bold: the best. Protocol as in [accuracy.md](accuracy.md), all events
kept. Each design was tuned on scenes of this kind, none on these seeds; the constants of the frames
on seed 0 of A, C, D, E, H, I and J."""

_COST = """\
ns of processor time per event, mean over the seeds of the median of three turns in which each takes
the scene after the other. Frames cost by the image, so by the event they are dear where events are
few."""

_RECORDINGS = """\
As `asap-study --real` scores: a box is hit when the centre of a cluster lies inside or up to 2 px
beyond. The recordings belong to third parties and are not distributed."""

_DETAILS = """\
A cell is the mean over the seeds with the standard deviation. "Ahead" counts the seeds on which
`fast` has the higher MOTA, the same, and the lower."""

_PROTOTYPES = """\
Is each rival what it should be? Mean MOTA as above, in parentheses that of the prototypes which the
designs come from, or of an independent check, on scenes of the same recipe from another generator:
one seed with *, else three to ten."""

_MOTA_OF_PROTOTYPES = {
    "fast": "1.000 .990 .998 1.000 .973 .909 .998",
    "frames 10 ms": ".944 - .853 .949 .797 .626 .810",
    "frames 20 ms": "- - .850 - .760 .660 -",
    "compat": ".451 .393 .756 .006 .329",
    "BAF + compat steady": ".984* .977* .916 .963* .836",
    "jAER-type core": ".984* .978* .769* -1.199* .877*",
    "BAF + jAER-type core": ".996* .998* .824 .941* .896",
}

Recordings = Mapping[str, Mapping[str, Mapping[str, float]]]


def write(
    path: Path,
    curves: Sequence[KeepCurve],
    recordings: Recordings,
    *,
    command: str,
    seconds: float,
    figure: Path | None = None,
) -> list[Path]:
    """Write the document and its data; return their paths.

    Parameters
    ----------
    path, command, seconds
        As in `writer.write`.
    curves : sequence of KeepCurve
        What was measured on scenes.
    recordings : mapping
        Figures by recording and tracker; empty where there are none.
    figure : Path, optional
        Beside the document.
    """
    on_recordings = [_RECORDINGS, recordings_table(recordings)] if recordings else [NO_RECORDINGS]
    picture = [f"![MOTA and processor time of every tracker]({figure.name})"] if figure else []
    sections = [
        markdown(("tracker", "rule"), _TRACKERS, numbers=False),
        "## Accuracy on scenes",
        _ACCURACY,
        accuracy(curves),
        "## Processor time",
        _COST,
        cost(curves),
        "## Recordings",
        *on_recordings,
        "## Every figure",
        _DETAILS,
        table(curves),
        "## Beside the prototypes",
        _PROTOTYPES,
        beside_prototypes(curves),
    ]
    with_boxes = [
        {"algorithm": label, "scene": recording, **figures}
        for recording, by_label in recordings.items()
        for label, figures in by_label.items()
    ]
    return writer.write(
        path,
        "The cluster tracker beside its rivals",
        _OPENING,
        sections,
        [*rows_of(curves), *with_boxes],
        command=command,
        seconds=seconds,
        notes=f"; {_seeds(curves)} of every scene",
        lead=[*picture, verdict(curves)],
    )


def accuracy(curves: Sequence[KeepCurve]) -> str:
    """Write mean MOTA: scenes by trackers, the best in bold, as Markdown."""
    best: dict[str, float] = {}
    for curve in curves:
        here = curve.rows[0].mean["mota"]
        best[curve.scene] = max(here, best.get(curve.scene, here))

    def cell(curve: KeepCurve) -> str:
        words = accuracy_table.cell(curve.rows[0], "mota").partition("±")[0]
        near = best[curve.scene] - curve.rows[0].mean["mota"] < 0.0005
        return f"**{words}**" if near else words

    return _by_scene(curves, cell)


def cost(curves: Sequence[KeepCurve]) -> str:
    """Write mean ns per event: scenes by trackers, as Markdown."""
    return _by_scene(curves, lambda curve: f"{curve.rows[0].mean['ns_per_event']:.0f}")


def _by_scene(curves: Sequence[KeepCurve], cell: Callable[[KeepCurve], str]) -> str:
    labels = list(dict.fromkeys(label_of(curve) for curve in curves))
    rows: dict[str, dict[str, str]] = {}
    for curve in curves:
        rows.setdefault(curve.scene, {})[label_of(curve)] = cell(curve)
    return markdown(
        ("scene", *labels),
        [
            (scene.replace("_", " "), *(cells.get(label, "") for label in labels))
            for scene, cells in rows.items()
        ],
    )


def recordings_table(recordings: Recordings) -> str:
    """Write one row for each recording and tracker, as Markdown."""
    return markdown(
        ("", *HEAD),
        [
            (label, recording, *figure_cells(figures, judged=not math.isnan(figures["mota"])))
            for recording, by_label in recordings.items()
            for label, figures in by_label.items()
        ],
    )


def _seeds(curves: Sequence[KeepCurve]) -> str:
    seeds = sorted({one.seed for curve in curves for one in curve.scored})
    return f"seeds {seeds[0]} to {seeds[-1]}" if len(seeds) > 1 else f"seed {seeds[0]}"


def table(curves: Sequence[KeepCurve]) -> str:
    """Write one row for each scene and tracker, as Markdown.

    Parameters
    ----------
    curves : sequence of KeepCurve
        The trackers of a scene one after the other.
    """
    return markdown(
        ("", "scene", "seeds", "MOTA", "ahead", "switches", "position px", "velocity", "ns"),
        [_line(curve, _ours(curves, curve.scene)) for curve in curves],
    )


def beside_prototypes(curves: Sequence[KeepCurve]) -> str:
    """Write mean MOTA, that of the prototype in parentheses: trackers by scenes, as Markdown."""
    scenes = list(dict.fromkeys(curve.scene for curve in curves))
    rows: dict[str, dict[str, str]] = {}
    for curve in curves:
        known = _MOTA_OF_PROTOTYPES.get(label_of(curve), "").split()
        prototype = dict(zip("ABCDEFG", known, strict=False)).get(curve.scene)
        ours = accuracy_table.cell(curve.rows[0], "mota").partition("±")[0]
        rows.setdefault(label_of(curve), {})[curve.scene] = (
            f"{ours} ({prototype})" if prototype not in (None, "-") else ours
        )
    return markdown(
        ("", *scenes),
        [(label, *(cells.get(scene, "") for scene in scenes)) for label, cells in rows.items()],
    )


def verdict(curves: Sequence[KeepCurve]) -> str:
    """Say, in a sentence, on which scenes a rival has the higher mean MOTA: the best there."""
    lost = []
    for scene in dict.fromkeys(curve.scene for curve in curves):
        best = max(
            (curve for curve in curves if curve.scene == scene),
            key=lambda curve: curve.rows[0].mean["mota"],
        )
        by = best.rows[0].mean["mota"] - _ours(curves, scene).rows[0].mean["mota"]
        if by > 0:
            words = f"{label_of(best)} on {scene.replace('_', ' ')} (by {by:.2f})"
            lost.append(words.replace("(by 0.", "(by ."))
    if not lost:
        return "No rival has a higher mean MOTA on any scene."
    return f"Higher mean MOTA than `{OURS}`, the best on each scene: {', '.join(lost)}."


def _ours(curves: Sequence[KeepCurve], scene: str) -> KeepCurve:
    return next(one for one in curves if one.scene == scene and label_of(one) == OURS)


def _line(curve: KeepCurve, ours: KeepCurve) -> tuple[str, ...]:
    row = curve.rows[0]
    return (
        label_of(curve),
        curve.scene,
        str(row.seeds),
        accuracy_table.cell(row, "mota"),
        "" if curve is ours else _ahead(ours, curve),
        *(accuracy_table.cell(row, name) for name in ("id_switches", "position_rms")),
        accuracy_table.cell(row, "velocity_rms"),
        f"{row.mean['ns_per_event']:.0f}",
    )


def _ahead(ours: KeepCurve, theirs: KeepCurve) -> str:
    """Seeds with a higher, the same and a lower MOTA than the rival's."""
    rival = {one.seed: one.figures["mota"] for one in theirs.scored}
    by = [one.figures["mota"] - rival[one.seed] for one in ours.scored]
    return f"{sum(d > 0 for d in by)} / {sum(d == 0 for d in by)} / {sum(d < 0 for d in by)}"
