"""The tables of a study: put together over seeds, kept as CSV, written as Markdown."""

import math

import pytest

from asap_laboratory.page import (
    Writer,
    distinct,
    only,
    over_seeds,
    read_tables,
    write_tables,
)

ROWS = [
    {"scene": scene, "gamma": gamma, "seed": seed, "mota": seed + gamma, "odd": odd}
    for scene in "AB"
    for gamma in (1.0, 0.5)
    for seed, odd in ((1, 1.0), (2, None), (3, math.nan))
]


def test_rows_are_chosen_by_their_values():
    assert only(ROWS, scene="A", gamma=0.5, seed=(1, 3)) == [ROWS[3], ROWS[5]]
    assert only(ROWS, nothing=None) == ROWS and only(ROWS, nothing=1) == []
    assert distinct(ROWS, "gamma") == [1.0, 0.5]


def test_seeds_are_put_together_and_a_figure_exists_where_all_have_it():
    found = over_seeds(ROWS, ("scene", "gamma"), ("mota", "odd"))
    assert [(row["scene"], row["gamma"], row["seeds"]) for row in found] == [
        *(("A", 1.0, 3), ("A", 0.5, 3)),
        *(("B", 1.0, 3), ("B", 0.5, 3)),
    ]
    assert (found[1]["mota"], found[1]["mota_sd"]) == (2.5, 1.0)
    assert found[1]["odd"] is found[1]["odd_sd"] is None
    (one,) = over_seeds(ROWS[:1], ("scene",), ("mota",))
    assert (one["mota"], one["mota_sd"]) == (2.0, None)


def test_tables_come_back_from_their_files(tmp_path):
    rows = [
        {"label": "a, b", "told": True, "gone": None, "nan": math.nan, "value": 1 / 3, "count": 7},
        {"label": "1e", "told": False, "late": 2.5},
    ]
    paths = write_tables(tmp_path, "study", {"study": rows, "more": []})
    assert [path.name for path in paths] == ["study.csv", "study_more.csv"]
    found = read_tables(tmp_path, "study", ("study", "more"))
    absent = {"gone": None, "nan": None}
    assert found == {
        "study": [
            {**absent, "label": "a, b", "told": True, "value": 0.333333, "count": 7, "late": None},
            {**absent, "label": "1e", "told": False, "value": None, "count": None, "late": 2.5},
        ],
        "more": [],
    }


def test_a_template_that_asks_for_what_is_not_there_is_refused(tmp_path):
    (tmp_path / "page.md").write_text("{{ only(rows, scene='A') | length }} {{ origin(run) }}")
    run = {"command": "typed", "date": "today", "version": "1", "machine": "m", "minutes": 1.25}
    text = Writer({}).page(tmp_path / "page.md", rows=ROWS, run=run)
    assert text == "6 `typed`, today, asap 1, m; 1.2 minutes of processor time"
    with pytest.raises(Exception, match="'run' is undefined"):
        Writer({}).page(tmp_path / "page.md", rows=ROWS)
