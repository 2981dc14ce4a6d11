"""Native core of asap: the types that the extension exports. Docstrings are in the extension."""

from collections.abc import Callable
from typing import Any, Literal, overload

import numpy as np
from numpy.typing import NDArray

__version__: str
PACKAGE_DTYPE: np.dtype[np.void]

_Events = NDArray[np.void]
_HistogramState = tuple[int, int, int, int, int, list[tuple[int, int]]]

class _pybind11_type(type): ...

# filter

class GammaFilter(metaclass=_pybind11_type):
    def __init__(self, *, seed: int = 0) -> None: ...
    def apply(self, events: _Events, gamma: float) -> _Events: ...
    def mask(self, events: _Events, gamma: float) -> NDArray[np.bool_]: ...
    @property
    def position(self) -> int: ...

class Validator(metaclass=_pybind11_type):
    def __init__(
        self,
        *,
        width: int = 0,
        height: int = 0,
        on_bad: str = "drop",
        reorder_tolerance_us: int = 0,
    ) -> None: ...
    def check(self, events: _Events) -> _Events: ...
    @property
    def received(self) -> int: ...
    @property
    def rejected(self) -> dict[str, int]: ...
    @property
    def repaired(self) -> dict[str, int]: ...
    @property
    def clock_resets(self) -> int: ...
    @property
    def clock_offset_us(self) -> int: ...
    @property
    def last_us(self) -> int: ...

# schemes

class Scheme(metaclass=_pybind11_type):
    def __init__(self, *args: object, **kwargs: object) -> None: ...  # has no constructor
    @property
    def name(self) -> str: ...
    @property
    def parameters(self) -> dict[str, float]: ...

class FixedSize(Scheme):
    def __init__(self, *, size: int = 1000) -> None: ...

class FixedTime(Scheme):
    def __init__(self, *, period_ms: float = 1.0) -> None: ...

class SingleEvent(Scheme):
    def __init__(self) -> None: ...

class Greedy(Scheme):
    def __init__(self) -> None: ...

class Asap2020(Scheme):
    def __init__(
        self,
        *,
        rate_bound: float = 5000000.0,
        epsilon: float = 0.05,
        first_size: int = 1000,
        max_size: int = 50000,
        min_size: int = 1,
    ) -> None: ...

# telemetry

class LatencyHistogram(metaclass=_pybind11_type):
    def __init__(self, *args: object, **kwargs: object) -> None: ...  # has no constructor
    @property
    def count(self) -> int: ...
    @property
    def mean(self) -> float: ...
    @property
    def max(self) -> float: ...
    @property
    def within_bound(self) -> int: ...
    def quantile(self, q: float) -> float: ...
    def state(self) -> _HistogramState: ...
    @staticmethod
    def restored(state: _HistogramState) -> LatencyHistogram: ...

class Ledger(metaclass=_pybind11_type):
    def __init__(
        self,
        *,
        received: int = 0,
        rejected: int = 0,
        filtered: int = 0,
        discarded: int = 0,
        stale: int = 0,
        overflow: int = 0,
        delivered: int = 0,
        pending: int = 0,
    ) -> None: ...
    @property
    def received(self) -> int: ...
    @property
    def rejected(self) -> int: ...
    @property
    def filtered(self) -> int: ...
    @property
    def discarded(self) -> int: ...
    @property
    def stale(self) -> int: ...
    @property
    def overflow(self) -> int: ...
    @property
    def delivered(self) -> int: ...
    @property
    def pending(self) -> int: ...
    @property
    def balanced(self) -> bool: ...
    def __eq__(self, other: object, /) -> bool: ...

# runner

class RunConfig(metaclass=_pybind11_type):
    def __init__(
        self, *, latency_us: float | None, capacity: int, seed: int, validator: Validator
    ) -> None: ...
    def latency_bound_us(self, scheme: Scheme) -> float: ...

class LinearCost(metaclass=_pybind11_type):
    def __init__(
        self, alpha_us: float, beta_ns: float, *, noise: float = 0.0, seed: int = 0
    ) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def parameters(self) -> dict[str, Any]: ...

class Simulator(metaclass=_pybind11_type):
    def __init__(
        self, scheme: Scheme, cost: LinearCost, config: RunConfig, algorithm: object = None
    ) -> None: ...
    def feed(self, events: _Events) -> None: ...
    def finish(self) -> None: ...
    @property
    def ledger(self) -> Ledger: ...
    @property
    def validator(self) -> Validator: ...
    @property
    def packages(self) -> NDArray[np.void]: ...
    @property
    def latency(self) -> LatencyHistogram: ...

class ReadAhead(metaclass=_pybind11_type):
    def __init__(self) -> None: ...
    def feed(self, events: _Events) -> bool: ...
    def finish(self) -> None: ...
    def cancel(self) -> None: ...

class Replay(metaclass=_pybind11_type):
    def __init__(self, scheme: Scheme, config: RunConfig, speed: float = 1.0) -> None: ...
    @overload
    def run(
        self, events: _Events, algorithm: object, poll: Callable[[], object] | None = None
    ) -> None: ...
    @overload
    def run(
        self, source: ReadAhead, algorithm: object, poll: Callable[[], object] | None = None
    ) -> None: ...
    @property
    def lateness(self) -> LatencyHistogram: ...
    @property
    def ledger(self) -> Ledger: ...
    @property
    def validator(self) -> Validator: ...
    @property
    def packages(self) -> NDArray[np.void]: ...
    @property
    def latency(self) -> LatencyHistogram: ...

# formats

class TextDecoder(metaclass=_pybind11_type):
    def __init__(
        self,
        *,
        order: str = "txyp",
        time_exponent: int = 6,
        clamp: bool = False,
        first_offset: int = 0,
    ) -> None: ...
    def decode(self, bytes: bytes) -> _Events: ...
    def finish(self) -> tuple[_Events, bool]: ...
    @property
    def bad_records(self) -> int: ...
    @property
    def out_of_bounds(self) -> int: ...
    @property
    def clamped_positions(self) -> int: ...
    @property
    def noted(self) -> tuple[int, ...]: ...

# synthetic

class EventStream(metaclass=_pybind11_type):
    def __init__(self, *args: object, **kwargs: object) -> None: ...  # has no constructor
    def read(self, at_least: int) -> _Events: ...

class ShakenPatternStream(EventStream):
    def __init__(
        self,
        *,
        width: int,
        height: int,
        duration_us: int,
        t0_us: int,
        first_rate_hz: float,
        last_rate_hz: float,
        amplitude_px: float,
        noise_hz: float,
        seed: int,
    ) -> None: ...

class FlightOverChairsStream(EventStream):
    def __init__(
        self,
        *,
        width: int,
        height: int,
        duration_us: int,
        t0_us: int,
        last_rate_hz: float,
        chair_px: float,
        noise_hz: float,
        seed: int,
    ) -> None: ...

# algorithms

class ClusterTracker(metaclass=_pybind11_type):
    def __init__(
        self,
        width: int,
        height: int,
        *,
        engine: str = "compat",
        window: int = 800,
        radius: float = 20.0,
        probes: int = 1,
        weight: float = 0.9,
        min_size: int = 15,
        seed: int = 0,
    ) -> None: ...
    @overload
    def process(self, events: _Events, labels: Literal[True] = True) -> NDArray[np.int32]: ...
    @overload
    def process(self, events: _Events, labels: Literal[False]) -> None: ...
    @overload
    def process(self, events: _Events, labels: bool) -> NDArray[np.int32] | None: ...
    @property
    def clusters(self) -> NDArray[np.void]: ...
    def set_keep(self, gamma: float) -> None: ...
    def reset(self) -> None: ...
    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def name(self) -> str: ...
    @property
    def parameters(self) -> dict[str, Any]: ...
    @property
    def rejected(self) -> int: ...
