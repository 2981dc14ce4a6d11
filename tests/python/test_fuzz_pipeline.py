"""A live pipeline under any order of calls: the ledger adds up, nothing waits for ever.

Every call comes from one thread (some pushes from another that has ended by the next call), so the
ledger is exact after each. Wherever something may wait, a timer stops the pipeline.
"""

from __future__ import annotations

import json
import math
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

import asap
from fuzzing import effort

WIDTH, HEIGHT = 346, 260
SCHEMES: dict[str, Callable[[], Any]] = {
    "Deadline": asap.Deadline,
    "DeadBeat": asap.DeadBeat,
    "Asap2020": lambda: asap.Asap2020(rate_bound=1e4, first_size=7),
    "Asap2022": asap.Asap2022,
    "FixedSize": lambda: asap.FixedSize(size=13),
    "FixedTime": asap.FixedTime,
    "Greedy": asap.Greedy,
    "SingleEvent": asap.SingleEvent,
}
LAYOUTS = (
    asap.EVENT_DTYPE,
    np.dtype([("t", "i8"), ("y", "i4"), ("x", "i2"), ("polarity", "?")]),
)
STEPS = st.one_of(st.integers(0, 30), st.sampled_from((-1, -40, -2_000_000, 1000, 10**7, 10**15)))


class Mine(Exception):
    """Of an algorithm or a filter; never of the library."""


@contextmanager
def not_for_ever(pipeline: asap.Pipeline) -> Iterator[threading.Event]:
    """Stops it after a while; yields whether it has."""
    stopped = threading.Event()

    def stop() -> None:
        stopped.set()
        pipeline.stop()

    timer = threading.Timer(0.05, stop)
    timer.start()
    try:
        yield stopped
    finally:
        timer.cancel()
        timer.join()


@st.composite
def pieces(draw: st.DrawFn) -> Any:
    """Steps of time, places and polarities; some of them no event can have."""
    steps = draw(st.lists(STEPS, max_size=40))
    count = len(steps)
    events = np.zeros(count, draw(st.sampled_from(LAYOUTS)))
    events["x"] = draw(st.sampled_from((0, 1, WIDTH - 1, WIDTH)))
    events["y"] = np.arange(count) * draw(st.sampled_from((1, 7)))
    events[events.dtype.names[2 if "p" in events.dtype.names else 3]] = np.arange(count) % 2
    return events, np.cumsum(steps)


class Front:
    """A filter in front: passes every n-th event, and raises once in a while."""

    def __init__(self, every: int, raises_at: int) -> None:
        self.every, self.calls = every, raises_at

    def __call__(self, events: Any) -> Any:
        self.calls -= 1
        if self.calls == 0:
            raise Mine
        return events[:: self.every]


class LivePipeline(RuleBasedStateMachine):
    pipeline: asap.Pipeline | None = None

    @initialize(
        form=st.sampled_from(("loop", "callback", "native")),
        scheme=st.sampled_from(sorted(SCHEMES)),
        capacity=st.sampled_from((1, 2, 7, 64, 1000)),
        when_full=st.sampled_from(("thin", "keep_oldest", "keep_newest", "block")),
        on_bad=st.sampled_from(("drop", "clamp", "raise")),
        front=st.one_of(st.none(), st.builds(Front, st.integers(1, 3), st.integers(0, 6))),
        of_ours=st.booleans(),
        tolerance=st.sampled_from((0, 0, 50)),
        warm_up=st.sampled_from((0, 0, 20)),
        ends=st.sampled_from(("", "raise", "stop", "run")),
        ends_at=st.integers(1, 5),
    )
    def make(self, form: str, scheme: str, front: Any, of_ours: bool, **options: Any) -> None:
        self.form = form
        self.ends, self.ends_at = options.pop("ends"), options.pop("ends_at")
        self.kept: list[tuple[Any, Any]] = []  # arrays that are still held, and what was in them
        self.t_us = 0
        self.begin_anew()
        algorithm = {
            "loop": None,
            "callback": self.work,
            "native": asap.ClusterTracker(WIDTH, HEIGHT),
        }[form]
        if of_ours and front is not None:
            front = asap.BackgroundActivityFilter(WIDTH, HEIGHT)
        self.waits = options["when_full"] == "block"
        self.raises = options["on_bad"] == "raise"
        self.pipeline = asap.Pipeline(
            algorithm,
            scheme=SCHEMES[scheme](),
            before=front,
            width=WIDTH,
            height=HEIGHT,
            reorder_tolerance_us=options.pop("tolerance"),
            warmup_discard_us=options.pop("warm_up"),
            **options,
        )

    def begin_anew(self) -> None:
        self.loop: Iterator[Any] | None = None
        self.in_work = self.delivered = self.packages = 0
        self.last_us = -math.inf
        self.least = self.most = 0  # events pushed, without and with those of a refused push
        self.given_up = False

    # ---- the camera

    @rule(
        piece=pieces(),
        arrival=st.sampled_from((None, None, 0.0, -0.05, -3600.0, 1e6, -1e8)),
        elsewhere=st.booleans(),
    )
    def push(self, piece: Any, arrival: float | None, elsewhere: bool) -> None:
        events, steps = piece
        events["t"] = self.t_us + steps
        if events.size:
            self.t_us = int(steps[-1]) + self.t_us if abs(self.t_us) < 10**15 else 0
        when = None if arrival is None else time.monotonic() + arrival
        errors: list[BaseException] = []
        was_open = self.pipeline.is_open

        def hand_over() -> None:
            try:
                self.pipeline.push(events, when)
            except BaseException as error:
                errors.append(error)

        with not_for_ever(self.pipeline) as stopped:
            if elsewhere:
                thread = threading.Thread(target=hand_over)
                thread.start()
                thread.join()
            else:
                hand_over()
        if not errors:
            assert was_open
            self.least += events.size
        elif isinstance(errors[0], ValueError):
            assert self.raises and was_open and str(errors[0])[:4] in ("t = ", "x = ", "y = ")
        else:
            assert type(errors[0]) is RuntimeError and "stopped" in str(errors[0])
            assert not was_open or stopped.is_set()
        if was_open:
            self.most += events.size

    @rule(
        what=st.sampled_from(("file.aedat4", 7, {}, np.zeros(3), np.zeros((2, 5)))),
        arrival=st.sampled_from((math.nan, math.inf, -math.inf, 2e9)),
    )
    def push_nonsense(self, what: Any, arrival: float) -> None:
        with pytest.raises((TypeError, ValueError)):
            self.pipeline.push(what)
        with pytest.raises(ValueError, match=r"^arrival_time = "):
            self.pipeline.push(np.zeros(1, asap.EVENT_DTYPE), arrival)

    # ---- the algorithm

    def look_at(self, events: Any) -> None:
        assert events.size and not events.flags.writeable
        t = events["t"]
        assert t[0] >= self.last_us and (np.diff(t) >= 0).all()
        assert (events["x"] < WIDTH).all() and (events["y"] < HEIGHT).all()
        self.last_us = t[-1]
        self.kept.append((events, events.copy()))

    def work(self, events: Any) -> None:
        self.look_at(events)
        self.ends_at -= 1
        if self.ends_at == 0 and self.ends == "raise":
            raise Mine
        if self.ends_at == 0 and self.ends == "stop":
            self.pipeline.stop()
        if self.ends_at == 0 and self.ends == "run":
            with pytest.raises(RuntimeError, match="another thread consumes"):
                self.pipeline.run()
        self.delivered += events.size

    def complete(self) -> None:
        self.delivered += self.in_work
        self.in_work = 0

    @rule()
    def next(self) -> None:
        if self.form != "loop":
            with pytest.raises(RuntimeError, match="has an algorithm"):
                iter(self.pipeline)
            return
        self.loop = self.loop or iter(self.pipeline)
        try:
            with not_for_ever(self.pipeline):
                package = next(self.loop, None)
        except Mine:  # of the filter in front
            package = None
        self.complete()
        assert package is None or not self.given_up
        if package is None:
            self.loop = None
            return
        self.in_work = len(package)
        self.look_at(package.events)
        assert package.index == self.packages
        assert 0 < package.gamma <= 1
        assert package.lost_before == package.stale_before + package.overflow_before
        self.packages += 1

    @rule(times=st.integers(1, 4), leave=st.booleans())
    def some(self, times: int, leave: bool) -> None:
        for _ in range(times):
            if self.form == "loop" and self.pipeline.ledger.pending > self.in_work:
                self.pipeline.flush()
                self.next()
        if leave:
            self.loop = None

    @rule()
    def run(self) -> None:
        if self.form == "loop":
            with pytest.raises(RuntimeError, match="has no algorithm"):
                self.pipeline.run()
            return
        before, given_up = self.delivered, self.given_up
        try:
            with not_for_ever(self.pipeline):
                self.pipeline.run()
        except Mine:
            self.given_up = True
        assert self.delivered == before or not given_up
        assert not self.pipeline.is_open

    # ---- any thread

    @rule()
    def flush(self) -> None:
        self.pipeline.flush()

    @rule(how=st.sampled_from(("drain", "at once", "leave the block")), then=st.booleans())
    def stop(self, how: str, then: bool) -> None:
        if how == "leave the block":
            self.pipeline.__exit__(None, None, None)
            self.in_work, self.loop = 0, None
        else:
            self.pipeline.stop(drain=how == "drain")
        self.given_up |= how != "drain"
        assert self.pipeline.state == "stopped"
        if then:  # nothing comes after a stop at once
            self.next()
            self.run()

    @rule(enter=st.booleans(), piece=pieces())
    def start(self, enter: bool, piece: Any) -> None:
        begin = self.pipeline.__enter__ if enter else self.pipeline.start
        was_open = self.pipeline.is_open
        begin()
        assert self.pipeline.is_open
        if not was_open:
            assert self.pipeline.ledger.received == 0
            self.begin_anew()
        self.push(piece, None, False)

    @rule(latency_ms=st.sampled_from((0.01, 0.5, 10, 1e7, 0.0, -1, 2e7, math.nan, math.inf)))
    def set_latency(self, latency_ms: float) -> None:
        before = self.pipeline.latency_bound_us
        if 0.01 <= latency_ms <= 1e7:
            self.pipeline.set_latency(latency_ms)
            assert self.pipeline.latency_bound_us == latency_ms * 1e3
        else:
            with pytest.raises(ValueError, match=r"^latency_ms = "):
                self.pipeline.set_latency(latency_ms)
            assert self.pipeline.latency_bound_us == before

    # ---- what always holds

    @rule(marks=st.integers(0, 2**40), let_go=st.booleans())
    def look(self, marks: int, let_go: bool) -> None:
        before = self.pipeline.stats()
        self.pipeline.upstream_lost(marks)
        stats = self.pipeline.stats()
        assert stats["upstream_lost"]["marks"] == before["upstream_lost"]["marks"] + marks
        assert stats["ledger"] == dict(self.pipeline.ledger)
        assert stats["state"] in ("open", "stalled", "stopped")
        assert stats["ledger"]["rejected"] == sum(stats["rejected"].values())
        assert stats["pinned"] >= len(self.kept)
        assert json.loads(json.dumps(stats, allow_nan=False)) == stats
        assert repr(self.pipeline).startswith("<Pipeline: ")
        if let_go:
            self.kept.clear()

    @rule()
    def look_at_rows(self) -> None:
        if self.pipeline.is_open:
            with pytest.raises(RuntimeError, match="is open"):
                _ = self.pipeline.packages
            return
        rows = self.pipeline.packages
        assert rows["size"].sum() == self.pipeline.ledger.delivered
        assert list(rows["index"]) == list(range(rows.size))
        assert (rows["size"] <= rows["offered"]).all()

    @invariant()
    def the_ledger_is_exact(self) -> None:
        if self.pipeline is None:
            return
        ledger = self.pipeline.ledger
        assert ledger.balanced and ledger.pending <= ledger.received
        assert self.least <= ledger.received <= self.most
        assert self.form == "native" or ledger.delivered == self.delivered

    def teardown(self) -> None:
        if self.pipeline is None:
            return
        self.pipeline.stop()
        if self.form == "loop":
            while self.pipeline.ledger.pending and not self.given_up:
                self.next()
        else:
            self.run()
        self.the_ledger_is_exact()
        assert self.given_up or self.pipeline.ledger.pending == 0
        for events, before in self.kept:
            assert (events == before).all()


LivePipeline.TestCase.settings = effort(60)
test_any_order_of_calls = pytest.mark.filterwarnings("ignore:packages of")(LivePipeline.TestCase)
