"""What every result has: one JSON object, a file of it, a row of a table."""

from __future__ import annotations

import importlib
import json
import math
import os
import pickle  # only to ask whether something can be pickled; nothing here reads one
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from asap import _checks
from asap.io.writers import replacing

SCHEMA_VERSION = 1


class Result:
    """A result: summed up and saved as one JSON object."""

    def summary(self) -> dict[str, Any]:
        """Return one JSON object."""
        raise NotImplementedError

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the summary as a JSON file and return its path."""
        file = _checks.new_file("path", path)
        _checks.ending("path", file, (".json",), "give a name that ends in .json")
        with replacing(file) as opened:
            opened.write(json.dumps(self.summary(), allow_nan=False).encode())
        return file


def can_be_pickled(value: Any) -> bool:
    """Return whether pickle takes it; an error of its own ``__reduce__`` is a no."""
    try:
        pickle.dumps(value)
    except Exception:
        return False
    return True


def without_nan(value: Any) -> Any:
    """Return figures as JSON holds them, in dicts and lists too: None for what is not finite."""
    if isinstance(value, dict):
        return {name: without_nan(one) for name, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [without_nan(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def flat(value: Any, name: str = "") -> dict[str, Any]:
    """Flatten dicts in dicts: their names are joined by dots."""
    if not isinstance(value, Mapping):
        return {name: value}
    found: dict[str, Any] = {}
    for key, inner in value.items():
        found |= flat(inner, f"{name}.{key}" if name else str(key))
    return found


def table(runs: Iterable[Any]) -> list[dict[str, Any]]:
    """Return a flat row for each run: the entries of `summary`, such as ``"latency_us.p99"``.

    ``pandas.DataFrame``, ``polars.DataFrame`` and ``csv.DictWriter`` take it.

    Parameters
    ----------
    runs : iterable of Run
        Results of `run`, `simulate`, `map` or `load_run`; inspections too.

    Raises
    ------
    TypeError
        `runs` is no list, or holds something else: name the one run in a list.

    Examples
    --------
    >>> scene = asap.synthetic.FlightOverChairs(duration_s=0.1)
    >>> cost = asap.LinearCost(100, 300)
    >>> runs = [asap.simulate(scene, cost=cost, latency_ms=ms) for ms in (5, 10)]
    >>> [row["latency_bound_us"] for row in asap.table(runs)]
    [5000.0, 10000.0]
    """
    if isinstance(runs, (Result, Mapping)) or not isinstance(runs, Iterable):
        raise TypeError(_checks.named("runs", runs, "give a list of runs"))
    listed = list(runs)
    for run in listed:
        if not hasattr(run, "summary"):
            raise TypeError(_checks.named("runs", run, "give runs; leave out those that failed"))
    return [flat(run.summary()) for run in listed]


def data_frame(columns: Mapping[str, Any] | list[dict[str, Any]]) -> Any:
    """Return a ``pandas.DataFrame`` of columns or of rows."""
    return importlib.import_module("pandas").DataFrame(columns)


@dataclass(frozen=True)
class Named:
    """A scheme or an algorithm as a saved run knows it: by name and parameters."""

    name: str
    parameters: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, thing: Any) -> Named:
        """Describe a live object."""
        # A user's own algorithm may have methods of these names, as a torch.nn.Module has.
        names = getattr(thing, "name", None), getattr(thing, "__name__", None), type(thing).__name__
        parameters = getattr(thing, "parameters", None)
        return cls(
            next(name for name in names if name and isinstance(name, str)),
            _plain(parameters) if isinstance(parameters, Mapping) else {},
        )

    def as_json(self) -> dict[str, Any]:
        """Flatten to one JSON object."""
        first = {"name": self.name}
        return first | self.parameters | first  # a parameter may be called so too


def _plain(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Say them as JSON can: NumPy's numbers as Python's, NaN as None, the rest as text."""
    text = json.dumps(
        dict(parameters), default=lambda one: one.tolist() if hasattr(one, "tolist") else str(one)
    )
    plain: dict[str, Any] = json.loads(text, parse_constant=lambda _: None)
    return plain


def share(part: int, whole: int) -> float:
    """Divide; nan where there is no whole."""
    return part / whole if whole else math.nan
