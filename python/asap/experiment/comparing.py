"""compare and oracle: every scheme on the same events, beside the best of any scheduler."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from asap import _checks, _core
from asap.experiment.runners import (
    EXECUTIONS,
    Progress,
    check_cost,
    make_config,
    remember,
)
from asap.io.source import CheckedStream
from asap.results import Comparison, Row, Run
from asap.results.cost import RATE_SHARE, Cost

_DEFAULT_LATENCY_MS = 10.0
_CHUNK = 1 << 16  # events that all get before any gets more


def compare(
    source: Any,
    *,
    cost: _core.LinearCost,
    schemes: Any = None,
    latency_ms: float | None = None,
    seed: int = 0,
    execution: str = "anytime",
    speed: float = 1.0,
    width: int | None = None,
    height: int | None = None,
    start: float | None = None,
    stop: float | None = None,
    on_bad: str = "drop",
    capacity: int | None = None,
    on_progress: Progress | None = None,
) -> Comparison:
    """Run every scheme on the same events in virtual time, beside the oracle.

    Repeatable bit for bit; each run is that of `simulate`. The source is read once, in flat memory.

    Parameters
    ----------
    source : path, Recording, array or list of arrays
        One that can be read again: the figures of a comparison can be checked.
    cost : LinearCost
        The simulated algorithm, the same for all.
    schemes : mapping of str to Scheme, or sequence of Scheme, optional
        Default: those that a user chooses from. `Asap2020` gets what its user is advised to give:
        a rate bound of 90 % of what this cost can do within the bound (with 98 % its queue grows
        and most events are late), and packages of at least 20 events, or as many as take L/10.
    latency_ms : float, optional
        The latency bound of all, ms. Default: the schemes' own, else 10.
    seed : int
        Seed of the gamma filters.
    execution : {"anytime", "whole"}
        As in `simulate`; the oracle's algorithm takes its packages likewise.
    speed : float
        10 compresses time by ten: a quiet recording becomes one that overloads the algorithm.
    width, height, start, stop, on_bad, capacity
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

    Examples
    --------
    >>> scene = asap.synthetic.FlightOverChairs(duration_s=0.1)
    >>> comparison = asap.compare(scene, cost=asap.LinearCost(200, 2000), latency_ms=10)
    >>> comparison["Deadline"].in_time > comparison["Greedy"].in_time
    True
    """
    check_cost(cost)
    _require_replayable(source)
    _checks.callback("on_progress", on_progress)
    given = {} if schemes is None else labelled(schemes)
    bound_ms = _common_bound_ms(given.values(), latency_ms)
    contenders = user_schemes() if schemes is None else of_schemes(given)
    contenders = [replace(one, execution=execution) for one in contenders]
    stream = CheckedStream(
        source,
        width=width,
        height=height,
        on_bad=on_bad,
        speed=speed,
        start=start,
        stop=stop,
    )
    found = side_by_side(
        stream,
        contenders,
        cost=cost,
        latency_ms=bound_ms,
        seed=seed,
        capacity=capacity,
        on_progress=on_progress,
    )
    best = found.oracles[execution]
    runs = {one.label: run for one, run in zip(contenders, found.runs, strict=True)}
    rows = sorted(
        (Row.of(label, run, best) for label, run in runs.items()),
        key=lambda row: (-round(row.score, 3), row.p99_us),
    )
    described = found.runs[0].source
    return Comparison(
        rows=rows,
        oracle=best,
        runs={row.label: runs[row.label] for row in rows},
        source=described,
        name=os.path.basename(described["path"] or "") or described["format"],
        cost=cost,
        latency_ms=float(bound_ms),
        execution=execution,
        speed=stream.speed,
        seed=int(seed),
    )


def oracle(
    source: Any,
    *,
    cost: _core.LinearCost,
    latency_ms: float,
    execution: str = "anytime",
    speed: float = 1.0,
    width: int | None = None,
    height: int | None = None,
    start: float | None = None,
    stop: float | None = None,
    on_bad: str = "drop",
    seed: int = 0,
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
    execution : {"anytime", "whole"}
        As in `simulate`. It matters where the cost has noise.
    speed, width, height, start, stop, on_bad
        As in `compare`.
    seed : int
        Without effect: accepted so that the arguments of `simulate` fit.

    Returns
    -------
    float
        Events. No scheduler that does not know the random part of the cost finishes more, whatever
        it discards and however well it knows the arrivals: OB(L), a bound in fluid.

    Raises
    ------
    ValueError
        A bad argument, named with its value and the remedy.

    Notes
    -----
    notebooks/theory.md, section 9. With noise OB is a bound in expectation.

    Examples
    --------
    >>> scene = asap.synthetic.FlightOverChairs(duration_s=0.1)
    >>> asap.oracle(scene, cost=asap.LinearCost(200, 2000), latency_ms=10) < len(scene.events())
    True
    """
    check_cost(cost)
    _checks.whole("seed", seed, 0, 2**64 - 1, "must be 0 to 2**64 - 1")
    bound_us = _core.checked_latency_ms(latency_ms) * 1e3
    stream = CheckedStream(
        source, width=width, height=height, on_bad=on_bad, speed=speed, start=start, stop=stop
    )
    found = _core.Oracle(cost, bound_us, execution)
    for chunk in stream:
        found.feed(chunk)
    return float(found.bound)


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


# ---- the schemes of a comparison ----------------------------------------------------------------

Make = Callable[[float, _core.LinearCost], _core.Scheme]


@dataclass(frozen=True)
class Contender:
    """A scheme under a label, ready to be put to any latency and cost."""

    label: str  #: how it is called in tables
    make: Make  #: a new scheme; the cost is for rivals that know what a package will cost
    flush: bool = True  #: gives out what waits when the oldest event has reached the bound
    execution: str = "anytime"  #: as in `simulate`


# Settings by label, where there are more or others than the defaults under the name of the class.
_SETTINGS: dict[type[_core.Scheme], dict[str, dict[str, float]]] = {
    _core.FixedSize: {"FixedSize 1000": {"size": 1000}},
    _core.FixedTime: {"FixedTime 1 ms": {"period_ms": 1.0}},
    _core.Greedy: {"Greedy": {}, "Greedy 0.97": {"efficiency": 0.97}},
    _core.SingleEvent: {},  # pays the fixed cost for every event
}


def user_schemes() -> list[Contender]:
    """Return what a user chooses from, the default last."""
    return [
        Contender(label, _maker(kind, settings))
        for kind in sorted(_core.SCHEMES, key=lambda kind: kind is _core.Deadline)
        for label, settings in _SETTINGS.get(kind, {kind.__name__: {}}).items()
    ]


def _maker(kind: type[_core.Scheme], settings: Mapping[str, float]) -> Make:
    own = kind().parameters

    def make(latency_ms: float, cost: _core.LinearCost) -> _core.Scheme:
        given = dict(settings, latency_ms=latency_ms) if "latency_ms" in own else dict(settings)
        if "rate_bound" in own:  # what its user is advised to give
            per = Cost(*(cost.parameters[name] for name in ("alpha_us", "beta_ns")))
            if 0 < (rate_hz := per.throughput_hz(latency_ms * 1e3)) < math.inf:
                given["rate_bound"] = RATE_SHARE * rate_hz
                given["min_size"] = min(max(int(latency_ms * 1e5 / per.beta_ns), 1), 20)
        return kind(**given)

    return make


def labelled(schemes: Any) -> dict[str, _core.Scheme]:
    """Give every scheme a label: its key in a mapping, else its class and what sets it apart.

    A ValueError if there is none, one stands twice (it has one state), or two labels are the same
    text.
    """
    named = isinstance(schemes, Mapping)
    given = schemes.values() if named else schemes
    is_list = isinstance(given, Iterable) and not isinstance(given, str)
    listed = list(given) if is_list else [given]
    for scheme in listed:
        if not isinstance(scheme, _core.Scheme):
            remedy = "give schemes such as [asap.Greedy()]"
            raise TypeError(_checks.named("schemes", scheme, remedy))
    if not listed:
        raise ValueError("schemes = []: give at least one, or None for the usual ones")
    if len({id(scheme) for scheme in listed}) < len(listed):
        raise ValueError("schemes: one of them stands there twice, but it can run only once")
    labels = [str(label) for label in schemes] if named else _labels(listed)
    if len(set(labels)) < len(labels):
        raise ValueError(f"schemes: the labels {labels} are not all different")
    return dict(zip(labels, listed, strict=True))


def of_schemes(schemes: Mapping[str, _core.Scheme]) -> list[Contender]:
    """Make contenders of schemes that exist already."""
    return [Contender(label, _always(scheme)) for label, scheme in schemes.items()]


def _always(scheme: _core.Scheme) -> Make:
    return lambda latency_ms, cost: scheme


def _labels(schemes: Sequence[_core.Scheme]) -> list[str]:
    """Class names; where two are of one class, with the parameters in which they differ."""
    labels: list[str] = []
    for scheme in schemes:
        kin = [other.parameters for other in schemes if type(other) is type(scheme)]
        differing = [
            f"{name}={value:g}"
            for name, value in scheme.parameters.items()
            if value is not None and any(other[name] != value for other in kin)
        ]
        label = " ".join([type(scheme).__name__, *differing])
        twins = sum(other == label or other.startswith(f"{label} (") for other in labels)
        labels.append(f"{label} ({twins + 1})" if twins else label)
    return labels


# ---- one pass over the events -------------------------------------------------------------------


class SideBySide(NamedTuple):
    """What one pass has found."""

    runs: list[Run]  #: in the order of the contenders
    oracles: Mapping[str, float]  #: OB(L) by execution, events


def side_by_side(
    stream: CheckedStream,
    contenders: Sequence[Contender],
    *,
    cost: _core.LinearCost,
    latency_ms: float,
    seed: int = 0,
    capacity: int | None = None,
    threads: int | None = None,
    on_progress: Progress | None = None,
) -> SideBySide:
    """Run every contender and both oracles over one reading of a stream, in virtual time.

    Every run has its own copy of the cost, with the same draws. The result does not depend on the
    number of threads that feed the runs; there are as many as cores unless given.
    """
    configs = [
        make_config(
            stream.sensor,
            latency_ms,
            seed=seed,
            capacity=capacity,
            execution=contender.execution,
            flush=contender.flush,
        )
        for contender in contenders
    ]
    schemes = [contender.make(latency_ms, cost) for contender in contenders]
    simulators = [
        _core.Simulator(scheme, cost, config)
        for scheme, config in zip(schemes, configs, strict=True)
    ]
    oracles = {name: _core.Oracle(cost, latency_ms * 1e3, name) for name in EXECUTIONS}
    feeds = [one.feed for one in simulators] + [one.feed for one in oracles.values()]
    threads = threads if threads is not None else os.cpu_count() or 1
    with ThreadPoolExecutor(threads) as pool:  # feeding releases the GIL
        for events in stream:
            for begin in range(0, events.size, _CHUNK):
                chunk = events[begin : begin + _CHUNK]
                _wait_for([pool.submit(feed, chunk) for feed in feeds])
            if on_progress is not None:
                on_progress(stream.events, stream.total_hint, {})
        _wait_for([pool.submit(simulator.finish) for simulator in simulators])
    runs = [
        remember(simulator, stream, config, scheme, cost, mode="virtual")
        for simulator, config, scheme in zip(simulators, configs, schemes, strict=True)
    ]
    return SideBySide(runs, {name: one.bound for name, one in oracles.items()})


def _wait_for(tasks: Iterable[Future[None]]) -> None:
    for task in tasks:
        task.result()
