"""No link of README or of a page is dead, and README leads to every page and picture."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from house import ROOT, name_of

README = ROOT / "README.md"
PAGES = [
    *sorted(ROOT.glob("*.md")),
    *sorted(path for kind in ("md", "ipynb") for path in (ROOT / "notebooks").rglob(f"*.{kind}")),
    *sorted((ROOT / "python" / "laboratory" / "pages").glob("*.md")),
]
PICTURES = sorted(path for page in {page.parent for page in PAGES} for path in page.glob("*.svg"))


def text_of(page: Path) -> str:
    text = page.read_text(encoding="utf-8")
    if page.suffix == ".ipynb":
        cells = [cell for cell in json.loads(text)["cells"] if cell["cell_type"] == "markdown"]
        return "\n".join("".join(cell["source"]) for cell in cells)
    return re.sub(r"^```.*?^```$", "", text, flags=re.M | re.S)


def anchors_of(page: Path) -> set[str]:
    """Name the headings of a page as a web page does."""
    headings = re.findall(r"^#+ (.*)$", text_of(page), re.M)
    return {re.sub(r"[^\w-]", "", heading.lower().replace(" ", "-")) for heading in headings}


def targets(page: Path) -> Iterator[tuple[str, Path, str]]:
    """Every link and picture within the project: as it is written, its file, its anchor."""
    for target in re.findall(r"\]\(([^)\s]+)\)|<img src=\"([^\"]+)\"", text_of(page)):
        written = "".join(target)
        if not written.startswith("https://"):
            path, _, anchor = written.partition("#")
            yield written, (page.parent / path).resolve() if path else page, anchor


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_links_lead_somewhere(page: Path) -> None:
    dead = [written for written, path, _ in targets(page) if not path.exists()]
    assert not dead
    for written, path, anchor in targets(page):
        assert not anchor or anchor in anchors_of(path), written


def test_readme_leads_to_every_page_and_picture() -> None:
    reached, ahead = {README}, [README]
    while ahead:
        page = ahead.pop()
        if page in PAGES:
            found = {path for _, path, _ in targets(page)} - reached
            reached |= found
            ahead += found
    assert not [name_of(path) for path in (*PAGES, *PICTURES) if path not in reached]


@pytest.mark.parametrize("picture", PICTURES, ids=name_of)
def test_a_picture_can_be_read_on_a_phone_and_in_the_dark(picture: Path) -> None:
    text = picture.read_text("utf-8")
    assert "prefers-color-scheme" in text
    assert "var(--" not in text  # a viewer without these paints black
    (width,) = re.findall(r'viewBox="0 0 ([\d.]+) ', text)
    smallest = min(float(size) for size in re.findall(r"font-size: ([\d.]+)px", text))
    assert picture.name == "scores.svg" or smallest * 390 / float(width) > 9  # its page has a table
