"""compare and oracle: every scheme on the same events, beside the best of any scheduler."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

from asap import _core, checks, metrics
from asap.experiment.contenders import labelled, of_schemes, rivals, user_schemes
from asap.experiment.result import Named, Run
from asap.experiment.runners import Progress, check_latency
from asap.experiment.side_by_side import CheckedStream, side_by_side
from asap.synthetic import joined

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Comparison", "Row", "compare", "oracle"]

SCHEMA_VERSION = 1
_DEFAULT_LATENCY_MS = 10.0


@dataclass(frozen=True)
class Row:
    """A scheme in numbers; latencies are of the delivered events.

    Attributes
    ----------
    label, scheme : str
        How the table calls it; the scheme's own name.
    score : float
        Events finished within the bound, as a share of those that the oracle could finish.
    kept, in_time : float
        Finished at all, and within the bound, as shares of the events received.
    p50_us, p99_us, max_us : float
        Latency, us.
    gap_ms : int
        Longest time in which events came in and none was finished, ms; see `metrics.gap_ms`.
    overflow : float
        Lost because the buffer was full, as a share of the events received.
    packages_per_s : float
        Packages per second, until the last one is done.
    cpu : float
        Share of that time in which the algorithm was busy.
    """

    label: str
    scheme: str
    score: float
    kept: float
    in_time: float
    p50_us: float
    p99_us: float
    max_us: float
    gap_ms: int
    overflow: float
    packages_per_s: float
    cpu: float

    @classmethod
    def of(cls, label: str, run: Run, oracle: float) -> Row:
        """Sum up a run beside the oracle's number of events."""
        received, elapsed_s = run.ledger.received, _elapsed_s(run)
        return cls(
            label=label,
            scheme=Named.of(run.scheme).name,
            score=run.latency.within_bound / oracle if oracle > 0 else 1.0,
            kept=run.kept,
            in_time=run.in_time,
            p50_us=run.latency.quantile(0.5),
            p99_us=run.latency.quantile(0.99),
            max_us=run.latency.max,
            gap_ms=metrics.gap_ms(run.slots) if run.slots is not None else 0,
            overflow=run.ledger.overflow / received if received else 0.0,
            packages_per_s=run.packages.size / elapsed_s if elapsed_s > 0 else 0.0,
            cpu=float(run.packages["processing_us"].sum()) * 1e-6 / elapsed_s
            if elapsed_s > 0
            else 0.0,
        )


def _elapsed_s(run: Run) -> float:
    """Return the duration of the recording; longer where the last package ended after it."""
    if run.packages.size == 0:
        return float(run.source["duration_s"])
    first, last = run.packages[0], run.packages[-1]
    busy_us = last["start_us"] + last["processing_us"] - first["t_first"]
    return max(float(run.source["duration_s"]), float(busy_us) * 1e-6)


@dataclass(frozen=True, eq=False, repr=False)
class Comparison:
    """Every scheme on the same events, beside the oracle.

    Attributes
    ----------
    rows : list of Row
        Best score first; of equal scores the lower p99 latency.
    oracle : float
        OB(L), a bound in fluid: no policy that does not know the random part of the cost finishes
        more events in time, whatever it discards and however well it knows the arrivals.
    exact : int or None
        EC(L), the exact clairvoyant: the most events that can be finished in time in whole packages
        of the mean cost. None for a cost with drift or outages, and where it would take long: more
        than a million events, or very many per bound (`oracle` with ``exact=True`` takes longer).
    runs : dict of str to Run
        By label, in the order of the rows.
    source : dict
        What was read: path, format, width, height, events, duration_s (after `speed`).
    name : str
        Of the recording or profile.
    cost : LinearCost
        The simulated algorithm.
    latency_ms : float
        The bound of all.
    opaque : bool
        Whether the algorithm took its packages as a whole; the oracle then does too.
    speed : float
        By which the stamps were compressed.
    seed : int
        Of the gamma filters.
    """

    rows: list[Row]
    oracle: float
    exact: int | None
    runs: dict[str, Run]
    source: dict[str, Any]
    name: str
    cost: _core.LinearCost
    latency_ms: float
    opaque: bool
    speed: float
    seed: int

    @property
    def received(self) -> int:
        """Events that reached the schemes: bad ones are not among them."""
        run = next(iter(self.runs.values()))
        return run.ledger.received - run.ledger.rejected

    def __iter__(self) -> Iterator[Row]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, label: str) -> Row:
        """Return the row of a label."""
        return {row.label: row for row in self.rows}[label]

    def summary(self) -> dict[str, Any]:
        """Sum the comparison up as one JSON object."""
        return {
            "schema_version": SCHEMA_VERSION,
            "source": dict(self.source),
            "name": self.name,
            "cost": Named.of(self.cost).as_json(),
            "latency_bound_us": self.latency_ms * 1e3,
            "opaque": self.opaque,
            "speed": self.speed,
            "seed": self.seed,
            "oracle": self._reached(self.oracle),
            "exact": None if self.exact is None else self._reached(self.exact),
            "schemes": [
                {**asdict(row), "parameters": Named.of(self.runs[row.label].scheme).parameters}
                for row in self.rows
            ],
            "version": _core.__version__,
        }

    def _reached(self, events: float) -> dict[str, float]:
        return {"events": events, "in_time": events / self.received if self.received else 1.0}

    def plot(self) -> Figure:
        """Draw latency and kept share over time, a row of the figure for each scheme."""
        from asap.report import comparison_figures

        return comparison_figures.figure(self)

    def report(self, path: str | os.PathLike[str]) -> None:
        """Write one self-contained HTML file."""
        from asap.report import comparison_report

        comparison_report.write(self, path)

    def __repr__(self) -> str:
        scores = ", ".join(f"{row.label} {row.score:.3f}" for row in self.rows)
        return f"<Comparison: {self.name}, {self.latency_ms:g} ms: {scores}>"

    def __str__(self) -> str:
        from asap.report import comparison_table

        return comparison_table.format_comparison(self)


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
    all: bool = False,  # as the option of the command line
    on_progress: Progress | None = None,
) -> Comparison:
    """Put every scheme to the same events in virtual time, beside the oracle.

    Repeatable bit for bit; each run is that of `simulate`. The source is read once, in flat memory.

    Parameters
    ----------
    source : path, Recording, Profile, array or list of arrays
        One that can be read again: the figures of a comparison can be checked. A profile of
        `asap.profiles` is as good as a recording.
    cost : LinearCost
        The simulated algorithm, the same for all.
    schemes : mapping of str to Scheme, or sequence of Scheme, optional
        Default: those that a user chooses from.
    latency_ms : float, optional
        The latency bound of all, ms. Default: the schemes' own, else 10.
    seed : int
        Of the gamma filters.
    opaque : bool
        True: the simulated algorithm takes a package as a whole, as a Python callback does; schemes
        are then scored against an oracle that does so too.
    speed : float
        10 compresses the stamps by ten: a quiet recording becomes one that overloads the algorithm.
    width, height : int, optional
        Sensor, px. Default: from the file; a side that is not known is not checked.
    on_bad : {"drop", "clamp", "raise"}
        What happens to bad events; dropped ones are counted by reason.
    capacity : int, optional
        Of each ring, events. Default: at least 2**20.
    all : bool
        Add the baselines of the benchmark: rules of others that are not for use.
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
    for name, value in (("opaque", opaque), ("all", all)):
        checks.flag(name, value)
    checks.callback("on_progress", on_progress)
    given = {} if schemes is None else labelled(schemes)
    bound_ms = _common_bound_ms(given.values(), latency_ms)
    contenders = user_schemes() if schemes is None else of_schemes(given)
    if all:
        others = rivals()
        twins = [one.label for one in others if one.label in given]
        checks.require(not twins, "schemes", twins, "all=True adds these; give yours other labels")
        contenders += others
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
    source : path, Recording, Profile, array or iterable of arrays
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
        checks.flag(name, value)
    bound_us = check_latency(latency_ms) * 1e3
    stream = CheckedStream(source, width=width, height=height, on_bad=on_bad, speed=speed)
    if exact:
        return _core.exact_clairvoyant(joined(list(stream)), cost, bound_us)
    found = _core.Oracle(cost, bound_us, opaque=opaque)
    for chunk in stream:
        found.feed(chunk)
    return float(found.bound)


def _check_cost(cost: Any) -> None:
    if not isinstance(cost, _core.LinearCost):
        raise TypeError(checks.named("cost", cost, "give asap.LinearCost(alpha_us, beta_ns)"))


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
        latency_ms = check_latency(latency_ms)
    own = (scheme.parameters.get("latency_ms") for scheme in schemes)
    bounds = {bound for bound in (*own, latency_ms) if bound is not None}
    if len(bounds) > 1:
        raise ValueError(
            f"latency_ms = {', '.join(f'{bound:g}' for bound in sorted(bounds))}: two different "
            "bounds; a score compares schemes at one"
        )
    return bounds.pop() if bounds else _DEFAULT_LATENCY_MS
