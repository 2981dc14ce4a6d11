"""Results as a notebook shows them: the table and the verdict as plain HTML.

No script and no style of their own, so that the notebook's applies; every value is escaped. They
need no matplotlib.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import TYPE_CHECKING

from asap import _units
from asap.results import comparison_table, inspection_table, run_table

if TYPE_CHECKING:
    from asap.results.comparison import Comparison
    from asap.results.inspection import Inspection
    from asap.results.run import Run


def run_html(run: Run) -> str:
    """Show a run: its figures, where every event went, the verdict."""
    summary, received = run.summary(), run.ledger["received"]
    reasons = {"rejected": f": {_units.reasons(run.rejected)}"} if run.rejected else {}
    ledger = [
        (
            cause,
            _units.count(run.ledger[cause]),
            _share(run.ledger[cause], received),
            words + reasons.get(cause, ""),
        )
        for cause, words in run_table.LEDGER_WORDS.items()
    ]
    return (
        heading(run_table.title(summary), run_table.subtitle(summary))
        + table((), run_table.figures(run, summary).items())
        + table(("", "events", "share", ""), ledger)
        + _verdict(run_table.verdict(run))
    )


def comparison_html(comparison: Comparison) -> str:
    """Show a comparison: a row for each scheme, the oracle, the verdict."""
    rows = [comparison_table.cells(row, comparison.latency_ms) for row in comparison.rows]
    return (
        heading(comparison_table.title(comparison), comparison_table.subtitle(comparison))
        + table(tuple(comparison_table.COLUMNS), rows + comparison_table.oracle_rows(comparison))
        + _verdict(comparison_table.verdict(comparison))
    )


def inspection_html(inspection: Inspection) -> str:
    """Show an inspection: what the recording holds, every check, the verdict, what helps."""
    named, detail = inspection_table.named, inspection_table.detail
    checks = [
        (named(one), _units.count(one.count), one.verdict, detail(one))
        for one in inspection.findings.values()
    ]
    remedies = inspection_table.remedies(inspection)
    return (
        heading(inspection_table.title(inspection))
        + table((), inspection_table.facts(inspection).items())
        + table(("check", "found", "verdict", ""), checks)
        + _verdict(inspection_table.verdict(inspection))
        + (table((), remedies.items()) if remedies else "")
    )


def _share(count: int, received: int) -> str:
    return _units.share(count / received) if count and received else ""


def heading(title: str, subtitle: str = "") -> str:
    """Write a heading in one or two lines."""
    return f"<p><b>{_text(title)}</b>{'<br>' if subtitle else ''}{_text(subtitle)}</p>"


def table(head: Sequence[str], rows: Iterable[Sequence[str]], css_class: str = "") -> str:
    """Write a table; the first cell of a row is its name."""
    names = "".join(f'<th scope="col">{_text(name)}</th>' for name in head)
    lines = [
        f'<tr><th scope="row">{_text(name)}</th>'
        + "".join(f"<td>{_text(cell)}</td>" for cell in cells)
        + "</tr>"
        for name, *cells in rows
    ]
    top = f"<thead><tr>{names}</tr></thead>" if names else ""
    kind = f' class="{css_class}"' if css_class else ""
    return f"<table{kind}>{top}<tbody>{''.join(lines)}</tbody></table>"


def _verdict(sentences: str) -> str:
    return f"<p><b>Verdict:</b> {_text(sentences.removeprefix('Verdict: '))}</p>"


def _text(words: str) -> str:
    return escape(_units.tied(words))
