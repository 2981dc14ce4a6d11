"""One self-contained HTML page about one or several runs.

No script, no font and no image from outside; the page forbids them to itself (content security
policy). Every value is escaped. Figures are inline SVG in the reader's own light or dark look; the
numbers behind them are embedded as JSON. Needs matplotlib: ``asap-events[report]``.
"""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from asap import plots, table, units

if TYPE_CHECKING:
    from asap.experiment import Run

__all__ = ["write"]

_MAX_EMBEDDED_PACKAGES = 100_000

_LOOK = {
    plots.BLUE: "var(--blue)",
    plots.VERMILION: "var(--vermilion)",
    plots.GREEN: "var(--green)",
    plots.PURPLE: "var(--purple)",
    plots.INK: "var(--ink)",
    plots.FAINT: "var(--faint)",
}


def write(
    runs: Run | Sequence[Run], path: str | os.PathLike[str], title: str = "ASAP report"
) -> Path:
    """Write one HTML file about one or several runs.

    Parameters
    ----------
    runs : Run or sequence of Run
        Finished runs, in the order of the page.
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
    ValueError
        No run was given.
    OSError
        The file cannot be written.

    Notes
    -----
    The numbers of a run stand in ``<template data-run="0">`` as JSON: ``summary`` and, for at most
    100,000 packages, ``packages`` by column.
    """
    runs = list(runs) if isinstance(runs, Sequence) else [runs]
    if not runs:
        raise ValueError("runs = []: give at least one run")
    parts = [_compare(runs)] if len(runs) > 1 else []
    parts += [_article(run, number) for number, run in enumerate(runs)]
    page = _PAGE.format(title=escape(title), style=_STYLE, body="\n".join(parts))
    path = Path(path)
    path.write_text(page, encoding="utf-8")
    return path


def _article(run: Run, number: int) -> str:
    summary = run.summary()
    name = table.title(summary)
    return f"""
<article id="run-{number}">
<h2>{escape(name)}</h2>
<p class="sub">{_text(table.subtitle(summary))}</p>
<div class="tiles">{"".join(_tiles(run, summary))}</div>
{_verdict(run)}
<figure>
{_svg(run, f"r{number}w", name, size_inches=(8.6, 8.4), points=2000, css_class="wide")}
{_svg(run, f"r{number}n", name, size_inches=(4.1, 7.6), points=700, css_class="narrow")}
<figcaption>What the closed loop did, package by package.</figcaption>
</figure>
<h3>Where every event went</h3>
{_ledger(run)}
<details><summary>All numbers of this run</summary>
<div class="scroll"><table class="plain">{"".join(_rows(summary))}</table></div>
</details>
{_numbers(run, summary, number)}
</article>"""


def _tiles(run: Run, summary: Mapping[str, Any]) -> Iterator[str]:
    latency, packages = summary["latency_us"], summary["packages"]
    tiles = (
        (units.share(run.kept), "kept", "of all events"),
        (units.share(run.in_time), "in time", f"within {units.duration(run.latency_bound_us)}"),
        (units.duration(latency["p50"]), "median latency", "of the delivered events"),
        (units.duration(latency["p99"]), "p99 latency", f"max {units.duration(latency['max'])}"),
        (units.count(packages["per_s"]), "packages per s", _sizes(packages)),
        (units.count(summary["ledger"]["overflow"]), "overflow", "events the buffer had to drop"),
    )
    for value, name, note in tiles:
        yield (
            f"<div><b>{escape(value)}</b><span>{escape(name)}</span>"
            f"<small>{escape(note)}</small></div>"
        )


def _sizes(packages: Mapping[str, float]) -> str:
    return f"size {units.count(packages['size_mean'])}, max {units.count(packages['size_max'])}"


def _verdict(run: Run) -> str:
    word, _, sentences = table.verdict(run).partition(": ")
    headline, stop, rest = re.split(r"(\.(?: |$))", sentences, maxsplit=1)
    headline = headline[:1].upper() + headline[1:] + stop
    return (
        f"<aside><h3>{_text(word)}</h3>"
        f"<p><strong>{_text(headline)}</strong>{_text(rest)}</p></aside>"
    )


def _text(text: str) -> str:
    """Escaped, with every number tied to its unit."""
    return escape(re.sub(r"(?<=[\d<>]) (?=\S)", "\xa0", text))


def _ledger(run: Run) -> str:
    ledger = run.ledger
    received = ledger["received"]
    rows = []
    bar = []
    for cause, words in table.LEDGER_WORDS.items():
        share = ledger[cause] / received if received else 0.0
        if cause == "rejected" and (reasons := table.reasons_of(run.rejected)):
            words += f": {reasons}"
        rows.append(
            f'<tr class="{cause}"><th scope="row"><i></i>{cause}</th>'
            f"<td>{units.count(ledger[cause])}</td>"
            f"<td>{escape(units.share(share)) if ledger[cause] else ''}</td>"
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
            units.share(run.kept),
            units.share(run.in_time),
            *(units.duration(latency[name]) for name in ("p50", "p99", "max")),
            units.count(summary["packages"]["per_s"]),
            units.count(summary["ledger"]["overflow"]),
        )
        rows.append(
            f'<tr><th scope="row"><a href="#run-{number}">{escape(table.title(summary))}</a></th>'
            + "".join(f"<td>{escape(cell)}</td>" for cell in cells)
            + "</tr>"
        )
    return (
        '<section><h2>Side by side</h2><div class="scroll"><table class="compare"><thead><tr>'
        + "".join(f'<th scope="col">{name}</th>' for name in head)
        + f"</tr></thead><tbody>{''.join(rows)}</tbody></table></div></section>"
    )


def _rows(value: Any, name: str = "") -> Iterator[str]:
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _rows(inner, f"{name}.{key}" if name else str(key))
    else:
        text = f"{value:.6g}" if isinstance(value, float) else str(value)
        yield f'<tr><th scope="row">{escape(name)}</th><td>{escape(text)}</td></tr>'


def _numbers(run: Run, summary: Mapping[str, Any], number: int) -> str:
    numbers: dict[str, Any] = {"summary": summary}
    note = ""
    if run.packages.size <= _MAX_EMBEDDED_PACKAGES:
        numbers["packages"] = {
            name: _six_digits(run.packages[name]) for name in run.packages.dtype.names or ()
        }
    else:
        note = (
            f'<p class="sub">The rows of the {units.count(run.packages.size)} packages are not '
            "embedded here; run.save() keeps them.</p>"
        )
    text = escape(json.dumps(numbers, separators=(",", ":")), quote=False)
    return f'{note}<template data-run="{number}">{text}</template>'


def _six_digits(column: NDArray[Any]) -> list[float]:
    if column.dtype.kind != "f":
        return list(column.tolist())
    largest = max(float(np.abs(column).max(initial=0)), 1e-9)
    return list(np.round(column, max(5 - math.floor(math.log10(largest)), 0)).tolist())


def _svg(
    run: Run,
    prefix: str,
    name: str,
    *,
    size_inches: tuple[float, float],
    points: int,
    css_class: str,
) -> str:
    """Inline SVG of the run's figure: own identifiers, no outside reference, colours by name."""
    page = plots.figure(run, size_inches=size_inches, points=points)
    page.set_facecolor("none")
    svg = plots.svg(page)
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(r'(\bid="|href="#|url\(#)', rf"\g<1>{prefix}-", svg)
    for colour, variable in _LOOK.items():
        svg = svg.replace(colour, variable)
    label = escape(f"Curves of {name}: package size, rates, gamma, margin, latency over time")
    return svg.replace("<svg ", f'<svg class="{css_class}" role="img" aria-label="{label}" ', 1)


_STYLE = """
:root{color-scheme:light dark;--page:#f5f6f7;--card:#fff;--ink:#22272c;--soft:#5b646d;
--faint:#9aa1a8;--line:#e2e5e8;--blue:#0072b2;--vermilion:#d55e00;--green:#009e73;--purple:#a14f7c;
--amber:#c98a00}
@media (prefers-color-scheme:dark){:root{--page:#14171a;--card:#1d2125;--ink:#e6e9ec;--soft:#a3acb5;
--faint:#6c757e;--line:#30363c;--blue:#56b4e9;--vermilion:#ff8a3d;--green:#2fc79c;--purple:#df8fbb;
--amber:#f0b83c}}
*{box-sizing:border-box}
body{margin:0;background:var(--page);color:var(--ink);
font:16px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,"Helvetica Neue",sans-serif}
main,header,footer{max-width:940px;margin:0 auto;padding:0 20px}
header{padding-top:36px}
h1{font-size:1.9rem;line-height:1.2;margin:0;letter-spacing:-.01em}
h2{font-size:1.3rem;line-height:1.3;margin:0;overflow-wrap:anywhere}
h3{font-size:.95rem;margin:28px 0 10px}
header p,.sub,figcaption,footer{color:var(--soft);font-size:.9rem;margin:4px 0 0;
overflow-wrap:anywhere}
section,article{background:var(--card);border:1px solid var(--line);border-radius:12px;
padding:24px;margin:24px 0}
.tiles{display:grid;grid-template-columns:repeat(auto-fit,minmax(125px,1fr));gap:16px 12px;
margin:22px 0}
.tiles b{display:block;font-size:1.45rem;line-height:1.2;font-variant-numeric:tabular-nums}
.tiles span{display:block;font-weight:600;font-size:.85rem}
.tiles small{display:block;color:var(--soft);font-size:.78rem;line-height:1.35}
aside{border-left:4px solid var(--blue);background:var(--page);border-radius:0 8px 8px 0;
padding:12px 16px;margin:0 0 24px}
aside h3{margin:0;color:var(--blue);font-size:.78rem;letter-spacing:.08em;text-transform:uppercase}
aside p{margin:4px 0 0}
figure{margin:0}
figure svg{display:block;width:100%;height:auto}
svg text{font-family:system-ui,-apple-system,"Segoe UI",Roboto,sans-serif!important}
.narrow{display:none!important}
.bar{display:flex;height:18px;gap:2px;border-radius:6px;overflow:hidden;background:var(--line)}
.bar i{min-width:3px}
.delivered i,i.delivered{background:var(--green)}
.discarded i,i.discarded{background:var(--purple)}
.overflow i,i.overflow{background:var(--vermilion)}
.stale i,i.stale{background:var(--amber)}
.rejected i,i.rejected{background:var(--ink)}
.filtered i,i.filtered{background:var(--blue)}
.pending i,i.pending{background:var(--faint)}
.scroll{overflow-x:auto}
table{border-collapse:collapse;width:100%;font-size:.9rem;margin:10px 0 0}
th,td{padding:6px 14px 6px 0;text-align:left;border-bottom:1px solid var(--line);
vertical-align:top}
tr:last-child>*{border-bottom:0}
th{font-weight:600;white-space:nowrap}
td{font-variant-numeric:tabular-nums}
.ledger th i{display:inline-block;width:10px;height:10px;border-radius:3px;margin-right:9px}
.ledger td:nth-child(2),.ledger td:nth-child(3),.compare td,.compare th+th{text-align:right;
white-space:nowrap}
.ledger td:last-child{color:var(--soft);width:60%}
.compare th[scope=row]{white-space:normal;overflow-wrap:break-word;min-width:9.5em}
.plain{width:auto}
.plain th{font-weight:400;color:var(--soft)}
details{margin-top:24px}
summary{cursor:pointer;font-weight:600;font-size:.95rem}
a{color:var(--blue)}
footer{padding-bottom:40px}
dl{display:grid;grid-template-columns:max-content 1fr;gap:3px 16px;margin:10px 0 0}
dt{font-weight:600;color:var(--ink)}
dd{margin:0}
@media (max-width:640px){main,header,footer{padding:0 12px}header{padding-top:22px}
section,article{padding:16px 14px}h1{font-size:1.5rem}
.tiles{grid-template-columns:repeat(2,1fr)}
.wide{display:none!important}.narrow{display:block!important}
.ledger tr{display:grid;grid-template-columns:1fr max-content 5em;
border-bottom:1px solid var(--line);padding:6px 0}
.ledger tr>*{border:0;padding:0 0 0 10px}.ledger tr>th{padding-left:0}
.ledger td:last-child{grid-column:1/-1;width:auto;padding-left:19px;font-size:.8rem}
dl{grid-template-columns:1fr}dd{margin-bottom:6px}}
@media print{body{background:none}section,article{border:0;padding:0}}
"""

_PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" \
content="default-src 'none'; style-src 'unsafe-inline'; img-src data:">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>{style}</style>
</head>
<body>
<header><h1>{title}</h1>
<p>Events to the algorithm as soon as possible: what was kept, how late it was, and why.</p>
</header>
<main>
{body}
</main>
<footer>
<h3>Words</h3>
<dl>
<dt>package</dt><dd>the events handed to the algorithm in one go; its size is their number</dd>
<dt>span</dt><dd>newest minus oldest timestamp in a package</dd>
<dt>margin</dt><dd>processing time minus span: below zero is real time, near zero is responsive</dd>
<dt>gamma</dt><dd>the fraction of the events that is kept; the others leave at random</dd>
<dt>R, a</dt><dd>the rate after thinning, and the bound above which gamma falls</dd>
<dt>latency</dt><dd>from an event's timestamp to the end of its processing; of delivered events
only, so read it beside what was kept</dd>
<dt>estimated</dt><dd>from a straight line through the processing times of the packages</dd>
</dl>
</footer>
</body>
</html>
"""
