"""The cluster tracker beside its rivals as one table: scene by scene, a row for each."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from asap.accuracy import KeepCurve
from asap.results import accuracy_table
from asap_laboratory.accuracy.document import label_of
from asap_laboratory.document import origin
from asap_laboratory.rivals.cases import OURS
from asap_laboratory.tables import markdown

__all__ = ["beside_prototypes", "table", "verdict", "write"]

_OPENING = """\
Does another tracker do better on the same scenes? `fast` is `asap.ClusterTracker` as it comes; its
rivals are rebuilt from their published rules, most with a noise filter in front. Each row is one
tracker on one scene: MOTA (1 means no error), switches of ids per run, error of position and
velocity, and processor time per event. All scenes are synthetic, and every design was tuned on
scenes of this kind."""

_HOW_TO_READ = """\
`fast` is `asap.ClusterTracker` as it comes, nothing in front. BAF is
`asap.BackgroundActivityFilter` with 5 ms. "jAER-type core" is the rules of jAER's
RectangularClusterTracker, built anew and with an index, so that the number of boxes costs it
nothing (jAER itself was not run); "compat steady" is the published rule (ICRA 2020) with S 2000,
R 20, no probes, alpha .05. Protocol as in
[accuracy.md](accuracy.md), all events kept; a cell is the mean over the seeds with the standard
deviation. "Ahead" counts the seeds on which `fast` has the higher MOTA, the same, and the lower.
ns: filter and tracker, processor time per event that enters, median of three turns in which each
takes the scene after the other. All scenes are synthetic, and each design was tuned on scenes of
this kind."""

_PROTOTYPES = """\
Is each rival what it should be? Mean MOTA as above, in parentheses that of the prototypes which the
designs come from, on scenes of the same recipe from another generator: one seed with *, else three
to ten."""

_MOTA_OF_PROTOTYPES = {
    "fast": "1.000 .990 .998 1.000 .973 .909 .998",
    "jAER-type core": ".984* .978* .769* -1.199* .877*",
    "BAF + jAER-type core": ".996* .998* .824 .941* .896",
    "BAF + compat steady": ".984* .977* .916 .963* .836",
}


def write(path: Path, curves: Sequence[KeepCurve], *, command: str, seconds: float) -> None:
    """Write the document.

    Parameters
    ----------
    path : Path
        A Markdown file; its folder exists.
    curves : sequence of KeepCurve
        What was measured.
    command : str
        What has to be typed to get the same.
    seconds : float
        Processor time of all runs.
    """
    parts = [
        "# The cluster tracker beside its rivals",
        _OPENING,
        verdict(curves),
        f"{origin(command, seconds)}.",
        _HOW_TO_READ,
        table(curves),
        "## Beside the prototypes",
        _PROTOTYPES,
        beside_prototypes(curves),
    ]
    path.write_text("\n\n".join(parts) + "\n", encoding="utf-8")


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
            f"{ours} ({prototype})" if prototype else ours
        )
    return markdown(
        ("", *scenes),
        [(label, *(cells.get(scene, "") for scene in scenes)) for label, cells in rows.items()],
    )


def verdict(curves: Sequence[KeepCurve]) -> str:
    """Say, in a sentence, where a rival has the higher mean MOTA."""
    lost = []
    for curve in curves:
        ours, theirs = _ours(curves, curve.scene).rows[0], curve.rows[0]
        if theirs.mean["mota"] > ours.mean["mota"]:
            by = theirs.mean["mota"] - ours.mean["mota"]
            lost.append(f"{label_of(curve)} on {curve.scene} (by {by:.4f})".replace("0.", "."))
    if not lost:
        return "No rival has a higher mean MOTA on any scene."
    return f"Higher mean MOTA than `{OURS}`: {', '.join(lost)}."


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
