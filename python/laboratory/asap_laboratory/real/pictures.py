"""Overlays: the events before a labelled time, clusters and boxes over them, as inline SVG."""

from __future__ import annotations

import base64
import io
import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from asap import _core
from asap_laboratory.rivals.recordings import Followed

WINDOW_US = 30_000  # of the events that are shown
_TAIL_S = 0.15
_SIGMAS = 1.5  # of the outlines
_MIN_SIGMA_PX = 0.5
_MAX_PX = 400  # along the longer side of the image of the events
_GREY = (128, 134, 140)  # on the light and on the dark card

STYLE = """
:root{--light:38%}
@media (prefers-color-scheme:dark){:root{--light:66%}}
.overlay{display:block;width:100%;max-height:430px;background:var(--page);border-radius:6px}
.overlay image{image-rendering:pixelated}
.overlay *{vector-effect:non-scaling-stroke}
.overlay .box{fill:none;stroke:var(--ink);stroke-width:.8}
.overlay .box.missed{stroke:var(--vermilion);stroke-width:1.6}
.overlay .zone{fill:var(--faint);fill-opacity:.18}
.id{--own:hsl(var(--hue) 85% var(--light))}
.overlay .id{fill:none;stroke:var(--own);stroke-width:2}
.overlay .id.false{stroke-dasharray:4 3}
.overlay text.id{fill:var(--own);stroke:var(--page);stroke-width:3px;paint-order:stroke;
font-weight:700}
.overlay polyline.id{stroke-width:1.4}
"""


def hue(id: int) -> str:
    """Return the style that gives an id its colour: neighbouring ids differ most."""
    return f"--hue:{137.508 * id % 360:.0f}"


def overlay(followed: Followed, index: int, label: str) -> str:
    """Draw a labelled time: events grey, outlines, ids and tails coloured, boxes thin.

    `label`: what the picture shows, for those who do not see it; without markup.
    """
    scene = followed.scene
    parts = [_events(followed, index), *_zones(followed, index), *_boxes(followed, index)]
    parts += [*_tails(followed, index), *_outlines(followed, index)]
    return (
        f'<svg class="overlay" viewBox="0 0 {scene.width} {scene.height}" role="img" '
        f'aria-label="{label}">{"".join(parts)}</svg>'
    )


def _events(followed: Followed, index: int) -> str:
    scene = followed.scene
    t_us = int(followed.matches[index].frame["t_us"][0])
    first, end = np.searchsorted(scene.events["t"], [t_us - WINDOW_US, t_us])
    shown = scene.events[first:end]
    step = math.ceil(max(scene.width, scene.height) / _MAX_PX)
    pixels = np.zeros((-(-scene.height // step), -(-scene.width // step)), np.uint8)
    pixels[shown["y"] // step, shown["x"] // step] = 1
    width, height = pixels.shape[1] * step, pixels.shape[0] * step
    return f'<image width="{width}" height="{height}" href="{_png(pixels)}"/>'


def _png(pixels: NDArray[np.uint8]) -> str:
    image = Image.fromarray(pixels)
    image.putpalette([0, 0, 0, *_GREY])
    file = io.BytesIO()
    image.save(file, "png", optimize=True, bits=1, transparency=0)
    return "data:image/png;base64," + base64.b64encode(file.getvalue()).decode()


def _zones(followed: Followed, index: int) -> Iterator[str]:
    t_us = followed.matches[index].frame["t_us"][0]
    for x0, x1, y0, y1, from_us, to_us in followed.scene.ignore.tolist():
        if from_us <= t_us < to_us:
            yield _rectangle("zone", x0, y0, x1 - x0, y1 - y0)


def _boxes(followed: Followed, index: int) -> Iterator[str]:
    match = followed.matches[index]
    matched = {row for row, _ in match.pairs}
    for row, (x, y, w, h) in enumerate(match.frame[["x", "y", "w", "h"]].tolist()):
        yield _rectangle("box" if row in matched else "box missed", x, y, w, h)


def _rectangle(css_class: str, x: float, y: float, w: float, h: float) -> str:
    size = f'width="{w:.1f}" height="{h:.1f}"'
    return f'<rect class="{css_class}" x="{x:.1f}" y="{y:.1f}" {size}/>'


def _tails(followed: Followed, index: int) -> Iterator[str]:
    times_s = followed.times_s
    since = int(np.searchsorted(times_s, times_s[index] - _TAIL_S))
    for id in followed.found[index]["id"].tolist():
        rows = [table[table["id"] == id] for table in followed.found[since : index + 1]]
        points = [f"{row['x'][0]:.1f},{row['y'][0]:.1f}" for row in rows if row.size]
        if len(points) > 1:
            yield f'<polyline class="id" style="{hue(id)}" points="{" ".join(points)}"/>'


def _outlines(followed: Followed, index: int) -> Iterator[str]:
    scene, table = followed.scene, followed.found[index]
    false = {int(table["id"][row]) for row in followed.matches[index].false}
    judged = scene.background_labelled
    letter_px = max(scene.width, 1.3 * scene.height) / 24
    for row in table:
        id = int(row["id"])
        own = f'class="id{" false" if judged and id in false else ""}" style="{hue(id)}"'
        shape, right, top = _shape(row, own)
        yield shape
        right = min(right, scene.width - letter_px * 0.62 * len(str(id)))
        top = min(max(top, letter_px), scene.height - 2.0)
        yield (
            f'<text class="id" style="{hue(id)}" font-size="{letter_px:.1f}" '
            f'x="{max(right, 0.0):.1f}" y="{top:.1f}">{id}</text>'
        )


def _shape(row: np.void, own: str) -> tuple[str, float, float]:
    """Draw the box of an object or the ellipse of a cluster; return its upper right corner, px."""
    if "left" in (row.dtype.names or ()):
        x, y, width, height = (float(row[name]) for name in ("left", "top", "width", "height"))
        place = f'x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}"'
        return f"<rect {own} {place}/>", x + width, y
    x, y = float(row["x"]), float(row["y"])
    long_px, short_px, degrees = _axes(row)
    turn = f"translate({x:.1f} {y:.1f}) rotate({degrees:.0f})"
    shape = f'<ellipse {own} rx="{long_px:.1f}" ry="{short_px:.1f}" transform="{turn}"/>'
    return shape, x + 0.7 * long_px, y - 0.7 * short_px


def _axes(cluster: np.void) -> tuple[float, float, float]:
    """Half axes of a cluster's outline, px, and the angle of the longer one, degrees."""
    fields = ("x", "y", "cxx", "cxy", "cyy")
    outline = _core.outline_of(*(float(np.nan_to_num(cluster[field])) for field in fields))
    long_px, short_px = (
        _SIGMAS * max(float(outline[axis]) / 2, _MIN_SIGMA_PX) for axis in ("major", "minor")
    )
    return long_px, short_px, math.degrees(outline["angle"])
