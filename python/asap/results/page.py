"""Results as one self-contained HTML page: table, verdict and figure, and the numbers as JSON.

No script, no font and no image from outside; the page forbids them to itself (content security
policy). Every value is escaped. Needs matplotlib and Jinja2: ``asap-events[report]``.
"""

from __future__ import annotations

import base64
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from asap import _checks, _units
from asap.io.writers import replacing
from asap.results import html
from asap.results.comparison import COLUMNS, Comparison
from asap.results.result import flat
from asap.results.run import Run, parameter_value, run_title

try:
    import jinja2
except ImportError as error:
    raise ImportError("a page needs jinja2: install asap-events[report]") from error

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LONGEST = 200  # characters of a text, elements of a list

_TEMPLATES = jinja2.Environment(
    loader=jinja2.FileSystemLoader(Path(__file__).parent), autoescape=True, trim_blocks=True
)
_TEMPLATES.policies["json.dumps_kwargs"] = {"allow_nan": False, "separators": (",", ":")}


@dataclass(frozen=True)
class Article:
    """What a page says about one result.

    Attributes
    ----------
    kind : str
        The numbers stand in ``<template data-KIND>``.
    numbers : dict
        The summary, embedded as JSON.
    html : str
        Table and verdict, escaped.
    figure : Figure or None
        Drawn below them.
    caption : str
        What the figure shows.
    details : dict of str to str
        Headings, and the HTML that each of them folds away.
    """

    kind: str
    numbers: Any
    html: str
    figure: Figure | None = None
    caption: str = ""
    details: Mapping[str, str] = field(default_factory=dict)

    @property
    def image(self) -> str:
        """The figure as the address of an image."""
        assert self.figure is not None
        from asap import plots

        drawn = plots.svg(self.figure).encode("utf-8", "replace")
        return f"data:image/svg+xml;base64,{base64.b64encode(drawn).decode()}"

    @property
    def widths(self) -> str:
        """Style of the image: letters of 9 pt are 9 px high at least, and 16 px at most."""
        assert self.figure is not None
        inches = self.figure.get_figwidth()
        return f"min-width: {72 * inches:.0f}px; max-width: {128 * inches:.0f}px"


def write(
    path: str | os.PathLike[str],
    title: str,
    articles: Iterable[Article],
    *,
    above: str = "",
    style: str = "",
) -> Path:
    """Write a page and return its path; `above` is HTML, `style` CSS, both of the caller's own."""
    file = _checks.page_file("path", path)
    template = _TEMPLATES.get_template("page.html")
    page = template.render(title=title, articles=articles, above=above, style=style)
    with replacing(file) as opened:
        opened.write(page.encode(errors="replace"))  # a file name may be no text
    return file


def write_runs(
    runs: Run | Sequence[Run], path: str | os.PathLike[str], title: str = "ASAP report"
) -> Path:
    """Write one page about one or several finished runs."""
    runs = list(runs) if isinstance(runs, Sequence) else [runs]
    if not runs:
        raise ValueError("runs = []: give at least one run")
    file = _checks.page_file("path", path)
    above = _side_by_side(runs) if len(runs) > 1 else ""
    return write(file, title, chain.from_iterable(map(_articles_of_run, runs)), above=above)


def write_comparison(
    comparison: Comparison, path: str | os.PathLike[str], title: str = "ASAP comparison"
) -> Path:
    """Write one page about a comparison."""
    return write(path, title, _articles_of_comparison(comparison))


def _articles_of_run(run: Run) -> Iterator[Article]:
    summary = _shortened(run.summary())
    yield Article(
        "run",
        summary,
        run._repr_html_(),
        None if run.without_log else run.plot(),
        "What the closed loop did: rates and shares in windows of time, the rest by package.",
        {"All numbers of this run": html.table((), _all_numbers(summary))},
    )
    tracks = getattr(run.algorithm, "tracks", None)
    if isinstance(tracks, np.ndarray) and {"id", "x", "y"} <= set(tracks.dtype.names or ()):
        from asap import plots

        found = int(np.unique(tracks["id"]).size)
        drawn: Any = plots.tracks(tracks, events=getattr(run.algorithm, "seen", None)).figure
        yield Article(
            "tracks",
            {"tracks": found, "rows": int(tracks.size)},
            html.heading(f"Tracks of {_units.count(found)} objects"),
            drawn,
            "Where the objects went, the 40 longest tracks in colour and named at their ends. "
            "Grey: some of the events.",
        )


def _side_by_side(runs: Sequence[Run]) -> str:
    head = ("run", "kept", "in time", "p50", "p99", "max", "overflow")
    rows = [
        (
            run_title(run.summary()),
            _units.share(run.kept),
            _units.share(run.in_time),
            *(_units.duration(run.latency.quantile(q)) for q in (0.5, 0.99)),
            _units.duration(run.latency.max),
            _units.count(run.ledger.overflow),
        )
        for run in runs
    ]
    return html.heading("Side by side") + html.table(head, rows)


def _articles_of_comparison(comparison: Comparison) -> Iterator[Article]:
    parameters = (
        (
            row.label,
            row.scheme,
            ", ".join(
                f"{name} {parameter_value(value)}"
                for name, value in comparison.runs[row.label].scheme.parameters.items()
            ),
        )
        for row in comparison.rows
    )
    yield Article(
        "comparison",
        comparison.summary(),
        comparison._repr_html_(),
        comparison.plot(),
        "Every scheme over time: the largest latency of the events of each moment, and the share "
        "of the events that was finished. Latencies beyond 100 L are drawn at 100 L.",
        {
            "What the columns say": html.table((), COLUMNS.items()),
            "The schemes and their parameters": html.table((), parameters),
        },
    )


def _shortened(value: Any) -> Any:
    """Cut long texts and lists, such as the weights of a user's algorithm, to fit on a page."""
    if isinstance(value, Mapping):
        few = list(value.items())[:_LONGEST]
        return {_shortened(name): _shortened(inner) for name, inner in few}
    if isinstance(value, (str, list, tuple)) and len(value) > _LONGEST:
        more: Any = "..." if isinstance(value, str) else ["..."]
        value = (value if isinstance(value, str) else list(value))[:_LONGEST] + more
    return [_shortened(inner) for inner in value] if isinstance(value, (list, tuple)) else value


def _all_numbers(summary: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    for name, value in flat(summary).items():
        yield name, f"{value:.6g}" if isinstance(value, float) else str(value)
