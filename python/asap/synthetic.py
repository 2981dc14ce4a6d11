"""Synthetic event streams: the two experiments of the paper, without a camera.

The streams are made natively while they are read, in flat memory and faster than real time. The
same parameters give the same events on every machine; one out of its range is a ValueError that
names it.

Source: Tapia, Gomez Eguiluz, Martinez-de Dios, Ollero, *ASAP: Adaptive Scheme for Asynchronous
Processing of Event-based Vision Algorithms*, ICRA 2020 workshop, experiments.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, ClassVar, Protocol

import numpy as np

from asap import _checks, _core
from asap.events import EVENT_DTYPE, Events

__all__ = ["FlightOverChairs", "Reader", "ShakenPattern", "SyntheticStream", "joined"]

_EVENTS_PER_ARRAY = 2**16


class Reader(Protocol):
    """One reading of a stream, from its start."""

    def read(self, at_least: int) -> Events:
        """Return a new array of at least so many events, fewer at the end, then none."""
        ...


def joined(arrays: Sequence[Events]) -> Events:
    """One array of all these events; np.concatenate alone would drop the padding."""
    if not isinstance(arrays, Sequence) or isinstance(arrays, str):
        raise TypeError(_checks.named("arrays", arrays, "give a list of arrays"))
    for array in arrays:
        _checks.unmasked("arrays", array)
        if getattr(array, "dtype", None) != EVENT_DTYPE or array.ndim != 1:
            raise TypeError(_checks.named("arrays", array, "give arrays in asap.EVENT_DTYPE"))
    events = np.empty(sum(map(len, arrays)), EVENT_DTYPE)
    if arrays:
        np.concatenate(arrays, out=events)
    return events


class SyntheticStream:
    """The common part of the synthetic streams: each can be read again and again.

    Iterating yields fresh arrays in ``EVENT_DTYPE``, of shape (n,) with n a little above 2**16 (the
    last one may be shorter), in time order. Every ``iter()`` starts anew with the same events. The
    GIL is released while events are made.

    Attributes
    ----------
    name : str
        How the stream is called in tables and files.
    """

    name: str
    _native: ClassVar[Callable[..., _core.EventStream]]

    def __init__(self, **parameters: Any) -> None:
        duration_s, seed = parameters["duration_s"], parameters["seed"]
        _checks.number("duration_s", duration_s, 0.01, 86_400, "give 0.01 to 86400 s")
        _checks.whole("seed", seed, 0, 2**64 - 1, "give an integer from 0 to 2**64 - 1")
        self._parameters = parameters
        self._open()  # checks the other parameters

    @property
    def parameters(self) -> dict[str, Any]:
        """The constructor's arguments by name."""
        return dict(self._parameters)

    @property
    def width(self) -> int:
        """Columns of the sensor, px."""
        return int(self._parameters["width"])

    @property
    def height(self) -> int:
        """Rows of the sensor, px."""
        return int(self._parameters["height"])

    @property
    def duration_s(self) -> float:
        """Events lie in [t0, t0 + duration), s."""
        return float(self._parameters["duration_s"])

    def __iter__(self) -> Iterator[Events]:
        """Yield the events from the start, array by array."""
        stream = self._open()
        while (events := stream.read(_EVENTS_PER_ARRAY)).size:
            yield events

    def events(self) -> Events:
        """All events at once.

        Returns
        -------
        ndarray of shape (n,) in EVENT_DTYPE
            16 bytes per event, twice that while it is put together: 0.9 GB for the default
            ``ShakenPattern``. Iterate where memory is short.
        """
        return joined(list(self))

    def __repr__(self) -> str:
        arguments = ", ".join(f"{name}={value!r}" for name, value in self._parameters.items())
        return f"{type(self).__name__}({arguments})"

    def _open(self) -> Reader:
        arguments = self.parameters
        arguments["duration_us"] = round(float(arguments.pop("duration_s")) * 1e6)
        return type(self)._native(**arguments)


class ShakenPattern(SyntheticStream):
    """Abrupt motion: a printed pattern shaken harder and harder.

    A poster of small disks, squares and triangles moves on an ellipse whose radius and frequency
    both grow. The event rate climbs as ``first + (last - first) (t / duration)**1.5``, with pulses
    of 10 % at twice the frequency of the shake.

    Parameters
    ----------
    duration_s : float
        0.01 to 86400 s.
    seed : int
        0 <= seed < 2**64. Decides on the print, the thresholds of its edges and the noise.
    width, height : int
        Size of the sensor, 16 to 8192 px.
    first_rate_hz, last_rate_hz : float
        Events per second that the pattern causes at the start and at the end; the last at most 500
        per pixel.
    amplitude_px : float
        Longer half-axis of the shake at the end, 4 to 1000 px; a tenth of it at the start.
    noise_hz : float
        Background events per second and pixel, at most ``1e6 / (width * height)``.
    t0_us : int
        Timestamp at which the stream starts, us.

    Notes
    -----
    Edges are sharp and of one contrast, shapes lie in one plane; there is no lens, no bandwidth and
    no refractory time. After the experiment "abrupt motion" of Tapia et al. (2020), whose rate
    bound is a = 5e6 events/s.

    Examples
    --------
    >>> sum(len(events) for events in ShakenPattern(duration_s=0.1)) > 100_000
    True
    """

    name = "shaken_pattern"
    _native = _core.ShakenPatternStream

    def __init__(
        self,
        *,
        duration_s: float = 5.0,
        seed: int = 0,
        width: int = 346,
        height: int = 260,
        first_rate_hz: float = 0.1e6,
        last_rate_hz: float = 13e6,
        amplitude_px: float = 18.0,
        noise_hz: float = 0.1,
        t0_us: int = 0,
    ) -> None:
        SyntheticStream.__init__(**locals())  # self and the parameters, by name


class FlightOverChairs(SyntheticStream):
    """On board a UAV: a slightly swaying flight over a growing number of chairs.

    Chairs stand in rows that enter the view at the top and leave it at the bottom, a few at first,
    full rows at the end, while the flight gets faster. The event rate grows from about 0.1 to
    1.8 Mev/s.

    Parameters
    ----------
    duration_s : float
        0.01 to 86400 s.
    seed : int
        0 <= seed < 2**64. Decides on the chairs, the thresholds of their edges and the noise.
    width, height : int
        Size of the sensor, 16 to 8192 px.
    last_rate_hz : float
        Events per second that the chairs cause at the end, within about 15 %; at most 100 per
        pixel. It sets the speed: on a bigger sensor give more, or more time, for as long a flight.
    chair_px : float
        Width of a chair, 8 px to half the sensor's width.
    noise_hz : float
        Background events per second and pixel, at most ``1e6 / (width * height)``.
    t0_us : int
        Timestamp at which the stream starts, us.

    Notes
    -----
    Seen from far above in parallel projection: chairs neither grow nor hide each other. The other
    limits are those of `ShakenPattern`. After the experiment on board of Tapia et al. (2020), whose
    rate stayed below a = 5e6 events/s.

    Examples
    --------
    >>> FlightOverChairs(duration_s=0.1).events().dtype.names
    ('x', 'y', 'p', 't')
    """

    name = "flight_over_chairs"
    _native = _core.FlightOverChairsStream

    def __init__(
        self,
        *,
        duration_s: float = 4.0,
        seed: int = 0,
        width: int = 346,
        height: int = 260,
        last_rate_hz: float = 1.8e6,
        chair_px: float = 40.0,
        noise_hz: float = 0.1,
        t0_us: int = 0,
    ) -> None:
        SyntheticStream.__init__(**locals())  # self and the parameters, by name
