"""A study's page: Markdown from a template, and the tables it is made of as CSV beside it.

A table is a list of rows; a row is a dict of values by column, None where a value does not exist.
The page is always written from the files, so that both agree.
"""

from __future__ import annotations

import csv
import math
import re
import statistics
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import jinja2

Row: TypeAlias = dict[str, Any]
Rows: TypeAlias = list[Row]
Tables: TypeAlias = dict[str, Rows]
Cell: TypeAlias = Callable[[Row], str]


# ---- tables --------------------------------------------------------------------------------------


def only(rows: Iterable[Row], **values: Any) -> Rows:
    """Return the rows that have these values; a tuple allows any of its elements."""
    wanted = {name: one if isinstance(one, tuple) else (one,) for name, one in values.items()}
    return [row for row in rows if all(row.get(name) in one for name, one in wanted.items())]


def distinct(rows: Iterable[Row], column: str) -> list[Any]:
    """Return the values of a column, each once, in the order of the rows."""
    return list(dict.fromkeys(row[column] for row in rows))


def over_seeds(rows: Iterable[Row], keys: Sequence[str], figures: Sequence[str]) -> Rows:
    """Put the rows that agree in the keys, one for each seed, together.

    A row: the keys, ``seeds``, and of each figure the mean and, as ``<figure>_sd``, the standard
    deviation (n - 1). A figure exists where every seed has it, a deviation from two seeds on.
    """
    groups: dict[tuple[Any, ...], Rows] = {}
    for row in rows:
        groups.setdefault(tuple(row[key] for key in keys), []).append(row)
    found = []
    for key, group in groups.items():
        summary: Row = {**dict(zip(keys, key, strict=True)), "seeds": len(group)}
        for figure in figures:
            values: list[Any] = [row.get(figure) for row in group]
            whole = not any(map(_missing, values))
            several = whole and len(values) > 1
            summary[figure] = statistics.fmean(values) if whole else None
            summary[f"{figure}_sd"] = statistics.stdev(values) if several else None
        found.append(summary)
    return found


def _missing(value: Any) -> bool:
    return value is None or (isinstance(value, float) and math.isnan(value))


def write_tables(folder: Path, study: str, tables: Tables) -> list[Path]:
    """Write the tables as CSV files into the folder ``data``; return their paths."""
    (folder / "data").mkdir(parents=True, exist_ok=True)
    paths = []
    for name, rows in tables.items():
        paths.append(_path(folder, study, name))
        columns = dict.fromkeys(column for row in rows for column in row)
        with paths[-1].open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(columns)
            writer.writerows([_written(row.get(column)) for column in columns] for row in rows)
    return paths


def read_tables(folder: Path, study: str, names: Iterable[str]) -> Tables:
    """Read what `write_tables` has written."""
    tables: Tables = {}
    for name in names:
        with _path(folder, study, name).open(encoding="utf-8", newline="") as file:
            rows = csv.DictReader(file)
            tables[name] = [{key: _read(text) for key, text in row.items()} for row in rows]
    return tables


def _path(folder: Path, study: str, table: str) -> Path:
    return folder / "data" / (f"{study}.csv" if table == study else f"{study}_{table}.csv")


def _written(value: Any) -> Any:
    if _missing(value):
        return ""
    return f"{value:.6g}" if isinstance(value, float) else value


def _read(text: str) -> Any:
    if text in ("", "True", "False"):
        return {"": None, "True": True, "False": False}[text]
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


# ---- cells ---------------------------------------------------------------------------------------


def fixed(value: float | None, digits: int = 3) -> str:
    """Write a number with digits after the point and no zero before it; - where there is none."""
    if value is None:
        return "-"
    return re.sub(r"^(-?)0\.", r"\1.", f"{value:.{digits}f}")


def share(value: float | None) -> str:
    """Write a share of the events, with more digits where three would leave nothing."""
    if value is None or value > 0.01:
        return fixed(value)
    return "0" if value == 0 else re.sub(r"^0\.", ".", f"{value:.1g}")


def short(value: float | None) -> str:
    """Write a quantity with three significant digits; nothing where there is none."""
    if value is None:
        return ""
    return f"{value:.0f}" if value >= 99.5 else f"{value:.3g}"


def spread(figure: str, write: Callable[[float], str] = fixed, unit: str = "") -> Cell:
    """Return what writes the mean of a figure and its deviation over the seeds."""

    def cell(row: Row) -> str:
        both = [row[figure], row.get(f"{figure}_sd")]
        return "±".join(write(value) for value in both if value is not None) + unit

    return lambda row: "-" if row[figure] is None else cell(row)


def figure(name: str, write: Callable[[Any], str] = fixed) -> Cell:
    """Return what writes a column."""
    return lambda row: write(row[name])


# ---- the page ------------------------------------------------------------------------------------


def markdown(head: Sequence[str], lines: Iterable[Sequence[str]], *, numbers: bool = True) -> str:
    """Write a table; numbers stand to the right, but for the first column."""
    ruler = ["---", *["---:" if numbers else "---"] * (len(head) - 1)]
    return "\n".join("| " + " | ".join(line) + " |" for line in (head, ruler, *lines))


def origin(run: Row) -> str:
    """Say what has measured a page's figures: command, date, version, machine, time taken."""
    return (
        f"`{run['command']}`, {run['date']}, asap {run['version']}, {run['machine']}; "
        f"{run['minutes']:.1f} minutes of processor time"
    )


class Writer:
    """Writes a study's tables as its page and as text, by the cells that the study names."""

    def __init__(self, cells: Mapping[str, Cell]) -> None:
        self._cells = cells

    def cell(self, row: Row, name: str) -> str:
        """Write one cell: by its name, else the value as it is."""
        if name in self._cells:
            return self._cells[name](row)
        value = row[name]
        return "" if value is None else f"{value:g}" if isinstance(value, float) else str(value)

    def listing(self, rows: Rows, columns: Mapping[str, str], *, numbers: bool = True) -> str:
        """Write a line for each row; `columns` are headings by cell."""
        lines = [[self.cell(row, name) for name in columns] for row in rows]
        return markdown(list(columns.values()), lines, numbers=numbers)

    def pivot(
        self,
        rows: Rows,
        down: Mapping[str, str],
        across: str,
        name: str,
        *,
        numbers: bool = True,
    ) -> str:
        """Write one cell of the rows: `down` are headings by cell, `across` a column of values."""
        columns = distinct(rows, across)
        lines: dict[tuple[str, ...], dict[Any, str]] = {}
        for row in rows:
            key = tuple(self.cell(row, one) for one in down)
            lines.setdefault(key, {})[row[across]] = self.cell(row, name)
        return markdown(
            [*down.values(), *map(str, columns)],
            [
                [*key, *(cells.get(column, "") for column in columns)]
                for key, cells in lines.items()
                if any(cells.values())
            ],
            numbers=numbers,
        )

    def page(self, template: Path, **values: Any) -> str:
        """Fill a template."""
        environment = jinja2.Environment(
            loader=jinja2.FileSystemLoader(template.parent),
            undefined=jinja2.StrictUndefined,
            trim_blocks=True,
            lstrip_blocks=True,
            keep_trailing_newline=True,
        )
        environment.globals.update(
            pivot=self.pivot, listing=self.listing, only=only, distinct=distinct, origin=origin
        )
        return environment.get_template(template.name).render(**values)
