"""Pipeline: live events, pushed by one thread at a time, to an algorithm in a plain for loop."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from asap import _checks, _core
from asap.events import events_of_argument
from asap.experiment.runners import as_scheme, execution_of, make_config
from asap.experiment.telemetry import Log, TelemetryFile
from asap.results import Ledger, Named
from asap.results.result import SCHEMA_VERSION
from asap.results.run import latency_us, package_figures

_CHUNK = 1 << 16  # events pushed without another thread's turn

# A call of a Python algorithm costs microseconds: over the first packages it shall pay off.
_FIRST_PACKAGES = 1000
_SMALL_PACKAGE = 100  # events


class Pipeline:
    """Live events to the algorithm, in packages, within the latency bound.

    One thread at a time pushes and is never blocked. One thread works: in a loop over the pipeline,
    whose body is the measured work, or in `run`, if the pipeline has an algorithm. An event's age
    counts from its push, or from the arrival time given with it, not from its timestamp. Leaving
    the ``with`` block stops the pipeline.

    At the end of the interpreter all pipelines are stopped. In a forked process every method of a
    pipeline made before raises RuntimeError.

    Parameters
    ----------
    algorithm : optional
        For `run`, as in `asap.run`. Without one, iterate over the pipeline.
    execution : {"whole", "anytime"}, optional
        As in `asap.run`; a loop over the pipeline takes whole packages.
    camera : Camera, optional
        Feeds the pipeline within the ``with`` block, from a thread of its own, and stops it at its
        end: `asap.open_camera` or `asap.SoftwareCamera`.
    latency_ms, scheme, before, on_bad, seed
        As in `asap.run`.
    width, height : int, optional
        Sensor, px; a side that is not known is not checked. Default: the camera's.
    capacity : int, optional
        Size of the ring, events. Default: at least 2**20. MemoryError if that much memory, 16 bytes
        an event, cannot be had.
    when_full : {"thin", "keep_oldest", "keep_newest", "block"}
        Which events are lost when events come faster than they leave the ring. "thin": above three
        quarters of the capacity, the fuller the ring, the fewer events enter, at random and evenly
        over a push; the others count as discarded. "keep_oldest": events that do not fit.
        "keep_newest": the older half, dropped by the consumer that finds the ring full. "block":
        none, push waits for room, which another thread has to make; only for sources that can wait,
        such as files.
    reorder_tolerance_us : int
        A timestamp that goes back by at most this much, us, is set to the one before, not rejected.
    warmup_discard_us : int
        Events less than this, us, after the first one are dropped and counted as `before_start`: a
        camera may first send events of its run before.
    telemetry : path, optional
        A CSV file for ``asap monitor``: a row a package with the columns of `run.packages`, the
        bound and the ledger, written by a thread of its own. Rows that the disk is too slow for are
        lost and counted. At 500,000 rows the file becomes ``PATH.1``, and a new one begins.

    Raises
    ------
    ValueError
        A bad argument, named with its value and the remedy.

    Examples
    --------
    ::

        with asap.open_camera() as camera, asap.Pipeline(camera=camera, latency_ms=10) as pipeline:
            for package in pipeline:
                my_algorithm(package.events)

        with asap.Pipeline(asap.ClusterTracker(346, 260), latency_ms=10) as pipeline:
            camera.on_events(pipeline.push)
            pipeline.run()
    """

    # `asap.run` of a camera keeps a longer log, and may limit the time.
    _log_rows: int | None = None
    _duration_s: float | None = None

    def __init__(
        self,
        algorithm: Any = None,
        *,
        camera: Any = None,
        latency_ms: float | None = None,
        scheme: _core.Scheme | None = None,
        execution: str | None = None,
        before: Any = None,
        width: int | None = None,
        height: int | None = None,
        on_bad: str = "drop",
        seed: int = 0,
        capacity: int | None = None,
        when_full: str = "thin",
        reorder_tolerance_us: int = 0,
        warmup_discard_us: int = 0,
        telemetry: str | os.PathLike[str] | None = None,
    ) -> None:
        if not (algorithm is None or callable(algorithm) or hasattr(algorithm, "process")):
            remedy = "give an object with process(events) or a callable"
            raise TypeError(_checks.named("algorithm", algorithm, remedy))
        _checks.workers(algorithm=algorithm, before=before)
        self.algorithm = algorithm
        execution = execution_of(algorithm, execution)
        if algorithm is None and execution != "whole":
            remedy = "a loop takes whole packages; give an algorithm"
            raise ValueError(_checks.named("execution", execution, remedy))
        self.scheme = as_scheme(scheme, latency_ms)
        if camera is not None:
            remedy = "give asap.open_camera() or asap.SoftwareCamera(recording)"
            if not _checks.is_camera(camera):
                raise TypeError(_checks.named("camera", camera, remedy))
            remedy = "a camera cannot wait; use 'thin', 'keep_oldest' or 'keep_newest'"
            _checks.require(when_full != "block", "when_full", when_full, remedy)
        self._camera, self._is_fed = camera, False
        self._sensor = _checks.sensor(width, height, camera, camera)
        self._config = make_config(
            self._sensor,
            latency_ms,
            on_bad,
            seed,
            capacity,
            execution,
            algorithm,
            before,
            when_full=when_full,
            reorder_tolerance_us=reorder_tolerance_us,
            warmup_discard_us=warmup_discard_us,
            log_rows=self._log_rows,
        )
        self._counts_bad = on_bad != "raise"
        self._native = _core.LivePipeline(self.scheme, self._config)
        self._log = Log(self._native)
        self._telemetry = None if telemetry is None else TelemetryFile(telemetry)
        if self._telemetry is not None:
            self._log.watchers.append(self._telemetry)
        self._in_work = False  # a package, also of a loop that was left
        self._small_is_known = algorithm is None or _core.is_native(algorithm)

    # ---- the camera's side

    def push(self, events: Any, arrival_time: float | None = None) -> None:
        """Hand events over; from any one thread at a time. Waits only with when_full="block".

        Parameters
        ----------
        events : array
            In any layout that `as_events` accepts; EVENT_DTYPE without a copy.
        arrival_time : float, optional
            When they came, s of `time.monotonic()`. Default: now.

        Raises
        ------
        RuntimeError
            The pipeline is stopped, or another thread is pushing; nothing is counted.
        ValueError
            A bad event with on_bad="raise"; those before it are taken.
        """
        array = events_of_argument("events", events, marks=self._counts_bad)
        for begin in range(0, max(array.size, 1), _CHUNK):
            if not self._native.push(array[begin : begin + _CHUNK], arrival_time):
                reason = "another thread is pushing" if self.is_open else "the pipeline is stopped"
                raise RuntimeError(f"push: {reason}; {begin} of {array.size} events were taken")

    def upstream_lost(self, marks: int, packets: int = 0) -> None:
        """Note what the driver lost before it came here: beside the ledger, not in it."""
        self._native.upstream_lost(marks, packets)

    # ---- the algorithm's side

    def __iter__(self) -> Iterator[_core.LivePackage]:
        """Yield packages until `stop`; from yield to the next turn is the processing time.

        A package has .events (read-only, valid as long as it is kept), .gamma, .t_first,
        .t_last (us), .index, .lost_before = .stale_before + .overflow_before and .filtered. Leaving
        the loop by break or an exception leaves the package in work pending and, at the end of the
        ``with`` block, stops the pipeline.

        Raises
        ------
        RuntimeError
            The pipeline has an algorithm, or another thread consumes.
        CameraError
            At the end: the camera has gone; what it sent before is delivered.
        """
        if self.algorithm is not None:
            raise RuntimeError(
                "iterate: this pipeline has an algorithm; call run(), or make it without one"
            )
        self._need_feed("iterate")
        return self._packages()

    def _packages(self) -> Iterator[_core.LivePackage]:
        self._in_work = False
        while (package := self._native.next()) is not None:
            self._log.look()
            self._in_work = True
            yield package
            self._in_work = False
        self._end()

    def run(self) -> None:
        """Let the algorithm work on this thread until `stop`, then return.

        Each call gets a read-only array, valid as long as it is kept; set_gamma(gamma) comes before
        it, if the algorithm has it. Algorithms of the library may be read by any thread meanwhile,
        as in tracker.clusters: they are as the last package has left them.

        Raises
        ------
        RuntimeError
            The pipeline has no algorithm, or another thread consumes.
        CameraError
            The camera has gone; what it sent before is delivered.
        Exception
            An error of the algorithm, unchanged. The pipeline is stopped; the package in work stays
            pending.

        Warns
        -----
        RuntimeWarning
            Once, if a Python algorithm's packages hold fewer than 100 events on average after the
            first 1000 packages: the call then costs as much as the work.
        """
        if self.algorithm is None:
            raise RuntimeError(
                "run: this pipeline has no algorithm; give it one, as in "
                "asap.Pipeline(algorithm), or iterate: for package in pipeline"
            )
        self._need_feed("run")
        self._native.run(self.algorithm, self._look)
        self._look_at_size()
        self._end()

    def _look(self) -> None:
        self._log.look()
        self._look_at_size()

    def _need_feed(self, what: str) -> None:
        """Refuse to wait for ever for a camera that was never asked to feed."""
        if self._camera is not None and not self._is_fed:
            remedy = (
                "the camera feeds within the with block: with asap.Pipeline(camera=camera) as ..."
            )
            raise RuntimeError(f"{what}: {remedy}")

    def _end(self) -> None:
        """Finish the telemetry; raise what has ended the camera, now that all is delivered."""
        self._log.look(now=True)
        if self._telemetry is not None:
            self._telemetry.close()
        if self._camera is not None:
            self._camera._release()
            self._camera._raise_error()

    def _look_at_size(self) -> None:
        if self._small_is_known:
            return
        stats = self._native.stats()
        if stats.packages < _FIRST_PACKAGES:
            return
        self._small_is_known = True
        mean = stats.size / stats.packages
        if mean < _SMALL_PACKAGE:
            warnings.warn(
                f"packages of {mean:.0f} events on average: calling Python for each costs about as "
                "much as the work; allow a longer latency_ms, or use an algorithm of asap's own",
                RuntimeWarning,
                stacklevel=4,
            )

    # ---- any thread

    def flush(self) -> None:
        """Deliver what waits now, whatever the scheme waits for; from any thread."""
        self._native.flush()

    def stop(self, drain: bool = True) -> None:
        """End the loop, from any thread; does not wait for it.

        Parameters
        ----------
        drain : bool
            True: what waits is delivered first, as the scheme decides: `Deadline` drops what has
            become stale by then too, and the ledger counts it. False: it stays pending.
        """
        self._native.stop(drain)

    def start(self) -> None:
        """Begin anew after `stop`, with an empty ring and all counts at 0.

        A package in work, such as one that a loop left by break holds, is given up.
        """
        if self._in_work and not self.is_open:
            self._native.abandon()
            self._in_work = False
        if not self.is_open:
            self._log.begin()
        self._native.start()

    def set_latency(self, latency_ms: float) -> None:
        """Change the latency bound, ms, from the next package on; the ring keeps its capacity.

        The scheme's own bound, if it has one, follows.

        Raises
        ------
        ValueError
            Out of range.
        """
        self._native.set_latency(latency_ms)

    @property
    def is_open(self) -> bool:
        """Whether events are taken."""
        return self._native.is_open

    @property
    def state(self) -> str:
        """Say "open", "stalled" or "stopped".

        Stalled: open and something waits, but the algorithm has been away for four times as long as
        a package takes, the latency bound at least. That ends by itself when it comes back.
        """
        return _state_of(self._native.stats())

    @property
    def latency_bound_us(self) -> float:
        """The latency bound in force, us."""
        return self._native.stats().latency_bound_us

    @property
    def ledger(self) -> Ledger:
        """Where every event went; at any time."""
        return Ledger(**self._native.ledger)

    @property
    def packages(self) -> NDArray[np.void]:
        """The newest 16384 rows of the log, as `run.packages`: a copy, when the run is over.

        Raises
        ------
        RuntimeError
            The pipeline is open, or the algorithm still works on what waited.
        """
        return self._native.packages

    def stats(self) -> dict[str, Any]:
        """Sum up the run since the last start as one JSON object; at any time, from any thread.

        Beside the keys of `run.summary()`: state; max_waiting, events that were in the ring at
        once; sensor_delay_us, how much longer than at best events of late took from the sensor to
        push; upstream_lost; pinned, package arrays that Python still holds; camera and telemetry,
        if it has them.
        """
        stats = self._native.stats()
        ledger, latency, elapsed_s = stats.ledger, stats.latency, stats.elapsed_s
        received = ledger["received"]
        return {
            "schema_version": SCHEMA_VERSION,
            "mode": "live",
            "state": _state_of(stats),
            "open": stats.open,
            "source": {
                "path": None,
                "format": "live",
                "width": self._sensor[0],
                "height": self._sensor[1],
                "events": received,
                "duration_s": round(elapsed_s, 6),
            },
            "scheme": Named.of(self.scheme).as_json(),
            "algorithm": None if self.algorithm is None else Named.of(self.algorithm).as_json(),
            "latency_bound_us": stats.latency_bound_us,
            "execution": self._config.execution,
            "seed": self._config.seed,
            "ledger": ledger,
            "rejected": stats.rejected,
            "clock_resets": stats.clock_resets,
            "upstream_lost": {"marks": stats.upstream_marks, "packets": stats.upstream_packets},
            "sensor_delay_us": {"last": stats.sensor_delay_us, "max": stats.sensor_delay_max_us},
            "max_waiting": stats.max_waiting,
            "pinned": self._native.pinned,
            "kept": ledger["delivered"] / received if received else None,
            "in_time": latency.within_bound / received if received else None,
            "latency_us": latency_us(latency),
            "gap_us": stats.gap_us,
            **package_figures(
                stats.packages,
                elapsed_s,
                stats.size,
                stats.size_max,
                stats.to_gamma,
                stats.gamma_min,
            ),
            "cpu": stats.busy_s / elapsed_s if elapsed_s > 0 else 0.0,
            "version": _core.__version__,
            **({} if self._camera is None else {"camera": self._camera.stats()}),
            **({} if self._telemetry is None else {"telemetry": self._telemetry.stats()}),
        }

    def __enter__(self) -> Pipeline:
        """Start it, if it is stopped, and let its camera feed it."""
        self.start()
        if self._camera is not None:
            self._camera._feed(self, self._duration_s)
            self._is_fed = True
        return self

    def __exit__(self, *_: object) -> None:
        """Stop; what was not delivered stays pending in the ledger."""
        if self._camera is not None:
            self._camera._release()  # first: the packet in its hand is counted
        self._native.abandon()
        if self._telemetry is not None:
            self._telemetry.close()

    def __repr__(self) -> str:
        name = Named.of(self.scheme).name
        try:
            return f"<Pipeline: {self.state}, {name}, {self.ledger!r}>"
        except RuntimeError:
            return f"<Pipeline: created before fork, {name}>"


def _state_of(stats: _core.PipelineStats) -> str:
    if not stats.open:
        return "stopped"
    return "stalled" if stats.stalled else "open"
