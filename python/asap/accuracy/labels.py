"""Labels of events against what the tracker returned for them: accuracy, leak, first id."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from asap.accuracy.matching import Matched
from asap.accuracy.mota import ratio
from asap.accuracy.scene import NOISE
from asap.accuracy.trace import Trace

SETTLED_US = 200_000  #: events before it do not count


class Confirmation(NamedTuple):
    """How soon objects get their first id."""

    time_to_confirm_ms: float  #: median over the objects that got one; NaN if none did
    confirmed: float  #: share of the objects that got one


def event_accuracy(trace: Trace, matches: Sequence[Matched]) -> float:
    """Share of the object events after 200 ms that were returned with the object's matched id.

    Parameters
    ----------
    trace : Trace
    matches : sequence of Matched
        Of its samples. The matched id of an object at an event is the one that it was matched to in
        the newest sample not after the event, or, if it was missed there, before.

    Returns
    -------
    float
        NaN where the tracker returns no ids.
    """
    if trace.ids is None:
        return float("nan")
    correct = total = 0
    bounds = np.searchsorted(trace.t_us, [one.sample.t_us for one in matches]).tolist()
    for one, (begin, end) in zip(matches, pairwise([*bounds, trace.t_us.size]), strict=True):
        if one.sample.t_us < SETTLED_US:
            continue
        labels, ids = trace.labels[begin:end], trace.ids[begin:end]
        for label in np.unique(labels[labels != NOISE]).tolist():
            of_object = labels == label
            total += int(of_object.sum())
            if label in one.memory:
                correct += int(np.sum(ids[of_object] == one.memory[label]))
    return ratio(correct, total)


def noise_leak(trace: Trace) -> float:
    """Share of the noise events after 200 ms that were returned with any id; NaN without ids."""
    if trace.ids is None:
        return float("nan")
    noise = (trace.labels == NOISE) & (trace.t_us >= SETTLED_US)
    return ratio(int(np.sum(trace.ids[noise] >= 0)), int(noise.sum()))


def time_to_confirm(trace: Trace, matches: Sequence[Matched]) -> Confirmation:
    """Time from the first event of an object to the first that is returned with an id of its own.

    Parameters
    ----------
    trace : Trace
    matches : sequence of Matched
        Of its samples. Ids of an object's own are those that it was ever matched to: an event that
        a neighbour took does not count.
    """
    if trace.ids is None:
        return Confirmation(float("nan"), float("nan"))
    own: defaultdict[int, set[int]] = defaultdict(set)
    for one in matches:
        for label, id in one.memory.items():
            own[label].add(id)
    waited_us = [
        _first_us(trace, label, own[label]) - first_us for label, first_us in trace.first_us.items()
    ]
    found = [us for us in waited_us if np.isfinite(us)]
    return Confirmation(
        float(np.median(found)) * 1e-3 if found else float("nan"),
        ratio(len(found), len(trace.first_us)),
    )


def _first_us(trace: Trace, label: int, ids: set[int]) -> float:
    assert trace.ids is not None
    hits = np.flatnonzero((trace.labels == label) & np.isin(trace.ids, list(ids)))
    return float(trace.t_us[hits[0]]) if hits.size else float("inf")
