import html
import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest

from fake_run import empty_run, fake_run

pytest.importorskip("matplotlib")

from asap import analysis, plots
from asap.report import page, run_report
from asap.results import run_table


class Page(HTMLParser):
    """Collects tags and checks that every one of them is closed in order."""

    VOID = ("meta", "link", "img", "br", "hr", "input")

    def __init__(self, text):
        super().__init__()
        self.tags, self.open = [], []
        self.feed(text)
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


@pytest.fixture(scope="module")
def run():
    return fake_run(duration_s=0.5, rejected=3, stale=40, overflow=2, pending=11)


@pytest.fixture
def write(tmp_path):
    def write_and_read(runs, **options):
        return run_report.write(runs, tmp_path / "report.html", **options).read_text("utf-8")

    return write_and_read


@pytest.fixture(scope="module")
def text(run, tmp_path_factory):
    """The page about one run."""
    return run_report.write(run, tmp_path_factory.mktemp("page") / "report.html").read_text("utf-8")


@pytest.fixture(scope="module")
def text_of_two(run, tmp_path_factory):
    """The page about two runs."""
    path = tmp_path_factory.mktemp("page") / "report.html"
    return run_report.write([run, fake_run(duration_s=0.1)], path).read_text("utf-8")


def test_the_page_forbids_everything_from_outside_and_asks_for_nothing(text_of_two):
    page = Page(text_of_two)
    policies = [
        attributes["content"]
        for tag, attributes in page.tags
        if attributes.get("http-equiv") == "Content-Security-Policy"
    ]
    assert policies == ["default-src 'none'; style-src 'unsafe-inline'; img-src data:"]
    tags = {tag for tag, _ in page.tags}
    assert not tags & {
        "script",
        "link",
        "iframe",
        "object",
        "img",
        "image",
        "base",
        "foreignobject",
    }
    for tag, attributes in page.tags:
        for name, value in attributes.items():
            assert not name.startswith("on"), (tag, name)
            if name in ("href", "xlink:href", "src", "action"):
                assert value.startswith("#"), (tag, value)
    without_namespaces = re.sub(r'xmlns(:\w+)?="[^"]*"', "", text_of_two)
    assert not re.search(r"(https?:)?//\w", without_namespaces)
    assert "@import" not in text_of_two and "<!DOCTYPE svg" not in text_of_two


def test_identifiers_are_unique_and_references_find_them(text_of_two):
    page = Page(text_of_two)
    identifiers = [attributes["id"] for _, attributes in page.tags if "id" in attributes]
    assert len(identifiers) == len(set(identifiers))
    used = [a.get("xlink:href") or a.get("href") or "" for _, a in page.tags]
    used += [
        u for _, a in page.tags for u in re.findall(r"url\((#[^)]*)\)", a.get("clip-path", ""))
    ]
    used = [reference for reference in used if reference]
    assert used and {reference[1:] for reference in used} <= set(identifiers)


def test_values_are_escaped(write):
    evil = "<img src=x onerror=alert(1)>&\"'.npy"
    text = write(fake_run(duration_s=0.1, source=evil), title="</title><script>x</script>")
    assert "<script" not in text and "<img" not in text
    assert html.escape(evil) in text
    Page(text)


def test_the_page_says_what_the_table_says(text, run):
    text = html.unescape(text).replace("\xa0", " ")
    for cause, words in run_table.LEDGER_WORDS.items():
        assert words in text and f"<td>{run.ledger[cause]:,}</td>" in text
    verdict = run_table.verdict(run)
    assert verdict.partition(". ")[2] in text
    assert "Verdict" in text


def numbers_of(text):
    found = re.findall(r"<template[^>]*>(.*?)</template>", text, flags=re.DOTALL)
    return [json.loads(html.unescape(numbers)) for numbers in found]


COLUMNS = ["size", "event_rate", "rate", "gamma", "margin_us", "latency_max_us"]


def test_the_numbers_are_embedded_as_json(text, run):
    (numbers,) = numbers_of(text)
    assert numbers["summary"] == run.summary()
    assert list(numbers["curves"]) == COLUMNS
    start_s = (run.packages["start_us"] - run.packages["t_first"][0]) / 1e6
    for name, (time_s, values) in numbers["curves"].items():
        expected = analysis.decimate(start_s, run.packages[name], 2000)
        assert time_s == pytest.approx(expected[0], abs=1e-5)
        assert values == pytest.approx(expected[1].tolist(), rel=1e-5, abs=0.01)


@pytest.fixture(scope="module")
def long_run():
    """750,000 packages, and extremes among them that a mean would hide."""
    run = fake_run(duration_s=0.5)
    rows = np.resize(run.packages, 750_000)
    rows["start_us"] = rows["t_first"][0] + np.arange(rows.size) * 37.0
    rows["latency_max_us"] *= np.random.default_rng(0).uniform(0.1, 10, rows.size)
    rows["latency_max_us"][123_456], rows["size"][654_321] = 7e6, 1_234_567
    run.packages = rows
    return run


@pytest.mark.parametrize(("count", "most", "drawn"), [(1, 10**6, 1), (2, 200_000, 1)])
def test_a_page_is_small_and_keeps_the_extremes(write, long_run, monkeypatch, count, most, drawn):
    monkeypatch.setattr(page, "MOST_BYTES", most)
    text = write([long_run] * count)
    assert len(text.encode()) <= most
    embedded = [numbers["curves"] for numbers in numbers_of(text) if "curves" in numbers]
    assert len(embedded) == drawn
    assert text.count("<figure>") == len(embedded)
    assert text.count("No curves: the page would be too large") == count - len(embedded)
    for curves in embedded:
        assert max(curves["latency_max_us"][1]) == 7e6
        assert max(curves["size"][1]) == 1_234_567


def drawn(svg):
    """Every path as its commands and coordinates."""
    paths = re.findall(r'<path [^>]*?\bd="([^"]*)"', svg, re.S)
    return [re.findall(r"[A-Za-z]|-?[\d.]+", path) for path in paths]


def test_a_short_figure_draws_the_same(run):
    figure = plots.figure(run)
    figure.set_facecolor("none")
    full, short = drawn(plots.svg(figure)), drawn(page.inline_svg(figure, "p", "wide", "words"))
    assert len(full) == len(short) > 50
    for before, after in zip(full, short, strict=True):
        for one, other in zip(before, after, strict=True):
            assert one == other or abs(float(one) - float(other)) < 0.01


def test_parameters_of_any_length_fit(write):
    run = fake_run(duration_s=0.1)
    run.algorithm.parameters = {"weights": [0.5] * 10**6, "name": "n" * 10**6, "x" * 10**6: 1}
    text = write(run)
    assert len(text.encode()) <= 1_000_000
    assert len(numbers_of(text)[0]["summary"]["algorithm"]["weights"]) == 201


@pytest.mark.parametrize(
    ("column", "written"),
    [
        ([123.456789, 0.0], [123.457, 0.0]),
        ([1234567.89], [1234568.0]),
        ([0.0123456789], [0.0123457]),
    ],
)
def test_numbers_are_embedded_with_six_digits(column, written):
    assert run_report._six_digits(np.array(column)) == written


def test_the_bar_is_made_of_what_became_of_the_events(text, run):
    pieces = set(re.findall(r'<i class="(\w+)"', text))
    assert pieces == {cause for cause, count in run.ledger.items() if count} - {"received"}


def test_several_runs_stand_side_by_side(text, text_of_two):
    assert "Side by side" in text_of_two
    assert "Side by side" not in text


def test_figures_follow_the_readers_look(text):
    assert "prefers-color-scheme:dark" in text
    figures = re.findall(r"<svg.*?</svg>", text, flags=re.DOTALL)
    assert len(figures) == 2
    colours = set(re.findall(r"(?:fill|stroke): (#\w+)", "".join(figures)))
    assert colours <= {"#000000"}, "every colour must have a name in the style sheet"


def test_the_same_run_gives_the_same_bytes(write, text, run):
    assert write([run]) == text


def test_an_empty_run_has_a_report(write):
    Page(write(empty_run()))


def test_no_run_is_an_error(tmp_path):
    with pytest.raises(ValueError, match=r"runs = \[\]: "):
        run_report.write([], tmp_path / "report.html")
