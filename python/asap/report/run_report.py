"""One self-contained HTML page about one or several runs.

No script, no font and no image from outside; the page forbids them to itself (content security
policy). Every value is escaped. Figures are inline SVG in the reader's own light or dark look; the
numbers behind them are embedded as JSON. Needs matplotlib: ``asap-events[report]``.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from asap import _checks, _units, analysis, plots
from asap.report import page
from asap.results import notebook, run_table

if TYPE_CHECKING:
    from asap.results.run import Run

_CURVES = ("size", "event_rate", "rate", "gamma", "margin_us", "latency_max_us")
_MOST_POINTS = 2000
_SIZES = (("wide", 8.6, 8.4, 0.4), ("narrow", page.NARROW_INCHES, 7.2, 0.35))  # inches, of the page
_POINT_BYTES = 20 * len(_CURVES)  # as JSON
_LEAST_SHARE, _TEXT_SHARE = 120_000, 12_000  # bytes: of a run with curves, of a run without its


def write(
    runs: Run | Sequence[Run], path: str | os.PathLike[str], title: str = "ASAP report"
) -> Path:
    """Write one HTML file about one or several finished runs, of at most 10^6 bytes.

    The numbers of a run stand in ``<template data-run="0">`` as JSON: ``summary`` and ``curves``,
    which holds of every curve its times in s and its values; the smallest and the largest of what
    is left out stay. Of more runs than fit, the first have curves.
    """
    path = _checks.page_file("path", path)
    runs = list(runs) if isinstance(runs, Sequence) else [runs]
    if not runs:
        raise ValueError("runs = []: give at least one run")
    parts = [_compare(runs)] if len(runs) > 1 else []
    room = page.MOST_BYTES - _TEXT_SHARE * (len(runs) + 2)
    with_curves = min(len(runs), max(room // _LEAST_SHARE, 0))
    share = room // max(with_curves, 1)
    parts += [
        _article(run, number, share if number < with_curves else 0)
        for number, run in enumerate(runs)
    ]
    return page.write(
        path, title, "\n".join(parts), intro=page.INTRO_OF_RUNS, words=page.WORDS_OF_RUNS
    )


def _article(run: Run, number: int, most_bytes: int) -> str:
    summary = page.shortened(run.summary())
    name = run_table.title(summary)
    headline, stop, rest = re.split(r"(\.(?: |$))", run_table.verdict(run), maxsplit=1)
    return f"""
<article id="run-{number}">
<h2>{escape(name)}</h2>
<p class="sub">{page.text(run_table.subtitle(summary))}</p>
<div class="tiles">{"".join(_tiles(run, summary))}</div>
{page.verdict(headline + stop, rest)}
{_figure(run, number, name, most_bytes)}
<h3>Where every event went</h3>
{_ledger(run)}
<details><summary>All numbers of this run</summary>
<div class="scroll">{notebook.table((), _rows(summary), "plain")}</div>
</details>
{_numbers(run, summary, number, most_bytes)}
</article>"""


def _tiles(run: Run, summary: Mapping[str, Any]) -> Iterator[str]:
    latency, packages = summary["latency_us"], summary["packages"]
    tiles = (
        (_units.share(run.kept), "kept", "of all events"),
        (_units.share(run.in_time), "in time", f"within {_units.duration(run.latency_bound_us)}"),
        (_units.duration(latency["p50"]), "median latency", "of the delivered events"),
        (_units.duration(latency["p99"]), "p99 latency", f"max {_units.duration(latency['max'])}"),
        (_units.count(packages["per_s"]), "packages per s", _sizes(packages)),
        (_units.count(summary["ledger"]["overflow"]), "overflow", "events the buffer had to drop"),
    )
    for value, name, note in tiles:
        yield (
            f"<div><b>{escape(value)}</b><span>{escape(name)}</span>"
            f"<small>{escape(note)}</small></div>"
        )


def _sizes(packages: Mapping[str, float]) -> str:
    return f"size {_units.count(packages['size_mean'])}, max {_units.count(packages['size_max'])}"


def _figure(run: Run, number: int, name: str, most_bytes: int) -> str:
    if run.without_log:
        return _note("No curves: a summary holds no packages; run.save('run.npz') keeps them.")
    label = f"Curves of {name}: package size, rates, gamma, margin, latency over time"
    wide, narrow = (
        page.fitted(
            partial(plots.figure, run, size_inches=(width, height)),
            int(width / 8.6 * _MOST_POINTS),
            share * most_bytes,
            f"r{number}{css_class[0]}",
            css_class,
            label,
        )
        if most_bytes
        else ""
        for css_class, width, height, share in _SIZES
    )
    if not (wide and narrow):
        return _note("No curves: the page would be too large; run.report() of this run draws them.")
    return page.curves(wide, narrow, "What the closed loop did, package by package.")


def _note(words: str) -> str:
    return f'<p class="sub">{escape(words)}</p>'


def _ledger(run: Run) -> str:
    ledger = run.ledger
    received = ledger["received"]
    rows = []
    bar = []
    for cause, words in run_table.LEDGER_WORDS.items():
        share = ledger[cause] / received if received else 0.0
        if cause == "rejected" and (reasons := _units.reasons(run.rejected)):
            words += f": {reasons}"
        rows.append(
            f'<tr class="{cause}"><th scope="row"><i></i>{cause}</th>'
            f"<td>{_units.count(ledger[cause])}</td>"
            f"<td>{escape(_units.share(share)) if ledger[cause] else ''}</td>"
            f"<td>{escape(words)}</td></tr>"
        )
        if share > 0 and cause != "received":
            bar.append(f'<i class="{cause}" style="flex-grow:{share:.6f}"></i>')
    return (
        f'<div class="bar" aria-hidden="true">{"".join(bar)}</div>'
        f'<div class="scroll"><table class="ledger">{"".join(rows)}</table></div>'
    )


def _compare(runs: Sequence[Run]) -> str:
    head = ("run", "kept", "in time", "p50", "p99", "max", "packages/s", "overflow")
    rows = []
    for number, run in enumerate(runs):
        summary = run.summary()
        latency = summary["latency_us"]
        cells = (
            _units.share(run.kept),
            _units.share(run.in_time),
            *(_units.duration(latency[name]) for name in ("p50", "p99", "max")),
            _units.count(summary["packages"]["per_s"]),
            _units.count(summary["ledger"]["overflow"]),
        )
        name = escape(run_table.title(summary))
        rows.append(
            f'<tr><th scope="row"><a href="#run-{number}">{name}</a></th>'
            + "".join(f"<td>{escape(cell)}</td>" for cell in cells)
            + "</tr>"
        )
    return (
        '<section><h2>Side by side</h2><div class="scroll"><table class="compare"><thead><tr>'
        + "".join(f'<th scope="col">{name}</th>' for name in head)
        + f"</tr></thead><tbody>{''.join(rows)}</tbody></table></div></section>"
    )


def _rows(value: Any, name: str = "") -> Iterator[tuple[str, str]]:
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _rows(inner, f"{name}.{key}" if name else str(key))
    else:
        yield name, f"{value:.6g}" if isinstance(value, float) else str(value)


def _numbers(run: Run, summary: Mapping[str, Any], number: int, most_bytes: int) -> str:
    numbers: dict[str, Any] = {"summary": summary}
    points = min(_MOST_POINTS, int(0.25 * most_bytes / _POINT_BYTES))
    if points and not run.without_log:
        time_s = analysis.time_s(run)
        numbers["curves"] = {
            name: [
                _six_digits(numbers)
                for numbers in analysis.decimate(time_s, run.packages[name], points)
            ]
            for name in _CURVES
        }
    return page.embedded(f'data-run="{number}"', numbers)


def _six_digits(column: NDArray[Any]) -> list[float]:
    if column.dtype.kind != "f":
        return list(column.tolist())
    largest = max(float(np.abs(column).max(initial=0)), 1e-9)
    return list(np.round(column, max(5 - math.floor(math.log10(largest)), 0)).tolist())
