"""One self-contained HTML page about an inspection, in the look of the page about runs.

No script, no font and no image from outside; every value is escaped; the numbers are embedded as
JSON. Needs matplotlib: ``asap-events[report]``.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from asap import _checks, _units
from asap.report import inspection_figures, page
from asap.results import inspection_table

if TYPE_CHECKING:
    from asap.results.inspection import Inspection

_STYLE = """
.checks td:nth-child(2){text-align:right;white-space:nowrap}
.checks td:last-child{color:var(--soft);width:60%;overflow-wrap:anywhere}
.checks .wrong td:nth-child(3){color:var(--vermilion);font-weight:600}
.checks .note td:nth-child(3){color:var(--blue);font-weight:600}
.checks .ok td:nth-child(3){color:var(--green)}
"""

_CURVES = (
    "Event rate over time, a histogram of the times between events, and a map of how many events "
    "every pixel had"
)


def write(
    inspection: Inspection, path: str | os.PathLike[str], title: str = "ASAP inspection"
) -> Path:
    """Write one HTML file about an inspection.

    Parameters
    ----------
    inspection : Inspection
        What `asap.check` returns.
    path : path-like
        The file to write; an existing one is replaced.
    title : str
        Heading of the page.

    Returns
    -------
    Path
        `path`.

    Raises
    ------
    OSError
        The file cannot be written.

    Notes
    -----
    The numbers stand in ``<template data-inspection>`` as JSON: ``inspection.summary()``.
    """
    path = _checks.new_file("path", path)
    return page.write(path, title, _article(inspection), style=_STYLE)


def _article(inspection: Inspection) -> str:
    facts = inspection_table.facts(inspection)
    _, _, sentences = inspection_table.verdict(inspection).partition(": ")
    sentences = sentences[:1].upper() + sentences[1:]
    wide = inspection_figures.figure(inspection, size_inches=(8.6, 10.0))
    narrow = inspection_figures.figure(inspection, size_inches=(4.1, 7.2), points=700)
    return f"""
<article>
<h2>{escape(inspection_table.title(inspection))}</h2>
<table class="plain">{"".join(_pairs(facts))}</table>
<aside style="margin-top:24px"><h3>Verdict</h3>
<p><strong>{page.text(sentences)}</strong></p>
<dl>{"".join(_remedies(inspection))}</dl></aside>
<div class="scroll"><table class="checks">{"".join(_rows(inspection))}</table></div>
<figure style="margin-top:24px">
{page.inline_svg(wide, "w", "wide", _CURVES)}
{page.inline_svg(narrow, "n", "narrow", _CURVES)}
<figcaption>The good events: how many in each moment, how long after the one before, and how many
of each pixel.</figcaption>
</figure>
<details><summary>The ten busiest pixels</summary>
<div class="scroll"><table class="plain">{"".join(_pixels(inspection))}</table></div></details>
<details><summary>What is checked</summary><dl>{"".join(_words())}</dl></details>
{page.embedded("data-inspection", inspection.summary())}
</article>"""


def _pairs(facts: dict[str, str]) -> Iterator[str]:
    for name, value in facts.items():
        yield f'<tr><th scope="row">{escape(name)}</th><td>{page.text(value)}</td></tr>'


def _rows(inspection: Inspection) -> Iterator[str]:
    for finding in inspection.findings.values():
        yield (
            f'<tr class="{finding.verdict}">'
            f'<th scope="row">{escape(inspection_table.named(finding))}</th>'
            f"<td>{_units.count(finding.count)}</td><td>{finding.verdict}</td>"
            f"<td>{page.text(inspection_table.detail(finding))}</td></tr>"
        )


def _remedies(inspection: Inspection) -> Iterator[str]:
    for name, words in inspection_table.remedies(inspection).items():
        yield f"<dt>{escape(name)}</dt><dd>{page.text(words)}</dd>"


def _pixels(inspection: Inspection) -> Iterator[str]:
    hot = {(x, y) for x, y, _ in inspection.hot_pixels.tolist()}
    for x, y, events in inspection.busiest_pixels.tolist():
        share = _units.share(events / inspection.events)
        yield (
            f'<tr><th scope="row">x = {x}, y = {y}</th><td>{_units.count(events)}</td>'
            f"<td>{escape(share)}</td><td>{'hot' if (x, y) in hot else ''}</td></tr>"
        )


def _words() -> Iterator[str]:
    for name, words in inspection_table.CHECKS.items():
        yield f"<dt>{escape(name.replace('_', ' '))}</dt><dd>{escape(words)}</dd>"
