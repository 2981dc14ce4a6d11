"""Pipeline: live events from any thread, to an algorithm that works in a plain for loop."""

from __future__ import annotations

from collections.abc import Iterator
from types import TracebackType
from typing import Any

from asap import _core
from asap.events import as_events
from asap.experiment.result import LEDGER_FIELDS, SCHEMA_VERSION, Ledger, Named
from asap.experiment.runners import as_scheme, make_config

__all__ = ["Pipeline"]

_CHUNK = 1 << 16  # events pushed without another thread's turn


class _Live:
    """What make_config asks of a source."""

    def __init__(self, width: int | None, height: int | None) -> None:
        self.width = width
        self.height = height


class Pipeline:
    """Live events to the algorithm, in packages, within the latency bound.

    Any thread pushes and is never blocked; the loop over the pipeline works, and its body is the
    measured work. An event's age counts from its push, or from the arrival time given with it, not
    from its stamp. Leaving the ``with`` block stops the pipeline.

    Parameters
    ----------
    latency_ms : float, optional
        Latency bound, ms. Default: the scheme's own, else 10.
    scheme : Scheme, optional
        Default: Deadline(latency_ms=latency_ms).
    before : optional
        A filter in front of the scheme's discarding, such as BackgroundActivityFilter: an object
        with process(events) that returns the events that pass, or a callable. Its time is part of
        the measured cost; what it drops is `filtered` in the ledger.
    width, height : int, optional
        Sensor, px; without both no bounds are checked.
    on_bad : {"drop", "clamp", "raise"}
        What happens to bad events; dropped ones are counted by reason.
    seed : int
        Of the gamma filter.
    capacity : int, optional
        Of the ring, events. Default: at least 2**20. What does not fit is dropped and counted.

    Raises
    ------
    ValueError
        A bad argument, named with its value and the remedy.

    Examples
    --------
    ::

        with asap.Pipeline(latency_ms=10) as pipeline:  # any thread pushes, this one works
            camera.on_events(pipeline.push)
            for package in pipeline:
                my_algorithm(package.events)
    """

    def __init__(
        self,
        *,
        latency_ms: float | None = None,
        scheme: _core.Scheme | None = None,
        before: Any = None,
        width: int | None = None,
        height: int | None = None,
        on_bad: str = "drop",
        seed: int = 0,
        capacity: int | None = None,
    ) -> None:
        self.scheme = as_scheme(scheme, latency_ms)
        self._live = _Live(width, height)
        config = make_config(
            self._live,
            latency_ms=latency_ms,
            on_bad=on_bad,
            seed=seed,
            capacity=capacity,
            anytime=False,
            before=before,
        )
        self.latency_bound_us = config.latency_bound_us(self.scheme)
        self._native = _core.LivePipeline(self.scheme, config)

    def push(self, events: Any, arrival_time: float | None = None) -> None:
        """Hand events over; from any one thread at a time. Never blocks.

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
        array = as_events(events)
        for begin in range(0, max(array.size, 1), _CHUNK):
            if not self._native.push(array[begin : begin + _CHUNK], arrival_time):
                reason = "another thread is pushing" if self.is_open else "the pipeline is stopped"
                raise RuntimeError(f"push: {reason}; {begin} of {array.size} events were taken")

    def upstream_lost(self, marks: int, packets: int = 0) -> None:
        """Note what the driver lost before it came here: beside the ledger, not in it."""
        self._native.upstream_lost(marks, packets)

    def __iter__(self) -> Iterator[_core.LivePackage]:
        """Yield packages until `stop`; from yield to the next turn is the processing time.

        A package has .events (read-only, valid as long as it is kept), .gamma, .t_first, .t_last
        (us), .index and .lost_before. Leaving the loop by break or an exception leaves the package
        in work pending and, at the end of the ``with`` block, stops the pipeline.
        """
        while (package := self._native.next()) is not None:
            yield package

    def flush(self) -> None:
        """Deliver what waits now, whatever the scheme waits for; from any thread."""
        self._native.flush()

    def stop(self, drain: bool = True) -> None:
        """End the loop, from any thread; does not wait for it.

        Parameters
        ----------
        drain : bool
            True: what waits is delivered first. False: it stays pending.
        """
        self._native.stop(drain)

    def start(self) -> None:
        """Begin anew after `stop`, with an empty ring and all counts at 0."""
        self._native.start()

    @property
    def is_open(self) -> bool:
        """Whether events are taken."""
        return self._native.is_open

    @property
    def ledger(self) -> Ledger:
        """Where every event went; at any time."""
        return _ledger(self._native.ledger)

    def stats(self) -> dict[str, Any]:
        """Sum up the run since the last start as one JSON object; at any time, from any thread."""
        stats = self._native.stats()
        ledger = _ledger(stats.ledger)
        latency, elapsed_s = stats.latency, stats.elapsed_s
        received = ledger["received"]
        return {
            "schema_version": SCHEMA_VERSION,
            "mode": "live",
            "open": stats.open,
            "source": {
                "path": None,
                "format": "live",
                "width": self._live.width,
                "height": self._live.height,
                "events": received,
                "duration_s": elapsed_s,
            },
            "scheme": Named.of(self.scheme).as_json(),
            "latency_bound_us": self.latency_bound_us,
            "ledger": dict(ledger),
            "rejected": stats.rejected,
            "clock_resets": stats.clock_resets,
            "upstream_lost": {"marks": stats.upstream_marks, "packets": stats.upstream_packets},
            "kept": ledger["delivered"] / received if received else 1.0,
            "in_time": latency.within_bound / received if received else 1.0,
            "latency_us": {
                "mean": latency.mean,
                "p50": latency.quantile(0.5),
                "p99": latency.quantile(0.99),
                "max": latency.max,
            },
            "packages": {
                "count": stats.packages,
                "per_s": stats.packages / elapsed_s if elapsed_s > 0 else 0.0,
                "size_mean": stats.size / stats.packages if stats.packages else 0.0,
                "size_max": stats.size_max,
            },
            "gamma": {
                "mean": stats.size / stats.thinned if stats.thinned else 1.0,
                "min": stats.gamma_min,
            },
            "cpu": stats.busy_s / elapsed_s if elapsed_s > 0 else 0.0,
            "version": _core.__version__,
        }

    def __enter__(self) -> Pipeline:
        """Start it, if it is stopped."""
        self._native.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Stop; what was not delivered stays pending in the ledger."""
        self._native.abandon()

    def __repr__(self) -> str:
        state = "open" if self.is_open else "stopped"
        return f"<Pipeline: {state}, {Named.of(self.scheme).name}, {self.ledger!r}>"


def _ledger(native: _core.Ledger) -> Ledger:
    return Ledger({name: getattr(native, name) for name in LEDGER_FIELDS})
