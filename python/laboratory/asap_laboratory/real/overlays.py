"""One self-contained HTML page: the table, then each recording as a strip of overlays.

A strip is swiped picture by picture; above it a lane for each object shows which id carried it, and
when it was missed. No script.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from html import escape
from pathlib import Path

import numpy as np

from asap.results import html
from asap.results import page as pages
from asap_laboratory.real.mistakes import Span, mistakes, spans
from asap_laboratory.real.pictures import STYLE, hue, overlay
from asap_laboratory.rivals.recordings import CELLS, HEAD, Followed

_MAX_PICTURES = 12  # of each recording

_STYLE = (
    STYLE
    + """
.strip{display:flex;gap:12px;overflow-x:auto;scroll-snap-type:x mandatory;margin:18px 0 0;
padding:0 0 10px}
.strip figure{flex:0 0 min(100%,420px);scroll-snap-align:start}
.lanes{display:grid;grid-template-columns:max-content 1fr;gap:4px 10px;margin:18px 0 0;
font-size:.85rem;align-items:center}
.lane{position:relative;height:12px;border-radius:3px;background:var(--page)}
.lane i{position:absolute;top:0;bottom:0;background:var(--own);border-right:1px solid var(--card)}
.lane i.missed{background:var(--vermilion);top:4px;bottom:4px}
.lane i.extra{background:var(--faint)}
.wrong{padding-left:1.2em;font-size:.9rem}
.wrong li{margin:3px 0}
"""
)

_WORDS = """\
<h3>Reading the pictures</h3>
<dl>
<dt>grey</dt><dd>events of the 30 ms before the labelled time</dd>
<dt>coloured box, number, line</dt><dd>an object, its id, its way in the last 150 ms; dashed: no
truth goes with it</dd>
<dt>thin box</dt><dd>the truth; orange: missed; shaded: nothing is judged there</dd>
<dt>lanes</dt><dd>for each object the ids that carried it, in their colours, over the labelled time;
a thin orange line: missed; others: times with an object that no box goes with</dd>
<dt>hit, MOTA</dt><dd>boxes with the centre of an object inside or up to 2 px beyond; 1 - (misses +
false + switches) / boxes</dd>
</dl>"""


def write(
    path: Path, sets: Sequence[Followed], *, left_out: Sequence[str] = (), command: str
) -> Path:
    """Write the page; `left_out`: why recordings are not on it; `command`: what gives the same."""
    table = html.table(tuple(HEAD.values()), [_cells(one) for one in sets])
    notes = "".join(f'<p class="sub">Left out: {escape(words)}</p>' for words in left_out)
    return pages.write(
        path,
        "The cluster tracker on recordings",
        map(_article, sets),
        above=f"<p>asap.ClusterTracker as it comes, beside hand-made boxes. {escape(command)}</p>"
        f"{table}{notes}{_WORDS}",
        style=_STYLE,
    )


def _cells(followed: Followed) -> tuple[str, ...]:
    figures = {name: None if value != value else value for name, value in followed.figures.items()}
    row = {"set": followed.scene.name, **figures}
    return tuple(CELLS[name](row) if name in CELLS else f"{row[name]}" for name in HEAD)


def _article(followed: Followed) -> pages.Article:
    scene = followed.scene
    facts = f"{scene.width} x {scene.height} px, camera {scene.camera}, {scene.events.size} events"
    wrong = "".join(f"<li>{escape(words)}</li>" for words in mistakes(followed))
    return pages.Article(
        "recording",
        {"name": scene.name, "labelled_times": len(followed.matches)},
        f"""<h2>{escape(scene.name)}</h2>
<p class="sub">{escape(facts)}, {len(followed.matches)} labelled times</p>
<div class="lanes">{"".join(_lanes(followed))}</div>
<div class="strip">{"".join(_figures(followed))}</div>
<h3>What went wrong</h3>
<ul class="wrong">{wrong or "<li>nothing</li>"}</ul>""",
    )


def _figures(followed: Followed) -> Iterator[str]:
    shown = np.linspace(0, len(followed.matches) - 1, _MAX_PICTURES).round().astype(int)
    for index in sorted(set(shown.tolist())):
        words = _caption(followed, index)
        drawn = overlay(followed, index, escape(f"{followed.scene.name}, {words}"))
        yield f"<figure>{drawn}<figcaption>{escape(words)}</figcaption></figure>"


def _caption(followed: Followed, index: int) -> str:
    match = followed.matches[index]
    missed = len(match.frame) - len(match.pairs)
    others = [f"{missed} missed"] if missed else []
    if match.false and followed.scene.background_labelled:
        others.append(f"{len(match.false)} false")
    others += [f"{len(match.switched)} with a new id"] if match.switched else []
    hits = f"{len(match.pairs)} of {len(match.frame)} hit"
    return f"{followed.times_s[index]:.3f} s: " + ", ".join([hits, *others])


def _lanes(followed: Followed) -> Iterator[str]:
    """One lane for each object, and one for the clusters without a box."""
    carried: dict[int, dict[int, int | None]] = {}
    for index, match in enumerate(followed.matches):
        ids = {row: int(match.found.ids[column]) for row, column in match.pairs}
        for row, label in enumerate(match.frame["id"].tolist()):
            carried.setdefault(label, {})[index] = ids.get(row)
    for label, by_time in sorted(carried.items()):
        pieces = ""
        for id, _ in Counter(by_time.values()).most_common():
            own = 'class="missed"' if id is None else f'class="id" title="id {id}"'
            style = "" if id is None else hue(id)
            for span in spans(index for index, other in by_time.items() if other == id):
                pieces += f'<i {own} style="{_place(followed, span)};{style}"></i>'
        yield f'<span>object {label}</span><div class="lane">{pieces}</div>'
    if followed.scene.background_labelled:
        extra = spans(index for index, match in enumerate(followed.matches) if match.false)
        pieces = "".join(f'<i class="extra" style="{_place(followed, one)}"></i>' for one in extra)
        yield f'<span>others</span><div class="lane">{pieces}</div>'


def _place(followed: Followed, span: Span) -> str:
    """Left edge and width in a lane; a labelled time lasts until the next one."""
    times_s = followed.times_s
    period_s = float(np.median(np.diff(times_s))) if times_s.size > 1 else 1.0
    whole_s = times_s[-1] - times_s[0] + period_s
    left = (times_s[span.first] - times_s[0]) / whole_s
    width = (times_s[span.last] - times_s[span.first] + period_s) / whole_s
    return f"left:{left:.2%};width:{width:.2%}"
