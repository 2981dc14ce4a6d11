"""score: how good an algorithm is on a scene whose truth is known."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from asap import _checks
from asap_laboratory.scoring.boxes import BoxScene, box_matches, box_score, frames
from asap_laboratory.scoring.corners import corners
from asap_laboratory.scoring.matching import match
from asap_laboratory.scoring.measures import hota, idf1, mota, nees, ratio, v_measure
from asap_laboratory.scoring.scene import Scene, check_scene
from asap_laboratory.scoring.trace import Feed, Trace, follow, run_through, snapshots_at


def score(
    tracker: Any,
    scene: Scene | BoxScene,
    *,
    before: Any = None,
    gamma: float = 1.0,
    told: bool = True,
    seed: int = 0,
) -> dict[str, float]:
    """Score a tracker, or a corner detector, on a scene with truth.

    Parameters
    ----------
    tracker : object with process(events)
        Fresh, or reset. A tracker has ``objects`` (and ``objects_at(t_us)``), or
        ``clusters_at(t_us)`` or ``clusters``, a structured array with id, x, y and, as far as it
        knows them, vx, vy, t_last and the covariance pxx, pxy, pyy of the position's error; its
        ``process`` may return the id of each event, -1 for none. Where it has objects with
        ``to_objects(labels)``, these are judged, and clusters by the object that they are a part
        of. An algorithm without clusters whose ``process`` returns a bool for each event is a
        corner detector.
    scene : Scene
        Such as ``scenes.A()``: events, labels (-1 = noise), truth(t_us), width, height; for a
        corner detector also vertices(t_us). Or a recording with boxes, such as
        ``scenes.labelled(folder)``, for a tracker.
    before : object with process(events), optional
        A fresh filter in front, such as `asap.BackgroundActivityFilter`: returns the events that
        pass, or a bool for each. Labels follow the events that pass; active objects are then those
        with 5 such events.
    gamma : float
        Fraction of the events behind the filter that is kept, uniformly and independently.
    told : bool
        Whether the algorithm gets ``set_gamma(gamma)``, where it has it; not called at gamma = 1.
    seed : int
        Of the thinning.

    Returns
    -------
    dict
        NaN where a figure does not exist. Of a tracker:

        ================================= ==================================================
        mota, id_switches                 1 - (FN + FP + switches) / (TP + FN)
        recall, precision                 TP / (TP + FN), TP / (TP + FP)
        true_positives, false_negatives,  samples of active objects that are matched, missed;
        false_positives                   clusters without an object
        position_rms                      px
        velocity_rms                      fraction of the rms speed
        idf1                              one assignment of ids to objects for the whole scene
        hota, det_a, ass_a                similarity 1 - d / 24 px
        v_measure                         the events as a partition, noise as a class
        nees                              errors against pxx, pxy, pyy; 2: as large as stated
        ================================= ==================================================

        Of a tracker on a recording with boxes, at every labelled time:

        ========= ==========================================================================
        hit       boxes that are matched: a cluster's centre inside or up to 2 px beyond
        precision matched clusters of all outside the ignore zones; NaN where the background
                  is not labelled: precision not judged
        switches  changes of an object's id
        longest   share of an object's boxes that its best id matched, mean over the objects
        error     px, median distance of the centres
        iou       intersection over union of a matched box and the cluster's (`left` to `height`,
                  else 1.75 standard deviations of its events to each side), mean; NaN: no extent
        mota      1 - (misses + false + switches) / boxes; NaN like precision
        ========= ==========================================================================

        Of a corner detector: precision, recall, false_positive_rate, f_measure, corner_events,
        true_corners. Of all: ns_per_event, ns_per_event_p50, ns_per_event_p999 (time in filter and
        algorithm by the events that enter the first of them; whole, and quantiles over the
        packages, of 5 ms or from one labelled time to the next), events (of the scene) and
        processed (that reached the algorithm).

    Raises
    ------
    TypeError
        No scene, or neither a tracker nor a corner detector.
    ValueError
        gamma is not in (0, 1], or an array does not fit the events.

    Notes
    -----
    Every 5 ms from 100 ms on, clusters are matched greedily to active objects (those with 5 events
    since the previous sample) less than 12 px away, or than the scene's ``match_radii_px``. Event
    figures are of the events after 200 ms that reached the tracker. The events of a package are
    those before its sample time. Without ``clusters_at`` positions are extrapolated by
    vx (t - t_last).

    Examples
    --------
    >>> score(asap.ClusterTracker(346, 260), scenes.A(seed=0))["mota"]  # doctest: +SKIP
    """
    if not hasattr(scene, "boxes"):
        check_scene(scene)
    gamma = _checks.number("gamma", gamma, math.ulp(0.0), 1, "must be in (0, 1]")
    _checks.flag("told", told)
    for name, value in (("tracker", tracker), ("before", before)):
        _checks.worker(name, value)
        if not (hasattr(value, "process") or (name == "before" and value is None)):
            raise TypeError(_checks.named(name, value, "give an object with process(events)"))
    if gamma < 1 and told and can_be_told(tracker):
        _tell(tracker, gamma, filter_upstream=before is not None)
    options: dict[str, Any] = {"before": before, "gamma": gamma, "seed": seed}
    figures, feed = _figures(tracker, scene, options)
    return {**figures, **_cost(feed), "events": scene.events.size, "processed": feed.indices.size}


def _figures(tracker: Any, scene: Any, options: dict[str, Any]) -> tuple[dict[str, float], Feed]:
    if not (hasattr(tracker, "clusters") or hasattr(tracker, "clusters_at")):
        if hasattr(scene, "boxes"):
            raise TypeError(_checks.named("tracker", tracker, "boxes need clusters"))
        feed = run_through(tracker, scene, **options)
        if feed.returned is None or feed.returned.dtype != np.bool_:
            raise TypeError(
                f"tracker = {tracker!r}: it has neither clusters nor clusters_at(t_us), and its "
                "process does not return a bool for each event"
            )
        return corners(scene, feed)._asdict(), feed
    if hasattr(scene, "boxes"):
        times = [int(frame["t_us"][0]) for frame in frames(scene.boxes)]
        snapshots, feed = snapshots_at(tracker, scene, times, **options)
        return box_score(scene, box_matches(scene, snapshots))._asdict(), feed
    trace = follow(tracker, scene, **options)
    return _of_tracker(trace), trace.feed


def can_be_told(algorithm: Any) -> bool:
    """Whether an algorithm takes the kept fraction."""
    return hasattr(algorithm, "set_gamma")


def _tell(algorithm: Any, gamma: float, *, filter_upstream: bool) -> None:
    try:
        algorithm.set_gamma(gamma, filter_upstream=filter_upstream)
    except TypeError:  # it has no such parameter
        algorithm.set_gamma(gamma)


def _of_tracker(trace: Trace) -> dict[str, float]:
    matches = match(trace.samples)
    found = hota(matches)
    return {
        **mota(matches)._asdict(),
        "idf1": idf1(matches),
        "hota": found.hota,
        "det_a": found.detection,
        "ass_a": found.association,
        "v_measure": v_measure(trace),
        "nees": nees(matches),
    }


def _cost(feed: Feed) -> dict[str, float]:
    worked = feed.entered > 0
    each = feed.busy_ns[worked] / feed.entered[worked]
    p50, p999 = np.quantile(each, (0.5, 0.999)) if each.size else (np.nan, np.nan)
    return {
        "ns_per_event": ratio(int(feed.busy_ns.sum()), int(feed.entered.sum())),
        "ns_per_event_p50": float(p50),
        "ns_per_event_p999": float(p999),
    }
