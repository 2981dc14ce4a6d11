"""An inspection as figure and as page."""

import html
import json
import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import asap
import corrupt

pytest.importorskip("matplotlib")

from asap.results import page as report
from asap.results import text as text_of
from test_run_report import Page

EVENTS = corrupt.clean_events(20_000)


def inspect(events):
    return asap.check(events, width=corrupt.WIDTH, height=corrupt.HEIGHT)


@pytest.fixture(scope="module")
def inspection():
    bad = corrupt.back_steps(EVENTS, 30)
    bad["x"][::50], bad["y"][::50] = 30, 40
    bad["x"][1::50], bad["y"][1::50] = 300, 200
    return inspect(bad)


@pytest.fixture(scope="module")
def text(inspection, tmp_path_factory):
    named = replace(inspection, path="a <b> & c.npy")
    page = named.report(tmp_path_factory.mktemp("page") / "out.html").read_text("utf-8")
    return page.replace("\xa0", " ")


def circles(axes):
    return [tuple(place) for one in axes.collections for place in one.get_offsets()]


def test_the_rate_is_that_of_the_inspection(inspection):
    rate, *_ = inspection.plot().axes
    (line,) = rate.lines
    time_s, mean_hz, _ = inspection.rate_curve.T
    np.testing.assert_array_equal(line.get_xdata(), time_s)
    np.testing.assert_allclose(line.get_ydata(), mean_hz / 1e3)
    assert rate.get_ylabel() == "kev/s" and line.get_label() == "in 1 ms"


def test_a_long_recording_shows_its_peaks_too():
    events = EVENTS.copy()
    events["t"] = events["t"][0] + (events["t"] - events["t"][0]) * 300
    inspection = inspect(events)
    rate, *_ = inspection.plot().axes
    assert [line.get_label() for line in rate.lines] == ["largest in 1 ms", "in 2 ms"]
    assert max(rate.lines[0].get_ydata()) * 1e3 == pytest.approx(inspection.rate_peak_1ms_hz)


def test_the_intervals_are_those_of_the_inspection(inspection):
    intervals = inspection.plot().axes[1]
    counts = np.trim_zeros(inspection.interval_counts, "b")
    heights = [bar.get_height() for bar in intervals.patches]
    np.testing.assert_allclose(heights, 100 * counts / (inspection.events - 1))
    assert intervals.get_xticklabels()[0].get_text() == "0 us"


def test_labels_of_the_intervals_do_not_meet(inspection):
    counts = np.zeros_like(inspection.interval_counts)
    counts[:15] = 1
    spread = replace(inspection, interval_counts=counts)
    page = spread.plot()
    page.draw_without_rendering()
    boxes = [label.get_window_extent() for label in page.axes[1].get_xticklabels()]
    assert len(boxes) >= 5
    assert all(a.x1 < b.x0 for a, b in pairwise(boxes))


def test_hot_pixels_have_circles(inspection):
    pixels = inspection.plot().axes[2]
    assert sorted(circles(pixels)) == [(30, 40), (300, 200)]
    assert pixels.get_title(loc="left") == "hot pixels: 2, with 4.0 % of the events"
    (picture,) = pixels.images
    np.testing.assert_array_equal(picture.get_array().filled(0), inspection.pixel_counts)
    assert pixels.get_ylim() == (259.5, -0.5)  # y down


def test_none_is_hot():
    pixels = inspect(EVENTS).plot().axes[2]
    assert circles(pixels) == []
    assert pixels.get_title(loc="left") == "hot pixels: none"


def test_the_bar_beside_the_map_is_as_high_and_shows_its_ends():
    few = inspect(EVENTS[:500])
    page = few.plot()
    page.canvas.draw()
    (bar,) = page.axes[2].child_axes
    assert bar.get_window_extent().height == pytest.approx(page.axes[2].bbox.height)
    assert 1 < few.pixel_counts.max() < 10
    assert bar.get_yticks().tolist() == [1, few.pixel_counts.max()]


def test_nothing_can_be_drawn_as_well(tmp_path):
    for nothing in (inspect(EVENTS[:0]), asap.check(EVENTS[:0])):
        Page(nothing.report(tmp_path / "out.html").read_text("utf-8"))


def test_the_page_is_closed_and_escaped(text):
    page = Page(text)
    assert "a &lt;b&gt; &amp; c.npy" in text and "<b> & c" not in text
    assert not [tag for tag, _ in page.tags if tag in ("script", "link", "iframe")]
    assert text.count("<img ") == 1


def test_every_check_has_a_line(text, inspection):
    for name, finding in inspection.findings.items():
        head = f'<th scope="row">{name.replace("_", " ")}</th>'
        assert f"<tr>{head}<td>{finding.count}</td><td>{finding.verdict}</td>" in text
    plain = html.unescape(text)
    for words in text_of.CHECKS.values():
        assert words in plain
    for finding in inspection.findings.values():
        assert finding.remedy in plain


def test_the_numbers_are_those_of_the_summary(text, inspection):
    (numbers,) = re.findall(r"<template data-inspection>(.*?)</template>", text, re.S)
    expected = replace(inspection, path="a <b> & c.npy").summary()
    assert json.loads(html.unescape(numbers)) == json.loads(json.dumps(expected))


def test_shares_of_the_busiest_pixels_are_of_the_good_events(tmp_path):
    events = EVENTS[:1000].copy()
    events["x"][:500], events["x"][500:], events["y"] = corrupt.WIDTH, 7, 7
    text = inspect(events).report(tmp_path / "x.html").read_text("utf-8").replace("\xa0", " ")
    assert '<th scope="row">x = 7, y = 7</th><td>500</td><td>100.0 %</td>' in text


def test_what_is_said_about_runs_is_not_said_here(text, tmp_path):
    assert "gamma" not in re.sub(r"<style>.*?</style>", "", text, flags=re.S)
    inspection = inspect(EVENTS)
    path = report.write_inspection(inspection, tmp_path / "x.html", title="1 < 2")
    assert path == tmp_path / "x.html"
    assert "<title>1 &lt; 2</title>" in path.read_text("utf-8")
