"""`Tiled`: one algorithm on several threads."""

from __future__ import annotations

import os
from typing import Any, TypeVar

from asap import _core

_Algorithm = TypeVar("_Algorithm")


def Tiled(
    algorithm: type[_Algorithm],
    width: int,
    height: int,
    *,
    threads: int | None = None,
    **parameters: Any,
) -> _Algorithm:
    """Make an algorithm that works on several threads, with the answers of one instance.

    The sensor is cut into bands of rows, each with an instance of its own, which sees the rows
    around too. Equal to the bit, however the stream is cut into packages. A package that is too
    small to be worth the meeting of the threads is work for one: measured, by the size of the
    package.

    Parameters
    ----------
    algorithm : type
        EFast, ArcStar, EHarris, FAHarris, PlaneFlow, BackgroundActivityFilter or
        ThresholdOrdinalSurface.
    width, height : int
        Size of the sensor, px, 1 to 16384.
    threads : int or None
        1 to 64, the caller's included. None: one for each processor that this process may use.
    **parameters
        Those of the algorithm.

    Returns
    -------
    algorithm
        One with the methods and properties of `algorithm`, and `threads` among its parameters.

    Raises
    ------
    TypeError
        No class, or one whose answers may depend on more than the rows around an event.
    ValueError
        A parameter is out of range; the message names it.

    Examples
    --------
    >>> scene = asap.synthetic.FlightOverChairs(duration_s=0.1)
    >>> events = scene.events()
    >>> one = asap.EFast(scene.width, scene.height)
    >>> tiled = asap.Tiled(asap.EFast, scene.width, scene.height, threads=2)
    >>> np.array_equal(tiled.process(events), one.process(events))
    True
    """
    made = vars(algorithm).get("_Tiled") if isinstance(algorithm, type) else None
    if made is None:
        fit = ", ".join(kind.__name__ for kind in _core.ALGORITHMS if "_Tiled" in vars(kind))
        if isinstance(algorithm, type):
            what = f"{algorithm.__name__}: an answer may need more than the rows around an event"
        else:
            what = f"{algorithm!r}: must be a class"
        raise TypeError(f"algorithm = {what}. Give one of {fit}.")
    if threads is None:
        has_affinity = hasattr(os, "sched_getaffinity")
        usable = len(os.sched_getaffinity(0)) if has_affinity else os.cpu_count() or 1
        threads = min(usable, 64)
    tiled: _Algorithm = made(width, height, threads=threads, **parameters)
    return tiled
