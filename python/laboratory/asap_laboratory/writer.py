"""The writer of all studies' documents: a page of text and tables, its data as CSV beside it."""

from __future__ import annotations

import csv
import datetime
import os
import platform
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from asap import _core


def write(
    path: Path,
    title: str,
    opening: str,
    sections: Iterable[str],
    data: Iterable[Mapping[str, Any]],
    *,
    command: str,
    seconds: float,
    notes: str = "",
    lead: Iterable[str] = (),
) -> list[Path]:
    """Write a document and its data; return their paths, the document first.

    Parameters
    ----------
    path : Path
        A Markdown file; its folder exists. The data get its name with .csv.
    title, opening : str
        Its heading; what was asked, and the figure that answers it.
    sections : iterable of str
        What follows, as Markdown.
    data : iterable of mappings
        One row for each measurement, value by column; a row may leave columns out.
    command : str
        What has to be typed to get the same.
    seconds : float
        Processor time of all runs.
    notes : str
        Stands behind command, date and machine.
    lead : iterable of str
        Stands before them: pictures, a verdict.
    """
    parts = [f"# {title}", opening, *lead, f"{origin(command, seconds)}{notes}.", *sections]
    path.write_text("\n\n".join(parts) + "\n", encoding="utf-8")
    rows = list(data)
    columns = dict.fromkeys(column for row in rows for column in row)
    table = path.with_suffix(".csv")
    with table.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(columns), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    return [path, table]


def pictures(figures: Iterable[Path]) -> list[str]:
    """Show figures that stand beside the document."""
    return [f"![{figure.stem.replace('_', ' ')}]({figure.name})" for figure in figures]


def origin(command: str, seconds: float) -> str:
    """Say what has measured a document's figures: command, date, version, machine, time taken."""
    date = datetime.date.today().isoformat()
    machine = f"{_processor()}, {os.cpu_count()} cores, {platform.system()} {platform.machine()}"
    version = f"asap {_core.__version__}"
    minutes = f"{seconds / 60:.1f} minutes of processor time"
    return f"`{command}`, {date}, {version}, {machine}; {minutes}"


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or "unknown processor"
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.processor() or "unknown processor")
