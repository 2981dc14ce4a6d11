"""Results in a notebook: plain HTML without a script and a style of its own; all is escaped."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from asap import _units


def heading(title: str, subtitle: str = "") -> str:
    """Write a heading in one or two lines."""
    return f"<p><b>{text(title)}</b>{'<br>' if subtitle else ''}{text(subtitle)}</p>"


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Write a table; the first cell of a row is its name."""
    names = "".join(f'<th scope="col">{text(name)}</th>' for name in head)
    lines = [
        f'<tr><th scope="row">{text(name)}</th>'
        + "".join(f"<td>{text(cell)}</td>" for cell in cells)
        + "</tr>"
        for name, *cells in rows
    ]
    top = f"<thead><tr>{names}</tr></thead>" if names else ""
    return f"<table>{top}<tbody>{''.join(lines)}</tbody></table>"


def verdict(sentences: str) -> str:
    """Write a verdict."""
    return f"<p><b>Verdict:</b> {text(sentences.removeprefix('Verdict: '))}</p>"


def text(words: str) -> str:
    """Escape, and keep a number on the line of its unit."""
    return escape(_units.tied(words))
