"""What a tracker says at a moment: confirmed clusters, extrapolated to it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Snapshot:
    """Clusters at one time, one row each.

    Attributes
    ----------
    ids : ndarray of int64, shape (m,)
    positions : ndarray of float64, shape (m, 2)
        px.
    velocities : ndarray of float64, shape (m, 2), or None
        px/s; None: the tracker has none.
    covariances : ndarray of float64, shape (m, 2, 2), or None
        Of the position's error, px^2; None: the tracker states none.
    """

    ids: NDArray[np.int64]
    positions: NDArray[np.float64]
    velocities: NDArray[np.float64] | None = None
    covariances: NDArray[np.float64] | None = None


def clusters_at(tracker: Any, t_us: int) -> Snapshot:
    """Read the confirmed clusters of a tracker at a time.

    Parameters
    ----------
    tracker : object
        With ``clusters_at(t_us)``, which extrapolates by itself, or ``clusters``. Either gives a
        structured array with id, x, y and, where the tracker knows them, vx, vy [px/s], t_last [us]
        and the covariance pxx, pxy, pyy [px^2] of the error of x, y (infinite: it knows
        none). The fields cxx, cxy, cyy are its extent, not its error, and are not read.
    t_us : int
        Not before the last event that the tracker has seen.

    Returns
    -------
    Snapshot
        Of ``clusters`` the positions are x + vx (t_us - t_last), where both are there.
    """
    extrapolates = hasattr(tracker, "clusters_at")
    table = np.asarray(tracker.clusters_at(t_us) if extrapolates else tracker.clusters)
    names = table.dtype.names or ()
    if not {"id", "x", "y"} <= set(names):
        raise TypeError(f"clusters of {tracker!r} have the fields {names}: need id, x, y")
    positions = _columns(table, "x", "y")
    velocities = _columns(table, "vx", "vy") if {"vx", "vy"} <= set(names) else None
    if velocities is not None and not extrapolates and "t_last" in names:
        positions = positions + velocities * ((t_us - table["t_last"]) * 1e-6)[:, None]
    covariances = None
    if {"pxx", "pxy", "pyy"} <= set(names):
        stated = _columns(table, "pxx", "pxy", "pxy", "pyy").reshape(-1, 2, 2)
        covariances = stated if np.all(np.isfinite(stated)) else None
    return Snapshot(table["id"].astype(np.int64), positions, velocities, covariances)


def _columns(table: NDArray[np.void], *names: str) -> NDArray[np.float64]:
    return np.stack([table[name].astype(np.float64) for name in names], axis=-1)
