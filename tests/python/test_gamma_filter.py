"""asap.GammaFilter from Python."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import asap
import streams

EVENTS = streams.poisson(1e6, 0.05)


@given(
    gamma=st.floats(0, 1),
    seed=st.integers(0, 2**64 - 1),
    cuts=st.lists(st.integers(0, EVENTS.size), max_size=8),
)
def test_kept_events_do_not_depend_on_the_cut(gamma, seed, cuts):
    whole = asap.GammaFilter(seed=seed).apply(EVENTS, gamma)
    cut = asap.GammaFilter(seed=seed)
    pieces = [cut.apply(piece, gamma) for piece in np.split(EVENTS, sorted(cuts))]
    np.testing.assert_array_equal(whole["t"], np.concatenate(pieces)["t"])
    mask = asap.GammaFilter(seed=seed).mask(EVENTS, gamma)
    np.testing.assert_array_equal(whole["x"], EVENTS[mask]["x"])
    assert cut.position == EVENTS.size


@given(gammas=st.tuples(st.floats(0, 1), st.floats(0, 1)))
def test_a_smaller_gamma_keeps_a_subset(gammas):
    low, high = (asap.GammaFilter(seed=1).mask(EVENTS, gamma) for gamma in sorted(gammas))
    assert not (low & ~high).any()


def test_the_ends():
    assert asap.GammaFilter().apply(EVENTS, 0.0).size == 0
    kept = asap.GammaFilter().apply(EVENTS, 1.0)
    for name in "xypt":
        np.testing.assert_array_equal(kept[name], EVENTS[name])


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


def test_arrays_of_the_core_stay_in_the_event_dtype():
    kept = asap.GammaFilter().apply(EVENTS, 0.5)
    assert kept.dtype == asap.EVENT_DTYPE
    assert np.concatenate([kept, kept]).dtype == asap.EVENT_DTYPE
