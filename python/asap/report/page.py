"""What the reports have in common: the page, its style, text and figures inside it.

A page is one self-contained HTML file: no script, no font and no image from outside; every value is
escaped; the numbers are embedded as JSON. Needs matplotlib: ``asap-events[report]``.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Mapping
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from asap import _units, plots

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_BYTES = 1_000_000  # of a page
NARROW_INCHES = 3.4  # of a figure: on a phone its tick labels are then 10 px

_LONGEST = 200  # characters of a text, elements of a list
_FEWEST_POINTS = 50
_FRAME_BYTES = 35_000  # about: a figure without its curves

_LOOK = {
    plots.BLUE: "var(--blue)",
    plots.VERMILION: "var(--vermilion)",
    plots.GREEN: "var(--green)",
    plots.PURPLE: "var(--purple)",
    plots.AMBER: "var(--amber)",
    plots.INK: "var(--ink)",
    plots.FAINT: "var(--faint)",
}


def write(
    path: Path,
    title: str,
    body: str,
    *,
    style: str = "",
    intro: str = "",
    words: str = "",
) -> Path:
    """Write one page: `title` is escaped here, the rest is HTML."""
    html = _PAGE.format(
        title=escape(title), style=_STYLE + style, intro=intro, body=body, words=words
    )
    path.write_text(html, encoding="utf-8", errors="replace")  # a file name may be no text
    return path


def text(words: str) -> str:
    """Escaped, with every number tied to its unit."""
    return escape(_units.tied(words))


def definitions(pairs: Iterable[tuple[str, str]]) -> str:
    """Write names and what they mean."""
    items = (f"<dt>{text(name)}</dt><dd>{text(words)}</dd>" for name, words in pairs)
    return f"<dl>{''.join(items)}</dl>"


def verdict(headline: str, rest: str = "", more: str = "") -> str:
    """Write the box that says what to make of it; `more` is HTML."""
    words = f"<p><strong>{text(headline)}</strong>{text(rest)}</p>"
    return f"<aside><h3>Verdict</h3>{words}{more}</aside>"


def drawn(wide: Figure, narrow: Figure, label: str) -> tuple[str, str]:
    """Draw a figure for wide and for narrow screens."""
    return inline_svg(wide, "w", "wide", label), inline_svg(narrow, "n", "narrow", label)


def curves(wide: str, narrow: str, caption: str) -> str:
    """Show a figure, drawn for wide and for narrow screens."""
    return f"<figure>\n{wide}\n{narrow}\n<figcaption>{text(caption)}</figcaption>\n</figure>"


def embedded(attribute: str, value: Any) -> str:
    """Hold a value as JSON that nothing shows; the attribute says what it is."""
    numbers = json.dumps(value, separators=(",", ":"), allow_nan=False)
    return f"<template {attribute}>{escape(numbers, quote=False)}</template>"


def shortened(value: Any) -> Any:
    """Cut long texts and lists, such as the weights of a user's algorithm, to fit on a page."""
    if isinstance(value, Mapping):
        few = list(value.items())[:_LONGEST]
        return {shortened(name): shortened(inner) for name, inner in few}
    if isinstance(value, (str, list, tuple)) and len(value) > _LONGEST:
        more: Any = "..." if isinstance(value, str) else ["..."]
        value = (value if isinstance(value, str) else list(value))[:_LONGEST] + more
    return [shortened(inner) for inner in value] if isinstance(value, (list, tuple)) else value


def fitted(
    draw: Callable[..., Figure], points: int, most_bytes: float, *names: str, **options: Any
) -> str:
    """Draw with as many points as fit into so many bytes, at most `points`; "" if none do.

    `names` are those of `inline_svg`, the options the figure's.
    """
    while True:
        drawn = inline_svg(draw(points=points, **options), *names)
        if len(drawn) <= most_bytes:
            return drawn
        if points <= _FEWEST_POINTS:
            return ""
        share = (most_bytes - _FRAME_BYTES) / (len(drawn) - _FRAME_BYTES)
        points = max(_FEWEST_POINTS, min(points - 1, int(0.95 * points * share)))


def inline_svg(figure: Figure, prefix: str, css_class: str, label: str) -> str:
    """Inline SVG: own identifiers, no outside reference, colours by name."""
    figure.set_facecolor("none")
    svg = plots.svg(figure)
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(r"<[^>]*>", _short_tag, svg)
    svg = re.sub(r">\s+<", "><", svg)
    svg = re.sub(r'(\bid="|href="#|url\(#)', rf"\g<1>{prefix}-", svg)
    for colour, variable in _LOOK.items():
        svg = svg.replace(colour, variable)
    described = f'<svg class="{css_class}" role="img" aria-label="{escape(label)}" '
    return svg.replace("<svg ", described, 1)


def _short_tag(tag: re.Match[str]) -> str:
    """Hundredths of a point are enough, the page has a font, and nothing refers to a group."""
    short = re.sub(r"(\.\d\d)\d+", r"\1", tag[0])
    short = re.sub(r"\s+", " ", short)
    short = re.sub(r" ?([MLQCZz]) (?=[-\d]|\")", r"\1", short)
    return re.sub(r"font-family:[^;\"]*; ?|(?<=<g) id=\"[^\"]*\"", "", short)


COLOURS = """
:root{color-scheme:light dark;--page:#f5f6f7;--card:#fff;--ink:#22272c;--soft:#5b646d;
--faint:#9aa1a8;--line:#e2e5e8;--blue:#0072b2;--vermilion:#d55e00;--green:#009e73;--purple:#a14f7c;
--amber:#c98a00;--shade:#0002}
@media (prefers-color-scheme:dark){:root{--page:#14171a;--card:#1d2125;--ink:#e6e9ec;--soft:#a3acb5;
--faint:#6c757e;--line:#30363c;--blue:#56b4e9;--vermilion:#ff8a3d;--green:#2fc79c;--purple:#df8fbb;
--amber:#f0b83c;--shade:#0009}}
"""

_STYLE = (
    COLOURS
    + """\
*{box-sizing:border-box}
body{margin:0;background:var(--page);color:var(--ink);
font:16px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,"Helvetica Neue",sans-serif}
main,header,footer{max-width:940px;margin:0 auto;padding:0 20px}
header{padding-top:36px}
h1{font-size:1.9rem;line-height:1.2;margin:0;letter-spacing:-.01em}
h2{font-size:1.3rem;line-height:1.3;margin:0;overflow-wrap:anywhere}
h3{font-size:.95rem;margin:28px 0 10px}
header p,.sub,figcaption{color:var(--soft);font-size:.9rem;margin:4px 0 0;
overflow-wrap:anywhere}
section,article{background:var(--card);border:1px solid var(--line);border-radius:12px;
padding:24px;margin:24px 0}
.tiles{display:grid;grid-template-columns:repeat(auto-fit,minmax(125px,1fr));gap:16px 12px;
margin:22px 0}
.tiles b{display:block;font-size:1.45rem;line-height:1.2;font-variant-numeric:tabular-nums}
.tiles span{display:block;font-weight:600;font-size:.85rem}
.tiles small{display:block;color:var(--soft);font-size:.78rem;line-height:1.35}
aside{border-left:4px solid var(--blue);background:var(--page);border-radius:0 8px 8px 0;
padding:12px 16px;margin:24px 0}
aside h3{margin:0;color:var(--blue);font-size:.78rem;letter-spacing:.08em;text-transform:uppercase}
aside p{margin:4px 0 0}
figure{margin:24px 0 0}
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
.scroll{overflow-x:auto;background:linear-gradient(90deg,var(--card) 40%,transparent) 0/40px 100%
no-repeat local,linear-gradient(270deg,var(--card) 40%,transparent) 100%/40px 100% no-repeat local,
linear-gradient(90deg,var(--shade),transparent) 0/10px calc(100% - 4px) no-repeat scroll,
linear-gradient(270deg,var(--shade),transparent) 100%/10px calc(100% - 4px) no-repeat scroll}
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
)

INTRO_OF_RUNS = """\
<p>Events to the algorithm as soon as possible: what was kept, how late it was, and why.</p>"""

WORDS_OF_RUNS = """\
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
</dl>"""

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
{intro}
</header>
<main>
{body}
</main>
<footer>
{words}
</footer>
</body>
</html>
"""
