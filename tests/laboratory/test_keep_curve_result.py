"""KeepCurve has what every result has."""

from __future__ import annotations

import pytest

import test_results
from asap_laboratory import KeepCurve
from asap_laboratory.scoring.result import Scored
from test_results import (  # noqa: F401
    test_a_figure_and_a_page,
    test_a_path_is_checked_before_the_work,
    test_a_summary_is_saved,
)
from test_run_report import Page

FIGURES = {"mota": 0.9, "id_switches": 1.0, "idf1": 0.8, "hota": 0.7, "position_rms": 1.5}
FIGURES |= {"velocity_rms": 0.1, "v_measure": float("nan")}


@pytest.fixture
def result() -> KeepCurve:
    runs = [Scored(gamma, None if gamma == 1 else True, 0, FIGURES) for gamma in (1.0, 0.5)]
    return KeepCurve(test_results.EVIL, "A", None, runs)


def test_a_notebook_shows_a_table(result: KeepCurve) -> None:
    shown = result._repr_html_()
    tags = {tag for tag, _ in Page(shown).tags}
    assert "table" in tags and not {"script", "style", "img", "link"} & tags
    assert test_results.EVIL not in shown
