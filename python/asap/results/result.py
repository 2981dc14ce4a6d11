"""What the results have in common: Run, Comparison, Inspection and KeepCurve."""

from __future__ import annotations

import json
import math
import os
import pickle  # only to ask whether something can be pickled; nothing here reads one
from pathlib import Path
from typing import TYPE_CHECKING, Any

from asap import _checks

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Result:
    """A result: summed up, saved, drawn, as one page, and as a table in a notebook."""

    def summary(self) -> dict[str, Any]:
        """Return one JSON object."""
        raise NotImplementedError

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the summary as a JSON file and return its path."""
        file = _checks.new_file("path", path)
        _checks.ending("path", file, (".json",), "give a name that ends in .json")
        file.write_text(json.dumps(self.summary(), allow_nan=False), encoding="utf-8")
        return file

    def plot(self) -> Figure:
        """Draw a figure; needs matplotlib."""
        raise NotImplementedError

    def report(self, path: str | os.PathLike[str]) -> Path:
        """Write one self-contained HTML page and return its path; needs matplotlib."""
        raise NotImplementedError

    def _repr_html_(self) -> str:
        """Return a table and the verdict, as a notebook shows them."""
        raise NotImplementedError


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
