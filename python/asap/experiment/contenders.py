"""Contenders: the schemes of a comparison, made anew for every run from its latency and cost."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from asap import _checks, _core

Make = Callable[[float, _core.LinearCost], _core.Scheme]


@dataclass(frozen=True)
class Contender:
    """A scheme under a label, ready to be put to any latency and cost."""

    label: str  #: how it is called in tables
    make: Make  #: a new scheme; the cost is for rivals that know what a package will cost
    flush: bool = True  #: gives out what waits when the oldest event has reached the bound
    opaque: bool = False  #: the algorithm takes a package as a whole, as a Python callback does


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
    if "latency_ms" in kind().parameters:
        return lambda latency_ms, cost: kind(latency_ms=latency_ms, **settings)
    return lambda latency_ms, cost: kind(**settings)


def labelled(schemes: Any) -> dict[str, _core.Scheme]:
    """Give every scheme a label: its key in a mapping, else its class and what sets it apart.

    A ValueError if there is none, one stands twice (it has one state), or two labels are the same
    text.
    """
    if isinstance(schemes, str):
        remedy = "give schemes such as [asap.Greedy()], or leave it out"
        raise TypeError(_checks.named("schemes", schemes, remedy))
    named = isinstance(schemes, Mapping)
    given = schemes.values() if named else schemes
    if not isinstance(given, (_core.Scheme, Iterable)):
        raise TypeError(_checks.named("schemes", given, "give schemes such as [asap.Greedy()]"))
    listed = [given] if isinstance(given, _core.Scheme) else list(given)
    for scheme in listed:
        if not isinstance(scheme, _core.Scheme):
            raise TypeError(
                _checks.named("schemes", scheme, "give schemes such as [asap.Greedy()]")
            )
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
