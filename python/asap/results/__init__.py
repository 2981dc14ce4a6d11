"""What runs, comparisons and inspections found: their data, with text, figure and page at hand.

The modules below go in one direction: `cost`, `data`, `saved` and `numbers`, `text`, `figures`,
`page`. Figures and pages need the extra `report`, so they are imported when they are asked for.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from asap import _checks
from asap.results import data, saved, text
from asap.results.data import Finding, Ledger, Named, Row, table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "Comparison",
    "Finding",
    "Inspection",
    "Ledger",
    "Named",
    "Row",
    "Run",
    "load_run",
    "table",
]


class Run(data.Run):  # noqa: D101 (it has that of the data)
    __doc__ = data.Run.__doc__

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write a file and return its path: ``.npz`` holds log and summary, ``.json`` the summary.

        `asap.load_run` and ``asap report`` read both. Only the ``.npz`` brings back the packages,
        and with them the curves and the verdict.
        """
        file = _checks.new_file("path", path)
        saved.check_name(file)
        _checks.other_file("path", file, self.source["path"])
        if file.suffix.lower() == ".json":
            return super().save(file)
        saved.write(self, file)
        return file

    def plot(self) -> Figure:
        """Draw the paper's figure: package size, R, gamma, margin and latency over time."""
        from asap.results import figures

        return figures.figure(self)

    def report(self, path: str | os.PathLike[str]) -> Path:
        """Write one self-contained HTML page and return its path; needs the extra `report`."""
        from asap.results import page

        return page.write_runs(self, path)

    def animate(self, path: str | os.PathLike[str]) -> Path:
        """Write events and clusters over time as ``.gif`` or ``.mp4`` and return its path.

        In real time, of a run whose algorithm was an `asap.Tracks`. Needs the extra `report`, and
        for MP4 the program ffmpeg.
        """
        from asap.results import animation

        return animation.write(self, path)

    def _repr_html_(self) -> str:
        return text.run_html(self)

    def __str__(self) -> str:
        return text.format_run(self)


def load_run(path: str | os.PathLike[str]) -> Run:
    """Read a run that `Run.save` wrote, or the summary that ``asap run --json`` printed.

    From a ``.npz`` come log and summary; from a ``.json`` the summary alone: `packages` is empty,
    `without_log` is True, and `latency` knows the quantiles 0.5, 0.99 and 1. Scheme and algorithm
    come back as names and parameters. Nothing is unpickled, and sizes are checked before memory is
    taken.

    Raises
    ------
    ValueError
        The file holds no run, or one of another version.
    OSError
        The file cannot be read, or is a pipe, a socket or a device.
    """
    return saved.read(_checks.folder_or_file("path", path), Run)


class Comparison(data.Comparison):  # noqa: D101 (it has that of the data)
    __doc__ = data.Comparison.__doc__
    runs: Mapping[str, Run]

    def plot(self) -> Figure:
        """Draw latency and kept share over time, a row of the figure for each scheme."""
        from asap.results import figures

        return figures.comparison_figure(self)

    def report(self, path: str | os.PathLike[str]) -> Path:
        """Write one self-contained HTML page and return its path; needs the extra `report`."""
        from asap.results import page

        return page.write_comparison(self, path)

    def _repr_html_(self) -> str:
        return text.comparison_html(self)

    def __str__(self) -> str:
        return text.format_comparison(self)


class Inspection(data.Inspection):  # noqa: D101 (it has that of the data)
    __doc__ = data.Inspection.__doc__

    def plot(self) -> Figure:
        """Draw the rate over time and the map of the pixels; needs matplotlib."""
        from asap.results import figures

        return figures.inspection_figure(self)

    def report(self, path: str | os.PathLike[str]) -> Path:
        """Write one self-contained HTML page and return its path; needs the extra `report`."""
        from asap.results import page

        return page.write_inspection(self, path)

    def _repr_html_(self) -> str:
        return text.inspection_html(self)

    def __str__(self) -> str:
        return text.format_inspection(self)
