"""The bindings of the corner detectors and BackgroundActivityFilter; tests/cpp tests the rules."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from asap import (
    EVENT_DTYPE,
    ArcStar,
    BackgroundActivityFilter,
    EFast,
    EHarris,
    FAHarris,
)
from golden import fnv, golden_stream

WIDTH, HEIGHT = 346, 260


@pytest.mark.parametrize(
    ("detector", "corners", "hash_value"),
    [
        (EFast, 694, 0x61CE6DCB),
        (ArcStar, 7354, 0x287F6925),
        (FAHarris, 71, 0x9A2DAB8E),
        (EHarris, 724, 0x6DF63B99),
    ],
)
def test_golden_vectors(detector: Any, corners: int, hash_value: int) -> None:
    labels = detector(WIDTH, HEIGHT).process(golden_stream())
    assert labels.dtype == np.bool_
    assert np.count_nonzero(labels) == corners
    assert fnv(labels) == hash_value


@pytest.mark.parametrize(("window_us", "passed"), [(5000, 98_269), (1000, 38_473)])
def test_golden_filter(window_us: int, passed: int) -> None:
    events = golden_stream()
    kept = BackgroundActivityFilter(WIDTH, HEIGHT, window_us=window_us).process(events)
    assert kept.dtype == EVENT_DTYPE
    assert kept.shape == (passed,)
    assert np.isin(kept["t"], events["t"]).all()
    assert np.all(np.diff(kept["t"]) > 0)
    assert kept.flags.writeable


def test_the_filter_returns_whole_events() -> None:
    events = np.array([(5, 5, 1, 0), (30, 7, 0, 10), (6, 4, 1, 20)], EVENT_DTYPE)
    assert BackgroundActivityFilter(WIDTH, HEIGHT).process(events).tolist() == [(6, 4, 1, 20)]
