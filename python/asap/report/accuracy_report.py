"""One self-contained HTML page about scores over gamma, in the look of the page about runs.

No script, no font and no image from outside; every value is escaped; the numbers are embedded as
JSON. Needs matplotlib: ``asap-events[report]``.
"""

from __future__ import annotations

import os
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from asap import _checks
from asap.report import accuracy_figures, page
from asap.results import accuracy_table, notebook

if TYPE_CHECKING:
    from asap.results.keep_curve import KeepCurve

_STYLE = """
.scores td+td,.scores th+th{text-align:right;white-space:nowrap}
"""


def write(curve: KeepCurve, path: str | os.PathLike[str], title: str = "ASAP accuracy") -> Path:
    """Write one HTML file about the scores of an algorithm over gamma.

    Parameters
    ----------
    curve : KeepCurve
        What `asap.keep_curve` returns.
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
    The numbers stand in ``<template data-keep-curve>`` as JSON: ``curve.summary()``.
    """
    path = _checks.new_file("path", path)
    name = accuracy_table.title(curve)
    wide = accuracy_figures.figure([curve], width_inches=8.6)
    narrow = accuracy_figures.figure([curve], width_inches=4.1, columns=2)
    label = f"Curves of {name}: scores over the kept fraction gamma"
    head, *rows = accuracy_table.cells(curve)
    words = "".join(
        f"<dt>{escape(column)}</dt><dd>{escape(text)}</dd>"
        for column, text in accuracy_table.columns_of(curve.rows[0]).values()
    )
    body = f"""
<article>
<h2>{escape(name)}</h2>
<div class="scroll scores">{notebook.table(head, rows)}</div>
<figure style="margin-top:24px">
{page.inline_svg(wide, "w", "wide", label)}
{page.inline_svg(narrow, "n", "narrow", label)}
<figcaption>Scores over the fraction of the events that is kept. Told: the algorithm knew it.
Bars are standard deviations over the seeds.</figcaption>
</figure>
<details><summary>What the columns say</summary><dl>{words}</dl></details>
{page.embedded("data-keep-curve", curve.summary())}
</article>"""
    return page.write(path, title, body, style=_STYLE)
