import html
import re
from html.parser import HTMLParser

import pytest

from fake_run import fake_run

pytest.importorskip("matplotlib")

from asap.results import page as report

IMAGE = "data:image/svg+xml;base64,"


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
        return report.write_runs(runs, tmp_path / "report.html", **options).read_text("utf-8")

    return write_and_read


@pytest.fixture(scope="module")
def text(run, tmp_path_factory):
    """The page about one run."""
    return report.write_runs(run, tmp_path_factory.mktemp("page") / "report.html").read_text(
        "utf-8"
    )


@pytest.fixture(scope="module")
def text_of_two(run, tmp_path_factory):
    """The page about two runs."""
    path = tmp_path_factory.mktemp("page") / "report.html"
    return report.write_runs([run, fake_run(duration_s=0.1)], path).read_text("utf-8")


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
        "image",
        "base",
        "foreignobject",
    }
    for tag, attributes in page.tags:
        for name, value in attributes.items():
            assert not name.startswith("on"), (tag, name)
            if name in ("href", "xlink:href", "src", "action"):
                assert value.startswith(IMAGE), (tag, value)
    without_images = re.sub(r'src="[^"]*"', "", text_of_two)
    assert not re.search(r"(https?:)?//\w", without_images)
    assert "@import" not in text_of_two


def test_parameters_of_any_length_fit(write):
    run = fake_run(duration_s=0.1)
    run.algorithm.parameters = {"weights": [0.5] * 10**6, "x" * 10**6: 1}
    text = write(run)
    assert len(text.encode()) < 1_000_000


def test_the_same_run_gives_the_same_bytes(write, text, run):
    assert write([run]) == text


def test_values_are_escaped(write):
    evil = "<img src=x onerror=alert(1)>&\"'.npy"
    text = write(fake_run(duration_s=0.1, source=evil), title="</title><script>x</script>")
    assert "<script" not in text and "<img src=x" not in text
    assert html.escape(evil) in text
    Page(text)
