"""compare and oracle: every scheme on the same events, beside the best of any scheduler."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

from asap import _checks, _core
from asap.experiment.contenders import labelled, of_schemes, user_schemes
from asap.experiment.runners import Progress
from asap.experiment.side_by_side import CheckedStream, side_by_side
from asap.results import Comparison, Row
from asap.synthetic import joined

_DEFAULT_LATENCY_MS = 10.0


def compare(
    source: Any,
    *,
    cost: _core.LinearCost,
    schemes: Any = None,
    latency_ms: float | None = None,
    seed: int = 0,
    opaque: bool = False,
    speed: float = 1.0,
    width: int | None = None,
    height: int | None = None,
    on_bad: str = "drop",
    capacity: int | None = None,
    on_progress: Progress | None = None,
) -> Comparison:
    """Put every scheme to the same events in virtual time, beside the oracle.

    Repeatable bit for bit; each run is that of `simulate`. The source is read once, in flat memory.

    Parameters
    ----------
    source : path, Recording, array or list of arrays
        One that can be read again: the figures of a comparison can be checked.
    cost : LinearCost
        The simulated algorithm, the same for all.
    schemes : mapping of str to Scheme, or sequence of Scheme, optional
        Default: those that a user chooses from.
    latency_ms : float, optional
        The latency bound of all, ms. Default: the schemes' own, else 10.
    seed : int
        Of the gamma filters.
    opaque : bool
        As in `simulate`; schemes are then scored against an oracle that does so too.
    speed : float
        10 compresses the stamps by ten: a quiet recording becomes one that overloads the algorithm.
    width, height, on_bad, capacity
        As in `simulate`; each scheme has a ring of its own.
    on_progress : callable, optional
        Called as on_progress(done, total or None, {}) between chunks.

    Returns
    -------
    Comparison

    Raises
    ------
    ValueError
        A bad argument, named with its value and the remedy: two different bounds, a generator.

    Notes
    -----
    Metrics: notebooks/theory.md, section 10; oracle: section 9.
    """
    _check_cost(cost)
    _require_replayable(source)
    _checks.flag("opaque", opaque)
    _checks.callback("on_progress", on_progress)
    given = {} if schemes is None else labelled(schemes)
    bound_ms = _common_bound_ms(given.values(), latency_ms)
    contenders = user_schemes() if schemes is None else of_schemes(given)
    if opaque:
        contenders = [replace(one, opaque=True) for one in contenders]
    stream = CheckedStream(source, width=width, height=height, on_bad=on_bad, speed=speed)
    found = side_by_side(
        stream,
        contenders,
        cost=cost,
        latency_ms=bound_ms,
        seed=seed,
        capacity=capacity,
        on_progress=on_progress,
    )
    best = found.opaque_oracle if opaque else found.oracle
    runs = {one.label: run for one, run in zip(contenders, found.runs, strict=True)}
    rows = sorted(
        (Row.of(label, run, best) for label, run in runs.items()),
        key=lambda row: (-round(row.score, 3), row.p99_us),
    )
    described = found.runs[0].source
    return Comparison(
        rows=rows,
        oracle=best,
        exact=found.exact,
        runs={row.label: runs[row.label] for row in rows},
        source=described,
        name=os.path.basename(described["path"] or "") or described["format"],
        cost=cost,
        latency_ms=float(bound_ms),
        opaque=bool(opaque),
        speed=stream.speed,
        seed=int(seed),
    )


def oracle(
    source: Any,
    *,
    cost: _core.LinearCost,
    latency_ms: float,
    exact: bool = False,
    opaque: bool = False,
    speed: float = 1.0,
    width: int | None = None,
    height: int | None = None,
    on_bad: str = "drop",
) -> float:
    """Count the events that the best possible scheduler finishes within a latency bound.

    Parameters
    ----------
    source : path, Recording, array or iterable of arrays
        Read once.
    cost : LinearCost
        The simulated algorithm.
    latency_ms : float
        The latency bound, ms. An event that ends at the bound is in time.
    exact : bool
        False: the fluid bound OB(L), in flat memory. True: the exact clairvoyant EC(L), which pays
        for whole packages and is therefore reached. It takes the mean cost, without drift and
        outages. 10^5 events at 300 per bound take seconds; the work grows with the events and with
        the square of the events per bound.
    opaque : bool
        True: the algorithm takes a package as a whole. OB depends on it where the cost has noise;
        EC does not.
    speed, width, height, on_bad
        As in `compare`.

    Returns
    -------
    float
        Events. No scheduler that does not know the random part of the cost finishes more, whatever
        it discards and however well it knows the arrivals. With `exact` an int.

    Raises
    ------
    ValueError
        A bad argument, named with its value and the remedy; with `exact`, more events than can be
        solved, with the number that fits.

    Notes
    -----
    notebooks/theory.md, section 9. With noise OB is a bound in expectation.
    """
    _check_cost(cost)
    for name, value in (("exact", exact), ("opaque", opaque)):
        _checks.flag(name, value)
    bound_us = _core.checked_latency_ms(latency_ms) * 1e3
    stream = CheckedStream(source, width=width, height=height, on_bad=on_bad, speed=speed)
    if exact:
        return _core.exact_clairvoyant(joined(list(stream)), cost, bound_us)
    found = _core.Oracle(cost, bound_us, opaque=opaque)
    for chunk in stream:
        found.feed(chunk)
    return float(found.bound)


def _check_cost(cost: Any) -> None:
    if not isinstance(cost, _core.LinearCost):
        raise TypeError(_checks.named("cost", cost, "give asap.LinearCost(alpha_us, beta_ns)"))


def _require_replayable(source: Any) -> None:
    """Refuse what can be read only once: each scheme reads it again."""
    if isinstance(source, Iterator):
        raise ValueError(
            f"source = {source!r}: it can be read only once; give a path, an array, a list of "
            "arrays or anything that iterates anew, such as list(source)"
        )


def _common_bound_ms(schemes: Iterable[_core.Scheme], latency_ms: float | None) -> float:
    """Find the one bound of all: the user's, else the schemes' own, else 10 ms."""
    if latency_ms is not None:
        latency_ms = _core.checked_latency_ms(latency_ms)
    own = (scheme.parameters.get("latency_ms") for scheme in schemes)
    bounds = {bound for bound in (*own, latency_ms) if bound is not None}
    if len(bounds) > 1:
        raise ValueError(
            f"latency_ms = {', '.join(f'{bound:g}' for bound in sorted(bounds))}: two different "
            "bounds; a score compares schemes at one"
        )
    return bounds.pop() if bounds else _DEFAULT_LATENCY_MS
