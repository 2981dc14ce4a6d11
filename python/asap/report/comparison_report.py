"""One self-contained HTML page about a comparison, in the look of the page about runs.

No script, no font and no image from outside; every value is escaped; the numbers are embedded as
JSON. Needs matplotlib: ``asap-events[report]``.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from asap import _checks
from asap.report import comparison_figures, page
from asap.results import comparison_table, run_table

if TYPE_CHECKING:
    from asap.results.comparison import Comparison, Row

_STYLE = """
.contest th,.contest td{padding-right:9px}
.contest tr>:last-child{padding-right:0}
.contest td,.contest th+th{text-align:right;white-space:nowrap}
.contest tbody th{white-space:normal;overflow-wrap:anywhere;min-width:7.5em}
.contest td.score{min-width:5em}
.contest td.score i{display:block;height:5px;border-radius:3px;background:var(--line);
margin-top:5px;overflow:hidden}
.contest td.score u{display:block;height:100%;background:var(--green)}
.contest .late{color:var(--vermilion);font-weight:600}
.contest .oracle>*{border-top:2px solid var(--line);color:var(--soft)}
.contest .oracle+.oracle>*{border-top:0}
"""

# On a narrow screen a scheme is a block: its name and score, below them the rest, each with its
# column's name.
_NARROW = """
@media (max-width:640px){
.contest{display:block}
.contest tbody{display:block}
.contest thead{display:none}
.contest tr{display:grid;grid-template-columns:repeat(5,1fr);gap:6px 8px;padding:10px 0;
border-bottom:1px solid var(--line)}
.contest tr>*{border:0!important;padding:0}
.contest tbody th{grid-column:1/4;min-width:0}
.contest td.score,.contest .oracle td:nth-child(2){grid-column:4/6}
.contest td{font-size:.8rem;line-height:1.3}
.contest td:empty{display:none}
.contest td::before{display:block;color:var(--soft);font-weight:400;font-size:.7rem}
%s}
"""

_CURVES = "Curves of every scheme: latency and kept share over time"


def write(
    comparison: Comparison, path: str | os.PathLike[str], title: str = "ASAP comparison"
) -> Path:
    """Write one HTML file about a comparison.

    Parameters
    ----------
    comparison : Comparison
        What `asap.compare` returns.
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
    The page takes at most 10^6 bytes. The numbers stand in ``<template data-comparison>`` as JSON:
    what ``comparison.summary()`` says.
    """
    path = _checks.new_file("path", path)
    return page.write(
        path,
        title,
        _article(comparison),
        style=_STYLE + _NARROW % "".join(_names()),
        intro=page.INTRO_OF_RUNS,
        words=page.WORDS_OF_RUNS,
    )


def _article(comparison: Comparison) -> str:
    headline, dot, rest = comparison_table.verdict(comparison).partition(". ")
    few = 9 / max(len(comparison.rows), 9)
    wide = _figure(comparison, "wide", 0.56, width_inches=8.6, points=int(500 * few))
    narrow = _figure(comparison, "narrow", 0.34, width_inches=4.1, columns=1, points=int(300 * few))
    return f"""
<article>
<h2>{escape(comparison_table.title(comparison))}</h2>
<p class="sub">{page.text(comparison_table.subtitle(comparison))}</p>
<div class="scroll">{_table(comparison)}</div>
<aside style="margin-top:24px"><h3>Verdict</h3>
<p><strong>{page.text(headline + dot)}</strong>{page.text(rest)}</p></aside>
<figure>
{wide}
{narrow}
<figcaption>Every scheme over time: the largest latency of the events of each moment, and the share
of the events that was finished. Latencies beyond 100 L are drawn at 100 L.</figcaption>
</figure>
<details><summary>What the columns say</summary><dl>{"".join(_words())}</dl></details>
<details><summary>The schemes and their parameters</summary>
<div class="scroll"><table class="plain">{"".join(_parameters(comparison))}</table></div></details>
{page.embedded("data-comparison", comparison.summary())}
</article>"""


def _figure(
    comparison: Comparison, css_class: str, share: float, *, points: int, **options: Any
) -> str:
    def draw(points: int) -> str:
        figure = comparison_figures.figure(comparison, points=points, **options)
        return page.inline_svg(figure, css_class[0], css_class, _CURVES)

    return page.fitted(draw, points, share * page.MOST_BYTES)


def _table(comparison: Comparison) -> str:
    head = "".join(f'<th scope="col">{escape(name)}</th>' for name in comparison_table.COLUMNS)
    rows = [_row(row, comparison.latency_ms) for row in comparison.rows]
    for name, *cells in comparison_table.oracle_rows(comparison):
        oracle = "".join(f"<td>{escape(cell)}</td>" for cell in cells)
        rows.append(f'<tr class="oracle"><th scope="row">{escape(name)}</th>{oracle}</tr>')
    return (
        f'<table class="contest"><thead><tr>{head}</tr></thead>'
        f"<tbody>{''.join(rows)}</tbody></table>"
    )


def _names() -> Iterator[str]:
    for number, name in enumerate(comparison_table.COLUMNS, start=1):
        if number > 1:  # the scheme's own name needs none
            yield f'.contest td:nth-child({number})::before{{content:"{name}"}}\n'


def _row(row: Row, latency_ms: float) -> str:
    texts = dict(
        zip(comparison_table.COLUMNS, comparison_table.cells(row, latency_ms), strict=True)
    )
    name = texts.pop("scheme")
    percent = 100 * min(row.score, 1.0)
    bar = f'<i aria-hidden="true"><u style="width:{percent:.1f}%"></u></i>'
    late = {"p99/L": row.p99_us, "max": row.max_us}
    cells = [
        f'<td class="score">{escape(text)}{bar}</td>'
        if column == "score"
        else f'<td class="late">{escape(text)}</td>'
        if comparison_table.exceeds(late.get(column, 0.0), latency_ms)
        else f"<td>{escape(text)}</td>"
        for column, text in texts.items()
    ]
    return f'<tr><th scope="row">{escape(name)}</th>{"".join(cells)}</tr>'


def _words() -> Iterator[str]:
    for name, words in comparison_table.COLUMNS.items():
        yield f"<dt>{escape(name)}</dt><dd>{escape(words)}</dd>"


def _parameters(comparison: Comparison) -> Iterator[str]:
    for row in comparison.rows:
        parameters = comparison.runs[row.label].scheme.parameters
        words = ", ".join(
            f"{name} {run_table.parameter_value(value)}" for name, value in parameters.items()
        )
        yield (
            f'<tr><th scope="row">{escape(row.label)}</th><td>{escape(row.scheme)}</td>'
            f"<td>{escape(words or 'none')}</td></tr>"
        )
