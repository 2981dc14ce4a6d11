"""A comparison as figure and as page."""

import html
import json
import re

import numpy as np
import pytest

import asap
import streams

pytest.importorskip("matplotlib")

from asap.results import figures as plots
from asap.results import page as report
from asap.results import text as text_of
from test_run_report import IMAGE, Page

COST = asap.LinearCost(alpha_us=100, beta_ns=300)
EVENTS = streams.poisson(6e6, 0.05)


@pytest.fixture(scope="module")
def comparison():
    schemes = {"greedy & co <b>": asap.Greedy(), "ours": asap.Deadline(latency_ms=5)}
    return asap.compare(EVENTS, cost=COST, schemes=schemes)


@pytest.fixture(scope="module")
def page(comparison, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "out.html"
    comparison.report(path)
    return path.read_text("utf-8")


def titles(axes):
    return axes.get_title(loc="left"), axes.get_title(loc="right")


def test_a_row_of_the_figure_for_each_scheme_best_first(comparison):
    axes = comparison.plot().axes
    assert len(axes) == 2 * (1 + 2)
    first, second = comparison.rows
    assert titles(axes[2])[0] == first.label == "ours"
    assert titles(axes[3])[0] == f"score {first.score:.3f}"
    assert titles(axes[4])[0] == second.label
    assert "p99" in titles(axes[4])[1] and "kept 100.0 %" in titles(axes[5])[1]
    assert all(axes[0].get_shared_x_axes().joined(axes[0], other) for other in axes[1:])


def test_the_curves_are_those_of_the_slots(comparison):
    axes = plots.comparison_figure(comparison, points=10).axes
    slots = comparison.runs["ours"].slots
    assert slots.size == 50
    time_s, latency_ms = axes[2].get_lines()[0].get_data()
    np.testing.assert_allclose(time_s, 0.0025 + 0.005 * np.arange(10))
    windows = slots["latency_max_us"].reshape(10, 5)
    np.testing.assert_allclose(latency_ms, windows.max(axis=1) / 1e3)
    bound = axes[2].get_lines()[1]
    assert bound.get_ydata()[0] == 5 and bound.get_label() == "bound L"
    received = slots["received"].reshape(10, 5).sum(axis=1)
    rate = axes[0].collections[0].get_paths()[0].vertices[:, 1]
    assert rate.max() == pytest.approx(received.max() / 0.005 / 1e6)
    kept = axes[3].collections[0].get_paths()[0].vertices[:, 1]
    delivered = slots["delivered"].reshape(10, 5).sum(axis=1)
    assert kept.max() == pytest.approx((delivered / received).max())


def test_late_windows_have_the_other_colour(comparison):
    axes = plots.comparison_figure(comparison).axes

    def area(collection):
        return max((path.vertices[:, 1].max() for path in collection.get_paths()), default=0.0)

    ours, greedy = axes[3].collections, axes[5].collections
    assert area(ours[0]) > 0.3 and area(ours[1]) == 0
    assert area(greedy[1]) == 1
    assert ours[0].get_label() == "kept, all in time"


def test_latencies_beyond_the_axis_stay_at_its_edge():
    found = asap.compare(EVENTS, cost=COST, schemes=[asap.SingleEvent()], latency_ms=1)
    latency = found.plot().axes[2].get_lines()[0].get_ydata()
    assert found["SingleEvent"].max_us > 1e6
    assert latency.max() == 100


def test_a_figure_and_a_page_of_nothing(tmp_path):
    empty = asap.compare(EVENTS[:0], cost=COST, schemes=[asap.Greedy()])
    assert plots.svg(empty.plot())
    text = report.write_comparison(empty, tmp_path / "x.html").read_text("utf-8")
    assert "No event was received." in text


def test_a_label_is_no_formula():
    found = asap.compare(EVENTS[:100], cost=COST, schemes={"5 $^$": asap.Greedy()})
    assert plots.svg(found.plot())


def test_the_page_is_well_formed_and_asks_for_nothing(page):
    tags = Page(page).tags
    assert not [tag for tag, _ in tags if tag in ("script", "link", "iframe")]
    links = [a[name] for _, a in tags for name in ("src", "href") if name in a]
    assert all(link.startswith(IMAGE) for link in links)
    assert "co <b>" not in page and "greedy &amp; co &lt;b&gt;" in page
    assert "default-src 'none'" in page


def test_the_page_says_what_the_table_says(page, comparison):
    text = html.unescape(re.sub(r"<[^>]*>", " ", page)).replace("\xa0", " ")
    for row in comparison.rows:
        for cell in text_of.comparison_cells(row, 5.0):
            assert cell in text
    for words in (*text_of.COLUMNS, *text_of.COLUMNS.values()):
        assert words in text
    assert text_of.comparison_subtitle(comparison) in text
    assert "overhead 0.5" in text


def test_the_numbers_are_embedded(page, comparison):
    text = re.search(r"<template data-comparison>(.*?)</template>", page, re.DOTALL)[1]
    assert json.loads(html.unescape(text)) == json.loads(json.dumps(comparison.summary()))


def test_write_returns_the_path_and_takes_a_title(comparison, tmp_path):
    path = report.write_comparison(comparison, tmp_path / "x.html", "A & B")
    assert "<h1>A &amp; B</h1>" in path.read_text("utf-8")
