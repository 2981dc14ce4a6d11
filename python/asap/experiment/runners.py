"""simulate and run: the same packager and schemes under a virtual and under a real clock."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

from asap import _checks, _core
from asap.experiment.tracks import Tracks
from asap.io.source import Source
from asap.results import Ledger, Run
from asap.results.run import with_first

Progress = Callable[[int, "int | None", dict[str, int]], object]

EXECUTIONS = ("anytime", "whole")  # how an algorithm takes a package

_CHUNK = 1 << 15  # events between two looks at Ctrl-C
_LEAVE_S = 0.05  # for the reader to end; one whose source waits is left there
_last: Run | None = None


def last_run() -> Run | None:
    """Return the newest run of this process, also one that an exception has cut short.

    Returns
    -------
    Run or None
        None before the first run.
    """
    return _last


def simulate(
    source: Any,
    *,
    cost: _core.LinearCost | Callable[[int, float], float],
    scheme: _core.Scheme | None = None,
    latency_ms: float | None = None,
    algorithm: Any = None,
    execution: str = "anytime",
    speed: float = 1.0,
    before: Any = None,
    width: int | None = None,
    height: int | None = None,
    start: float | None = None,
    stop: float | None = None,
    on_bad: str = "drop",
    seed: int = 0,
    capacity: int | None = None,
    keep_mask: bool = False,
    on_progress: Progress | None = None,
) -> Run:
    """Run in virtual time: events arrive at their timestamps, a package costs what `cost` says.

    Repeatable bit for bit, and as fast as the machine can.

    Parameters
    ----------
    source : path, Recording, array or iterable of arrays
        Arrays in any layout that `as_events` accepts; several paths are one recording.
    cost : LinearCost or callable
        The simulated algorithm. A callable is called as cost(n, t_us) and returns the us that n
        events take in a package that starts at t_us, on the axis of `start_us`: at least 0. With
        "anytime" it is asked first for n = 0, what a package costs before its first event, then for
        the events so far after each part.
    scheme : Scheme, optional
        Default: Deadline(latency_ms=latency_ms).
    latency_ms : float, optional
        Latency bound, ms. Default: the scheme's own, else 10.
    algorithm : optional
        A real algorithm that gets the packages too, each when it is done; its time is not measured.
    execution : {"anytime", "whole"}
        How the simulated algorithm takes a package. "anytime": in up to 16 parts, as those of the
        library do; the clock is read between them, so a package ends on time. "whole": in one call,
        as a Python algorithm does in `run` by default.
    speed : float
        As in `run`: 10 makes a quiet recording ten times as busy.
    before : optional
        A filter in front of the scheme's discarding, such as BackgroundActivityFilter: an object
        with process(events) that returns the events that pass, or a callable. Here it costs
        nothing; what it drops is `filtered` in the ledger.
    width, height : int, optional
        Sensor, px. Default: from the file; a side that is not known is not checked.
    start, stop : float, optional
        Read a path from `start` until before `stop`, s from the first event.
    on_bad : {"drop", "clamp", "raise"}
        How bad events are treated; dropped ones are counted by reason.
    seed : int
        Seed of the gamma filter.
    capacity : int, optional
        Size of the ring, events. Default: at least 2**20.
    keep_mask : bool
        Note which events the algorithm got, `Run.kept_mask`, and where packages begin, the column
        `first` of `Run.packages`. Takes 3 bits of memory per event.
    on_progress : callable, optional
        Called as on_progress(done, total or None, ledger) between chunks.

    Returns
    -------
    Run

    Raises
    ------
    ValueError
        A bad argument, named with its value and the remedy; bad events with on_bad="raise"; a
        `cost` that returns no time, with n and t_us.
    Exception
        An error of `cost` or of the algorithm, unchanged.

    Examples
    --------
    >>> scene = asap.synthetic.FlightOverChairs(duration_s=0.1)
    >>> run = asap.simulate(scene, cost=asap.LinearCost(100, 300), latency_ms=5)
    >>> run.in_time, run.ledger.overflow
    (1.0, 0)
    """
    check_cost(cost, callable_too=True)
    _checks.callback("on_progress", on_progress)
    _checks.workers(algorithm=algorithm, before=before)
    scheme = as_scheme(scheme, latency_ms)
    stream = Source(source, width=width, height=height, on_bad=on_bad, start=start, stop=stop)
    config = make_config(
        stream.sensor, latency_ms, on_bad, seed, capacity, execution, algorithm, before, keep_mask
    )
    simulator = _core.Simulator(scheme, cost, config, algorithm, speed)
    try:
        for events in stream:
            for begin in range(0, events.size, _CHUNK):
                simulator.feed(events[begin : begin + _CHUNK])
            if on_progress is not None:
                on_progress(stream.events, stream.total_hint, simulator.ledger)
        simulator.finish()
    finally:
        shown = algorithm if algorithm is not None else cost
        outcome = remember(
            simulator, stream, config, scheme, shown, mode="virtual", speed=float(speed)
        )
    return outcome


def run(
    source: Any,
    *,
    algorithm: Any,
    scheme: _core.Scheme | None = None,
    latency_ms: float | None = None,
    execution: str | None = None,
    speed: float = 1.0,
    before: Any = None,
    width: int | None = None,
    height: int | None = None,
    start: float | None = None,
    stop: float | None = None,
    on_bad: str = "drop",
    seed: int = 0,
    capacity: int | None = None,
    keep_mask: bool = False,
    duration_s: float | None = None,
    on_progress: Progress | None = None,
) -> Run:
    """Replay a recording in real time, paced by its timestamps, and measure the algorithm.

    The algorithm runs on the caller's thread, the paced producer on its own.

    Parameters
    ----------
    source
        As in `simulate`, or an `asap.Camera`: ages then count from the arrival. A generator over
        another driver is replayed like a recording: ages count from its timestamps and drift with
        its clock. Push its events into an `asap.Pipeline` instead.
    algorithm
        One of ours, an object with process(events) and, if it has it, set_gamma(gamma), or a
        callable. Events come as a read-only array in EVENT_DTYPE, valid as long as it is kept.
    execution : {"whole", "anytime"}, optional
        "whole": the algorithm gets a package in one call. "anytime": it gets the package in up to
        16 calls, in time order, so that the package ends on time whatever an event costs. Default:
        "anytime" for an algorithm of the library, "whole" for one in Python, where a call costs
        microseconds.
    speed : float
        2 replays twice as fast: timestamps are divided by it. t_first, t_last and start_us of the
        log stay on the recording's axis, everything else is wall time.
    before : optional
        As in `simulate`; its time is part of the measured cost.
    scheme, latency_ms, width, height, start, stop, on_bad, seed, capacity, keep_mask
        As in `simulate`.
    duration_s : float, optional
        A camera's run ends after this time. Default: when the camera ends.
    on_progress : callable, optional
        Called as on_progress(done, total or None, ledger) about every 20 ms.

    Returns
    -------
    Run

    Raises
    ------
    ValueError
        A bad argument, named with its value and the remedy; bad events with on_bad="raise".
    CameraError
        The camera has gone; `last_run()` holds the run up to there.
    Exception
        An error of the algorithm, unchanged; `last_run()` holds the run up to there.

    Examples
    --------
    >>> scene = asap.synthetic.FlightOverChairs(duration_s=0.1)
    >>> tracker = asap.ClusterTracker(scene.width, scene.height)
    >>> run = asap.run(scene, algorithm=tracker, latency_ms=10)
    >>> run.ledger.received == len(scene.events())
    True
    """
    if algorithm is None:
        raise TypeError("algorithm = None: give what the events are for, or use asap.simulate")
    _checks.callback("on_progress", on_progress)
    if _checks.is_camera(source):
        if speed != 1.0 or keep_mask or start is not None or stop is not None:
            words = "speed, keep_mask, start, stop: only for recordings"
            raise ValueError(f"{words}; leave them out for a camera")
        run_of_camera: Run = source._run(
            on_progress,
            duration_s=duration_s,
            algorithm=algorithm,
            scheme=scheme,
            latency_ms=latency_ms,
            execution=execution,
            before=before,
            width=width,
            height=height,
            on_bad=on_bad,
            seed=seed,
            capacity=capacity,
        )
        return run_of_camera
    if duration_s is not None:
        raise ValueError(_checks.named("duration_s", duration_s, "leave it out without a camera"))
    execution = execution_of(algorithm, execution)
    _checks.workers(algorithm=algorithm, before=before)
    scheme = as_scheme(scheme, latency_ms)
    stream = Source(source, width=width, height=height, on_bad=on_bad, start=start, stop=stop)
    config = make_config(
        stream.sensor, latency_ms, on_bad, seed, capacity, execution, algorithm, before, keep_mask
    )
    replay = _core.Replay(scheme, config, speed)

    def poll() -> None:
        if on_progress is not None:
            counts = replay.ledger
            on_progress(counts["received"] - counts["pending"], stream.total_hint, counts)

    held_s = thread_held_s()
    try:
        if stream.array is not None:
            for events in stream:
                replay.run(events, algorithm, poll)
        else:
            _replay_stream(replay, stream, algorithm, poll)
    finally:
        outcome = remember(
            replay,
            stream,
            config,
            scheme,
            algorithm,
            mode="real",
            speed=float(speed),
            held_s=held_s,
        )
    return outcome


def _replay_stream(
    replay: _core.Replay, stream: Source, algorithm: Any, poll: Callable[[], None]
) -> None:
    """Replay what has to be read first: a thread of its own reads ahead."""
    ahead = _core.ReadAhead()
    errors: list[BaseException] = []

    def read() -> None:
        try:
            for events in stream:
                if not ahead.feed(events):
                    return
        except BaseException as error:  # raised again on the caller's thread
            errors.append(error)
        finally:
            ahead.finish()

    reader = threading.Thread(target=read, name="asap-reader", daemon=True)
    reader.start()
    try:
        replay.run(ahead, algorithm, poll)
    finally:
        ahead.cancel()
        reader.join(_LEAVE_S)
    if errors:
        raise errors[0]


def as_scheme(scheme: Any, latency_ms: float | None) -> _core.Scheme:
    """Check the scheme and the bound, or make the default scheme."""
    if scheme is None:
        return _core.Deadline() if latency_ms is None else _core.Deadline(latency_ms=latency_ms)
    if not isinstance(scheme, _core.Scheme):
        raise TypeError(_checks.named("scheme", scheme, "give a scheme such as asap.Greedy()"))
    return scheme


def execution_of(algorithm: Any, execution: str | None) -> str:
    """Return how the algorithm takes a package: as asked, else by whose loop it is."""
    if execution is not None:
        return execution
    return "anytime" if _core.is_native(algorithm) else "whole"


def check_cost(cost: Any, *, callable_too: bool = False) -> None:
    """Refuse what is no simulated algorithm, and a callable where an oracle has to foresee it."""
    if isinstance(cost, _core.LinearCost):
        return
    if not callable_too:
        remedy = "give asap.LinearCost(alpha_us, beta_ns)"
        if callable(cost):
            remedy += "; the oracle foresees no other cost, asap.simulate takes any"
        raise TypeError(_checks.named("cost", cost, remedy))
    if isinstance(cost, type) or not callable(cost):
        remedy = "give asap.LinearCost(alpha_us, beta_ns) or a callable(n, t_us) that returns us"
        raise TypeError(_checks.named("cost", cost, remedy))
    _checks.callback("cost", cost)


def _whole(name: str, value: Any) -> int:
    return 0 if value is None else _checks.index(name, value)


def make_config(
    sensor: tuple[int | None, int | None],
    latency_ms: float | None,
    on_bad: str = "drop",
    seed: int = 0,
    capacity: int | None = None,
    execution: str = "anytime",
    algorithm: Any = None,
    before: Any = None,
    keep_mask: bool = False,
    *,
    flush: bool = True,
    when_full: str = "thin",
    reorder_tolerance_us: int = 0,
    warmup_discard_us: int = 0,
    log_rows: int | None = None,
) -> _core.RunConfig:
    """Check what the runners have in common, and put it together for the native ones."""
    slots = _whole("capacity", capacity)
    if capacity is not None and slots < 1:
        raise ValueError(f"capacity = {capacity}: must be at least 1 event")
    validator = _core.Validator(
        width=_whole("width", sensor[0]),
        height=_whole("height", sensor[1]),
        on_bad=on_bad,
        reorder_tolerance_us=reorder_tolerance_us,
        warmup_discard_us=warmup_discard_us,
    )
    for field, worker in (("algorithm", algorithm), ("before", before)):
        _check_frame(field, worker, sensor)
    return _core.RunConfig(
        latency_ms=latency_ms,
        capacity=slots,
        seed=seed,
        validator=validator,
        execution=execution,
        flush=flush,
        before=before,
        when_full=when_full,
        keep_mask=keep_mask,
        **({} if log_rows is None else {"log_rows": log_rows}),
    )


def _check_frame(field: str, worker: Any, sensor: tuple[int | None, int | None]) -> None:
    """Refuse one of ours that is made for a smaller sensor: it would drop what lies outside."""
    worker = worker.algorithm if isinstance(worker, Tracks) else worker
    ours = any(base.__module__ == _core.__name__ for base in type(worker).__mro__)
    if not (ours and hasattr(type(worker), "width")):
        return
    own: tuple[int, int] = (worker.width, worker.height)
    needed = max(own[0], sensor[0] or 0), max(own[1], sensor[1] or 0)
    if needed != own:
        name = type(worker).__name__
        raise ValueError(
            f"{field} = {name} for {own[0]} x {own[1]} px: the events come from a sensor of "
            f"{sensor[0] or '?'} x {sensor[1] or '?'} px; "
            f"make it {name}({needed[0]}, {needed[1]}), with its other arguments"
        )


def remember(
    runner: _core.Simulator | _core.Replay,
    stream: Source,
    config: _core.RunConfig,
    scheme: _core.Scheme,
    algorithm: Any,
    *,
    mode: str,
    speed: float = 1.0,
    held_s: float | None = None,
) -> Run:
    """Make the Run of what there is, however the runner ended, and keep it for last_run()."""
    rejected = dict(runner.validator.rejected)
    counts = runner.ledger
    for reason, count in stream.rejected.items():  # the reader comes before the runner
        rejected[reason] = rejected.get(reason, 0) + count
        counts["received"] += count
        counts["rejected"] += count
    packages, kept_mask = runner.packages, None
    if (mask := runner.kept_mask) is not None:  # put together anew at every look
        kept_mask, first = mask
        packages = with_first(packages, first)
    elif config.keep_mask:
        words = "kept_mask = None: `before` changes events, so none of them is found again"
        warnings.warn(words, stacklevel=3)
    run = Run(
        packages=packages,
        ledger=Ledger(**counts),
        latency=runner.latency,
        rejected=rejected,
        scheme=scheme,
        algorithm=algorithm,
        mode=mode,
        latency_bound_us=config.latency_bound_us(scheme),
        source=stream.describe(counts["received"], runner.validator.last_us),
        clock_resets=stream.clock_resets + runner.validator.clock_resets,
        gap_us=runner.gap_us,
        speed=float(speed),
        lateness=runner.lateness if isinstance(runner, _core.Replay) else None,
        slots=runner.slots if isinstance(runner, _core.Simulator) else None,
        kept_mask=kept_mask,
        execution=config.execution,
        seed=config.seed,
        held_s=thread_held_s(held_s),
    )
    return keep(run)


def thread_held_s(since_s: float | None = 0.0) -> float | None:
    """Return for how long this thread has been ready without a processor since then, s.

    None where the system does not tell, and of None: nothing was measured.
    """
    try:
        held_ns = int(Path("/proc/thread-self/schedstat").read_text("ascii").split()[1])
    except (OSError, ValueError, IndexError):
        return None
    return None if since_s is None else held_ns / 1e9 - since_s


def keep(run: Run) -> Run:
    """Keep it for last_run()."""
    global _last
    _last = run
    return run
