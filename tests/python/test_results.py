"""What Run, Comparison and Inspection have in common."""

from __future__ import annotations

import html
import json
import re
import sys
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

import asap
import streams
from asap.results.result import Result
from fake_run import fake_run

EVENTS = streams.poisson(1e5, 0.02)
COST = asap.LinearCost(100, 300)
EVIL = "<script>&"
POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
ATTACK = "</title></template><script>alert(1)</script><img src=http://x.example/ onerror=a()>\"'&"


class Elements(HTMLParser):
    """The elements and attributes of a page, and the addresses in them."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.names: set[str] = set()
        self.attributes: list[tuple[str, str]] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.names.add(tag)
        self.attributes += [(name, value or "") for name, value in attrs]


def check_page(text: str) -> None:
    """Nothing runs, nothing is fetched, and the page says so itself."""
    page = Elements(text)
    assert ("content", POLICY) in page.attributes
    assert not page.names & {"script", "iframe", "object", "embed", "link", "base", "form"}
    for name, value in page.attributes:
        assert not name.startswith("on")
        if name in ("href", "src", "xlink:href", "action", "data"):
            assert value.startswith("data:image/svg+xml;base64,")


def compared() -> asap.Comparison:
    return asap.compare(EVENTS, cost=COST, schemes={EVIL: asap.Greedy(), "D": asap.Deadline()})


def inspected() -> asap.Inspection:
    return asap.check([EVENTS], width=16, height=12)


RESULTS: dict[type[Result], Callable[[], Any]] = {
    asap.Run: lambda: asap.simulate(EVENTS, cost=COST),
    asap.Comparison: compared,
    asap.Inspection: inspected,
}


@pytest.fixture(scope="module", params=RESULTS, ids=lambda kind: kind.__name__)
def result(request: pytest.FixtureRequest) -> Any:
    return RESULTS[request.param]()


def test_a_summary_is_saved(result: Any, tmp_path: Path) -> None:
    path = result.save(str(tmp_path / "out.json"))
    assert path == tmp_path / "out.json"
    saved = json.loads(path.read_text("utf-8"))
    summary = json.loads(json.dumps(result.summary(), allow_nan=False))
    assert saved.items() >= summary.items()
    assert summary["schema_version"] == 1
    with pytest.raises(ValueError, match=r"out\.txt': give a name that ends in \..*json"):
        result.save(tmp_path / "out.txt")


def test_a_figure_and_a_page(result: Any, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    if isinstance(result, asap.Inspection):
        pytest.skip("a table alone")
    assert result.plot().axes
    path = result.report(tmp_path / "out.html")
    assert path == tmp_path / "out.html"
    page = path.read_text("utf-8")
    check_page(page)
    assert {"table", "img", "template"} <= Elements(page).names
    assert EVIL not in page
    assert result.report(tmp_path / "again.html").read_text("utf-8") == page
    with pytest.raises(ValueError, match=r"out\.pdf': give a name that ends in \.html"):
        result.report(tmp_path / "out.pdf")


def test_every_text_of_a_run_file_is_escaped(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    attack = "javascript:alert(1)" + ATTACK + "\ud800$\\frac{"
    summary = asap.simulate(EVENTS, cost=COST).summary()
    summary["source"] |= {"path": attack, "format": attack}
    summary |= {"scheme": {"name": attack, attack: 1.0}, "rejected": {attack: 3}, "mode": attack}
    summary["algorithm"] = {"name": attack, attack: attack}
    file = tmp_path / "run.json"
    file.write_text(json.dumps(summary), errors="surrogatepass")
    check_page(asap.load_run(file).report(tmp_path / "out.html").read_text("utf-8"))


def test_the_page_of_two_runs_holds_no_markup_of_theirs_and_is_short(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    from asap.results.page import write_runs

    evil = "<img src=x onerror=alert(1)>&\"'.npy"
    runs = [fake_run(duration_s=0.1, source=evil) for _ in range(2)]
    runs[1].algorithm.parameters = {"weights": [0.5] * 10**6, "x" * 10**6: 1}
    path = write_runs(runs, tmp_path / "out.html", title="</title><script>x</script>")
    page = path.read_text("utf-8")
    check_page(page)
    assert html.escape(evil) in page and len(page) < 1_000_000


@pytest.mark.parametrize("method", ["save", "report"])
def test_a_path_is_checked_before_the_work(
    result: Any, method: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not hasattr(result, method):
        pytest.skip("no page")
    if method == "report":
        pytest.importorskip("matplotlib")
        monkeypatch.setattr(asap.plots.NotebookFigure, "__init__", None)
    monkeypatch.setattr(type(result), "summary", None)
    for path, error in (
        (5, TypeError),
        (None, TypeError),
        (tmp_path / "no" / "such" / "out.html", FileNotFoundError),
        (tmp_path, IsADirectoryError),
    ):
        with pytest.raises(error, match=r"path = |there is no folder|a folder"):
            getattr(result, method)(path)
    assert not list(tmp_path.iterdir())


def test_a_notebook_shows_a_table_and_the_verdict(result: Any) -> None:
    shown = result._repr_html_()
    tags = Elements(shown).names
    assert "table" in tags and not {"script", "style", "img", "link"} & tags
    assert EVIL not in shown
    verdict = re.findall(r"^(?:Verdict|Bottleneck): (.{0,30})", str(result), re.M)
    assert len(verdict) == isinstance(result, (asap.Run, asap.Inspection))
    assert all(words in shown.replace("\xa0", " ") for words in verdict)
    assert "Verdict:" in shown


def test_no_notebook_needs_matplotlib(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [*sys.modules]:
        if name.partition(".")[0] == "matplotlib" or name in (
            "asap.plots",
            "asap.results.page",
        ):
            monkeypatch.setitem(sys.modules, name, None)
    assert "Verdict" in compared()._repr_html_()
