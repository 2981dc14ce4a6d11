"""info: what a recording holds, in one pass."""

from __future__ import annotations

import os
from dataclasses import asdict
from typing import Any

from asap import _checks, analysis
from asap.io import Recording, read


def info(path: str | os.PathLike[str] | Recording, **options: Any) -> dict[str, Any]:
    """Return what a recording holds: sensor, events, duration, rates, what was rejected.

    The file is read once, in flat memory.

    Parameters
    ----------
    path
        The file, or what `read` returned for it.
    **options
        How to read it, as in `read`: ``width``, ``height``, ``order``, ``time_unit``, ``on_bad``.

    Returns
    -------
    dict
        ``schema_version``, ``path``, ``format``, ``width`` and ``height`` in px or None,
        ``events``, ``duration_s``, ``on_share`` 0..1, ``x_max`` and ``y_max`` in px, ``rate_hz``
        with ``mean``, ``peak_1ms`` and ``peak_10ms`` in ev/s, ``rejected`` by reason,
        ``clock_resets``. It is the object of ``asap info --json``.

    Raises
    ------
    UnsupportedFormat, CorruptFile, NoGoodEvent, ValueError, OSError, RuntimeError
        As in `read`.

    Examples
    --------
    >>> asap.info("flight.aedat4")["rate_hz"]["mean"]  # doctest: +SKIP
    905127.3
    """
    if isinstance(path, (str, os.PathLike)):
        recording = read(path, **options)
    elif not hasattr(path, "rejected"):
        raise TypeError(_checks.named("path", path, "give a path, or what read() returned"))
    elif options:
        raise ValueError(f"{', '.join(options)}: a recording is open; say it to read()")
    else:
        recording = path
    facts = asdict(analysis.describe(recording))
    rates = {name: facts.pop(f"rate_{name}_hz") for name in ("mean", "peak_1ms", "peak_10ms")}
    return {
        "schema_version": 1,
        "path": os.fspath(recording.path),
        "format": recording.format,
        "width": recording.width,
        "height": recording.height,
        **facts,
        "rate_hz": rates,
        "rejected": dict(recording.rejected),
        "clock_resets": recording.clock_resets,
    }
