"""Run.animate: events, clusters with their tracks and the loop's figures, as GIF or MP4.

Needs Pillow, which comes with ``asap-events[report]``, and for MP4 the program ffmpeg.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from collections import deque
from collections.abc import Iterator
from contextlib import suppress
from itertools import chain, pairwise
from pathlib import Path
from typing import IO, Any

import numpy as np

from asap import _checks, _units
from asap.io.writers import replacing
from asap.results.run import Run
from asap.viewer.pictures import BRIGHT, COLOURS, FRAME_US, frames, outlines_of, painted

try:
    from PIL import Image, ImageDraw, ImageFont
except ImportError as error:
    raise ImportError("an animation needs Pillow: install asap-events[report]") from error

_TRAIL = 16  # frames
_WIDE = 600  # px, about
_STRIP = 34  # px, below the picture
_INK, _GOOD, _BAD = (214, 220, 228), (94, 230, 166), (255, 92, 92)
_SHADES = [  # of each colour, from itself to the background
    [tuple(np.linspace(colour, COLOURS[0], 5)[step].astype(int).tolist()) for step in range(4)]
    for colour in (*BRIGHT, _INK, _GOOD, _BAD)
]


def check_name(path: Path) -> None:
    """Refuse a path that `write` does not write to."""
    _checks.ending("path", path, (".gif", ".mp4"), "give a name that ends in .gif or .mp4")
    if path.suffix.lower() == ".mp4" and shutil.which("ffmpeg") is None:
        raise RuntimeError("an MP4 needs the program ffmpeg, which is not installed; give a .gif")


def write(run: Run, path: str | os.PathLike[str]) -> Path:
    """Write the file and return its path."""
    file = _checks.new_file("path", path)
    check_name(file)
    if not hasattr(run.algorithm, "seen"):
        remedy = "holds no pictures; run with algorithm=asap.Tracks(asap.ClusterTracker(...))"
        raise ValueError(_checks.named("run", run, remedy))
    write_frames = _write_mp4 if file.suffix.lower() == ".mp4" else _write_gif
    with replacing(file) as opened:
        write_frames(_frames(run), opened)
    return file


def _write_gif(frames: Iterator[Any], file: IO[bytes]) -> None:
    palette = Image.new("P", (1, 1))
    colours = [*COLOURS, *chain.from_iterable(_SHADES)]
    palette.putpalette([part for colour in colours for part in colour])
    few = (frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames)
    options = {"save_all": True, "append_images": few, "duration": FRAME_US // 1000, "loop": 0}
    next(few).save(file, "GIF", **options)


def _write_mp4(frames: Iterator[Any], file: IO[bytes]) -> None:
    first = next(frames)
    size = f"{first.width}x{first.height}"
    source = f"-f rawvideo -pix_fmt rgb24 -s {size} -r {10**6 // FRAME_US} -i -".split()
    target = ["-pix_fmt", "yuv420p", "-movflags", "+faststart", "-f", "mp4"]
    command = ["ffmpeg", "-y", "-loglevel", "error", *source, *target, os.path.abspath(file.name)]
    with subprocess.Popen(command, stdin=subprocess.PIPE) as process:
        pipe: Any = process.stdin
        with suppress(BrokenPipeError), pipe:  # its code tells what was wrong
            for frame in chain([first], frames):
                pipe.write(frame.tobytes())
    if process.returncode:
        raise RuntimeError(f"{file.name}: ffmpeg ended with code {process.returncode}")


def _frames(run: Run) -> Iterator[Any]:
    """Draw a picture for each 40 ms of the recording."""
    seen = run.algorithm.seen
    width = int(run.source["width"] or seen["x"].max(initial=0) + 1)
    height = int(run.source["height"] or seen["y"].max(initial=0) + 1)
    scale = max(1, round(_WIDE / width))
    size = width * scale // 2 * 2, (height * scale + _STRIP) // 2 * 2  # an MP4 has even sides
    font = ImageFont.load_default(14)
    trails: dict[int, deque[tuple[float, float]]] = {}
    for now_s, rows, events, found in frames(run, run.packages):
        pixels = np.array(COLOURS, np.uint8)[painted(events, (height, width))]
        picture = Image.new("RGB", size, COLOURS[0])
        picture.paste(Image.fromarray(pixels).resize((width * scale, height * scale), 0))
        draw = ImageDraw.Draw(picture)
        trails = {one: trails.get(one, deque(maxlen=_TRAIL)) for one in found["id"].tolist()}
        for one, outline in zip(found, outlines_of(found)["outline"] * scale, strict=True):
            number, (x, y) = int(one["id"]), (float(one["x"] * scale), float(one["y"] * scale))
            shades = _SHADES[number % len(BRIGHT)]
            trails[number].append((x, y))
            for age, way in enumerate(pairwise(reversed(trails[number]))):
                draw.line(way, shades[age * len(shades) // _TRAIL], 2)
            draw.line([tuple(corner) for corner in outline.tolist()], shades[0], 2, "curve")
            draw.text((x + 5, y + 3), str(number), shades[0], font)
        _write_figures(draw, size, font, now_s, rows, run.latency_bound_us)
        yield picture


def _write_figures(
    draw: Any, size: tuple[int, int], font: Any, now_s: float, rows: Any, bound_us: float
) -> None:
    """Write the time, what enters, what is kept, and the worst latency beside its bound."""
    words = [(f"{now_s:.2f} s", _INK)]
    if len(rows):
        gamma = rows["size"].sum() / (rows["size"] / rows["gamma"]).sum()
        worst_us = float(rows["latency_max_us"].max())
        latency = f"latency {_units.duration(worst_us)} of {_units.duration(bound_us)}"
        words += [
            (_units.rate(float(rows["event_rate"].mean())), _INK),
            (f"gamma {_units.share(gamma)}", _INK),
            (latency, _GOOD if worst_us <= bound_us else _BAD),
        ]
    for (text, colour), place in zip(words, (0.02, 0.18, 0.38, 0.62), strict=False):
        draw.text((place * size[0], size[1] - _STRIP + 9), text, colour, font)
