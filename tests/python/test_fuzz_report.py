"""``asap report`` of other files: exit code 3 and one line, or a page that can do no harm."""

from __future__ import annotations

import copy
import io
import json
import re
from contextlib import redirect_stderr, redirect_stdout
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import asap
import streams
from asap.cli import main
from fuzzing import INTERESTING, effort

POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
ATTACK = "</title></template><script>alert(1)</script><img src=http://x.example/ onerror=a()>\"'&"

SCALARS: st.SearchStrategy[Any] = st.one_of(
    st.sampled_from((None, True, "", ATTACK, "$\\frac$", "\ud800", "\0", "1", [], {}, [1], 1e308)),
    st.sampled_from((*INTERESTING, *(-number for number in INTERESTING), 10**400, 1e-320)),
    st.floats(),
    st.text(max_size=10),
)
VALUES = st.recursive(
    SCALARS,
    lambda inner: st.one_of(
        st.lists(inner, max_size=4), st.dictionaries(st.text(max_size=5), inner, max_size=3)
    ),
    max_leaves=6,
)


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    folder = tmp_path_factory.mktemp("report")
    events = streams.poisson(2e5, 0.02)
    return folder, asap.simulate(events, cost=asap.LinearCost(100, 300)).summary()


class Elements(HTMLParser):
    """The elements and attributes of a page, and the addresses in them."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.names: set[str] = set()
        self.attributes: list[tuple[str, str]] = []
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.names.add(tag)
        self.attributes += [(name, value or "") for name, value in attrs]


def check_page(html: str) -> None:
    """Nothing runs, nothing is fetched, and the page says so itself."""
    page = Elements(html)
    assert ("content", POLICY) in page.attributes
    assert not page.names & {"script", "iframe", "object", "embed", "link", "base", "form"}
    for name, value in page.attributes:
        assert not name.startswith("on")
        if name in ("href", "src", "xlink:href", "action", "data"):
            assert value.startswith("data:image/svg+xml;base64,")


def report(folder: Path, document: Any) -> int:
    content = document if isinstance(document, str) else json.dumps(document)
    (folder / "changed.json").write_text(content, encoding="utf-8", errors="surrogatepass")
    return report_of_changed(folder)


def report_of_changed(folder: Path) -> int:
    page = folder / "page.html"
    page.unlink(missing_ok=True)
    with redirect_stderr(io.StringIO()) as said, redirect_stdout(io.StringIO()):
        code = main(["report", str(folder / "changed.json"), "-o", str(page)])
    if code == 0:
        check_page(page.read_text(encoding="utf-8"))
    else:
        assert code == 3
        pattern = r"asap: error: .*changed\.json: not a run that asap has saved .*\n"
        assert re.fullmatch(pattern, said.getvalue(), re.DOTALL)
        assert not page.exists()
    return code


@effort(40)
@given(st.one_of(VALUES.map(json.dumps), st.text(max_size=60)))
@example("[" * 100_000)
@example('{"schema_version": 1, "a": ' + "9" * 5000 + "}")
@example('{"schema_version": NaN}')
def test_any_json_or_none(saved: tuple[Path, dict[str, Any]], content: str) -> None:
    assert report(saved[0], content) == 3


def test_every_text_is_escaped(saved: tuple[Path, dict[str, Any]]) -> None:
    attack = "javascript:alert(1)" + ATTACK + "\ud800$\\frac{"
    folder, good = saved
    document = copy.deepcopy(good)
    for place in ("path", "format"):
        document["source"][place] = attack
    document["scheme"] = {"name": attack, attack: 1.0}
    document["algorithm"] = {"name": attack, attack: attack}
    document["rejected"] = {attack: 3}
    document["mode"] = attack
    assert report(folder, document) == 0
