"""asap.GammaFilter from Python."""

import numpy as np
import pytest

import asap
import streams

EVENTS = streams.poisson(1e6, 0.05)


def test_what_passes_is_what_the_mask_says_and_both_count_on():
    whole = asap.GammaFilter(seed=3).apply(EVENTS, 0.3)
    cut = asap.GammaFilter(seed=3)
    mask = np.concatenate([cut.mask(piece, 0.3) for piece in np.array_split(EVENTS, 7)])
    assert whole.dtype == asap.EVENT_DTYPE
    assert whole.tolist() == EVENTS[mask].tolist()
    assert cut.position == EVENTS.size


def test_a_refused_call_loses_nothing():
    gamma_filter = asap.GammaFilter()
    with pytest.raises(ValueError, match=r"gamma = -0\.5"):
        gamma_filter.apply(EVENTS, -0.5)
    assert gamma_filter.position == 0


def test_other_layouts_are_refused_not_scrambled():
    packed = np.zeros(3, [("t", "<i8"), ("x", "<u2"), ("y", "<u2"), ("p", "<i2")])
    with pytest.raises(TypeError, match="as_events"):
        asap.GammaFilter().apply(packed, 0.5)
    with pytest.raises(TypeError, match="as_events"):
        asap.GammaFilter().apply(EVENTS[::2], 0.5)
