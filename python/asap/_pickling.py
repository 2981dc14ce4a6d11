"""Pickles of what configures a run and of what it results in.

A pickle names the version that wrote it; another version refuses it by name. What the extension
makes pickles by its parameters: schemes and costs; histograms, gamma filters and algorithms with
all that events have left in them.
"""

from __future__ import annotations

import copyreg
import pickle  # only to ask whether something can be pickled; nothing here reads one
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import numpy as np

from asap import _core

T = TypeVar("T")
Reduced = tuple[Callable[..., Any], tuple[Any, ...]]


class Pickled:
    """A class whose objects pickle by their attributes, under the version of this library."""

    def __reduce_ex__(self, protocol: Any) -> tuple[Any, ...]:
        frozen = [
            name
            for name, value in vars(self).items()
            if isinstance(value, np.ndarray) and not value.flags.writeable
        ]
        return _bare, (_core.__version__, type(self)), (self._state(), frozen)

    def __setstate__(self, state: tuple[dict[str, Any], list[str]]) -> None:
        attributes, frozen = state
        self.__dict__.update(attributes)
        for name in frozen:  # a pickle forgets it
            if name in attributes:
                attributes[name].flags.writeable = False

    def __copy__(self: T) -> T:
        twin: T = object.__new__(type(self))
        twin.__dict__.update(self.__dict__)
        return twin

    def _state(self) -> dict[str, Any]:
        """Return the attributes that are pickled."""
        return dict(vars(self))


def by_arguments(make: Callable[..., Any], *positional: Any, **named: Any) -> Reduced:
    """Pickle an object by its constructor's arguments: the value of its ``__reduce__``."""
    return _made, (_core.__version__, make, positional, named)


def can_be_pickled(value: Any) -> bool:
    """Whether pickle takes it; an error of its own ``__reduce__`` is a no."""
    try:
        pickle.dumps(value)
    except Exception:
        return False
    return True


def _made(
    version: str, make: Callable[..., T], positional: tuple[Any, ...], named: Mapping[str, Any]
) -> T:
    _check(version, make)
    return make(*positional, **named)


def _bare(version: str, kind: type[T]) -> T:
    _check(version, kind)
    return object.__new__(kind)


def _check(version: str, make: Any) -> None:
    if version != _core.__version__:
        name = getattr(make, "__qualname__", make)
        raise ValueError(
            f"pickled {name} = of asap {version}: this is asap {_core.__version__}; make it anew, "
            "or read it with the version that wrote it"
        )


def _scheme(scheme: _core.Scheme) -> Reduced:
    return by_arguments(type(scheme), **scheme.parameters)


def _histogram(histogram: _core.LatencyHistogram) -> Reduced:
    return by_arguments(_restored, histogram.state())


def _restored(state: Any) -> _core.LatencyHistogram:
    """Stand for the extension's function, which does not pickle."""
    return _core.LatencyHistogram.restored(state)


def _cost(cost: _core.LinearCost) -> Reduced:
    return by_arguments(_core.LinearCost, **cost.parameters)


def _gamma_filter(gamma_filter: _core.GammaFilter) -> Reduced:
    return by_arguments(_advanced, gamma_filter.position, **gamma_filter.parameters)


def _advanced(position: int, **parameters: Any) -> _core.GammaFilter:
    """Make a gamma filter that has seen so many events."""
    made = _core.GammaFilter(**parameters)
    made.skip(position)
    return made


def _algorithm(algorithm: Any) -> Reduced:
    size = algorithm.width, algorithm.height
    new = by_arguments(type(algorithm), *size, **algorithm.parameters)
    if not _core.has_worked(algorithm):
        return new
    return _going_on, (*new[1], algorithm.state())


def _going_on(
    version: str,
    make: Callable[..., Any],
    positional: tuple[Any, ...],
    named: Mapping[str, Any],
    state: bytes,
) -> Any:
    """Make an algorithm that goes on where another one was."""
    made = _made(version, make, positional, named)
    made.restore(state)
    return made


# Of exactly these classes: a class that a user derives may have a state of its own.
for _kind in _core.SCHEMES:
    copyreg.pickle(_kind, _scheme)
for _algorithms in (
    *(_core.ClusterTracker, _core.FeatureTracker, _core.BackgroundActivityFilter),
    *(_core.HotPixelMask, _core.EFast, _core.ArcStar, _core.EHarris, _core.FAHarris),
    *(_core.ThresholdOrdinalSurface, _core.SpeedInvariantTimeSurface, _core.PlaneFlow),
    _core.EventImage,
):
    copyreg.pickle(_algorithms, _algorithm)
copyreg.pickle(_core.GammaFilter, _gamma_filter)
copyreg.pickle(_core.LinearCost, _cost)
copyreg.pickle(_core.LatencyHistogram, _histogram)
