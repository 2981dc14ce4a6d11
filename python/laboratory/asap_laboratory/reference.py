"""The reference study's figures, to be put beside ours: lookups, aggregates, and after steps.

Means of three seeds of 5 s, a fluid simulation in bins of 2 us that was made before this code. What
it called "Deadline L/2" and "Deadline auto" is `DeadBeat`; its reservoir law is `Deadline`. Its
best rows choose their parameters per profile with hindsight.
"""

from __future__ import annotations

import csv
from functools import cache
from pathlib import Path


def per_profile(quantity: str, cost_model: str, contender: str, profile: str) -> float | None:
    """Return score, kept, p99_ms, p50_ms, cpu or packages_per_s of a run; None: not reported."""
    return _table("profiles", 3).get((quantity, cost_model, contender), {}).get(profile)


def aggregate(quantity: str, cost_model: str, contender: str) -> float | None:
    """Return the mean or least score, the worst p99 / L or the mean CPU over the named profiles."""
    return _table("aggregates", 2).get((quantity, contender), {}).get(cost_model)


def step(quantity: str, cost_model: str, contender: str) -> float | None:
    """Return a quantity of the abrupt step in detail: profile steps with slow or slow_ht."""
    return _table("step", 2).get((cost_model, contender), {}).get(quantity)


@cache
def _table(name: str, keys: int) -> dict[tuple[str, ...], dict[str, float]]:
    """Read reference_<name>.csv; the first columns are the keys of a row. Empty: no figure."""
    path = Path(__file__).with_name(f"reference_{name}.csv")
    with path.open(encoding="utf-8", newline="") as lines:
        header, *rows = csv.reader(lines)
    return {
        tuple(row[:keys]): {
            column: float(cell)
            for column, cell in zip(header[keys:], row[keys:], strict=True)
            if cell
        }
        for row in rows
    }
