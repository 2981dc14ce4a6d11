"""The tracker on recordings with boxes: what it got wrong, table, page of overlays, command."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from asap import _core
from asap_laboratory import score
from asap_laboratory.accuracy import Rung
from asap_laboratory.cli import main
from asap_laboratory.page import Writer
from asap_laboratory.real.mistakes import mistakes
from asap_laboratory.rivals.recordings import CELLS, HEAD, Followed, followed, opened
from asap_laboratory.scenes import labelled
from event_files import recording
from labelled_folders import T0_US, folder

DTYPE = _core.ClusterTracker(8, 8).clusters.dtype


class Told:
    """Says (id, x, y) at each ms after T0_US; every cluster has axes of 6 and 3 px at 1.5 sigma."""

    def __init__(self, clusters: dict[int, list[tuple[int, float, float]]]) -> None:
        self._clusters = clusters

    def process(self, events: Any, labels: bool = True) -> None:
        pass

    def clusters_at(self, t_us: int) -> Any:
        table = np.zeros(len(rows := self._clusters.get((t_us - T0_US) // 1000, [])), DTYPE)
        for name, column in zip(("id", "x", "y"), np.array(rows).reshape(-1, 3).T, strict=True):
            table[name] = column
        table["cxx"], table["cyy"] = 16, 4
        return table


def followed_by(
    path: Path, clusters: dict[int, list[tuple[int, float, float]]], **others: Any
) -> Followed:
    rung = Rung(lambda width, height: Told(clusters))
    return followed(rung, labelled(folder(path, **others)))


#: Right at 10 ms, another id and two more clusters at 20 ms, nothing at 30 ms.
CLUSTERS = {10: [(7, 20, 20)], 20: [(8, 20, 20), (9, 80, 60), (5, 24, 20)]}


def cells(one: Followed) -> list[str]:
    """What the table says: hit to MOTA."""
    row = {name: None if value != value else value for name, value in one.figures.items()}
    return [Writer(CELLS).cell(row, name) for name in [*HEAD][1:-1]]


# ---- words ----------------------------------------------------------------------------------


def test_every_mistake_is_named_with_its_time(tmp_path: Path) -> None:
    assert mistakes(followed_by(tmp_path, CLUSTERS)) == [
        "object 0 is missed at 1 of 3 times, at 0.03 s",
        "object 0 changes from id 7 to id 8 at 0.02 s",
        "id 9 is false at 1 time, at 0.02 s, near (80, 60): off every box",
        "id 5 is false at 1 time, at 0.02 s, near (24, 20): a second cluster in the box of "
        "object 0",
    ]


def test_an_unlabelled_background_has_no_false_clusters(tmp_path: Path) -> None:
    one = followed_by(tmp_path, CLUSTERS, background="unlabelled")
    assert not any("false" in words for words in mistakes(one))
    assert cells(one)[:2] == [".667", "not judged"]


# ---- the table ------------------------------------------------------------------------------


def test_the_figures_are_those_of_score(tmp_path: Path) -> None:
    one = followed_by(tmp_path, CLUSTERS)
    scored = score(Told(CLUSTERS), one.scene)
    for name in ("hit", "precision", "switches", "longest", "error", "iou", "mota"):
        assert one.figures[name] == scored[name]
    assert cells(one) == [".667", ".500", "1", ".333", "0.0", ".490", "-.333"]


# ---- folders and the command ----------------------------------------------------------------


def sets(path: Path) -> Path:
    """Two recordings in a folder; the second has no boxes."""
    for name, rows in (("first", ""), ("second", "#t_us,theta_rad\n")):
        (path / name).mkdir()
        folder(path / name, rows)
    return path


def test_a_folder_of_recordings_leaves_out_what_is_refused(tmp_path: Path) -> None:
    scenes, left_out = opened([sets(tmp_path)])
    assert [path.name for path in scenes] == ["first"]
    assert len(left_out) == 1 and left_out[0].startswith("second/truth.csv: no column")
    assert list(opened([tmp_path / "first"]).scenes) == [tmp_path / "first"]


def test_command_prints_the_table_and_writes_page_and_figures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert main(["--real", str(sets(tmp_path)), "--out", str(out)]) == 0
    printed, told = capsys.readouterr()
    assert printed.startswith(
        "| set | hit | precision | switches | longest | error px | IoU | MOTA |"
    )
    assert "| first | .000 | - | 0 | .000 | - | - | .000 |" in printed
    assert printed.endswith(
        f"wrote {out / 'real.md'}\nwrote {out / 'data' / 'real.csv'}\n"
        f"wrote {out / 'real_first.svg'}\n"
    )
    assert "left out: second/truth.csv: no column" in told
    assert (out / "data" / "real.csv").read_text().startswith("set,hit,precision,switches,")
    text = (out / "real.md").read_text()
    assert f"`asap-study --real {tmp_path.name}`" in text and "![first](real_first.svg)" in text
    assert "Left out: second/truth.csv: no column" in text
    assert "**first**\n\n- object 0 is missed at 3 of 3 times, between 0.01 and 0.03 s" in text


def test_command_without_recordings_says_what_to_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("ASAP_TEST_DATA", str(tmp_path))
    assert main(["--real", "--out", str(tmp_path / "out")]) == 3
    assert "give their folders, or set ASAP_TEST_DATA" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


# ---- recordings outside the project ---------------------------------------------------------


def test_the_page_of_the_labelled_recordings(tmp_path: Path) -> None:
    assert main(["--real", str(recording("labelled")), "--out", str(tmp_path)]) == 0
    assert len(list(tmp_path.glob("real_*.svg"))) >= 5
