"""Measures with a literature, by hand."""

import math

import numpy as np
import pytest

from asap_laboratory.scoring.matching import match
from asap_laboratory.scoring.measures import hota, idf1, nees
from asap_laboratory.scoring.trace import Sample, Snapshot


def samples_of(objects, clusters, covariances=None):
    """Samples from lists of {label: (x, y)} and {id: (x, y)}; every object is active."""
    found = []
    for number, (truth, seen) in enumerate(zip(objects, clusters, strict=True)):
        centres = np.array(list(truth.values()), float).reshape(-1, 2)
        snapshot = Snapshot(
            np.array(list(seen), np.int64),
            np.array(list(seen.values()), float).reshape(-1, 2),
            None,
            None if covariances is None else np.array(covariances[number], float),
        )
        labels = np.array(list(truth), np.int64)
        active = np.ones(labels.size, bool)
        found.append(Sample(5000 * number, labels, centres, 0 * centres, active, snapshot))
    return found


HERE, NEAR, THERE = (50.0, 50.0), (50.0, 56.0), (150.0, 50.0)


# ---- IDF1 and HOTA --------------------------------------------------------------------------


def test_idf1_agrees_up_to_the_gate():
    # 11 px is nearer than the gate of 12 px, 12 px is not.
    assert idf1(match(samples_of([{0: HERE}] * 2, [{7: (61, 50)}, {7: (62, 50)}]))) == 2 * 1 / 4


def test_idf1_does_not_credit_a_cluster_that_is_excused():
    # 8 is near object 0 too, but only an inactive object keeps it from being false.
    both, alone = {7: HERE, 8: NEAR}, {8: HERE}
    samples = samples_of([{0: HERE, 1: (50.0, 60.0)}] * 4, [both] * 3 + [alone])
    samples = [one._replace(active=np.array([True, False])) for one in samples]
    assert idf1(match(samples)) == 2 * 3 / (4 + 4)


def test_hota_of_a_perfect_tracker_and_of_none():
    seen = [{7: HERE, 8: THERE}] * 4
    assert hota(match(samples_of([{0: HERE, 1: THERE}] * 4, seen))) == pytest.approx((1, 1, 1))
    assert hota(match(samples_of([{0: HERE}] * 4, [{}] * 4))) == (0, 0, 0)
    assert all(map(math.isnan, hota(match(samples_of([{}], [{}])))))
    assert math.isnan(idf1(match(samples_of([{}], [{}]))))


def test_hota_falls_with_the_distance():
    # 6 of 24 px: similarity .75, enough for 15 of the 19 thresholds.
    found = hota(match(samples_of([{0: HERE}] * 3, [{7: NEAR}] * 3)))
    assert found == pytest.approx((15 / 19, 15 / 19, 15 / 19))
    gate = hota(match(samples_of([{0: HERE}] * 3, [{7: (62, 50)}] * 3)))  # .5 holds for ten
    assert gate.detection == pytest.approx(10 / 19)


# ---- NEES -----------------------------------------------------------------------------------


def test_nees_weighs_the_error_with_the_covariance():
    covariances = [[[[4.0, 0.0], [0.0, 1.0]]], [[[2.0, 1.0], [1.0, 2.0]]]]
    found = nees(match(samples_of([{0: HERE}] * 2, [{7: (52, 51)}, {7: (51, 50)}], covariances)))
    assert found == pytest.approx((2**2 / 4 + 1 + 2 / 3) / 2)


def test_nees_needs_a_covariance_and_a_match():
    assert math.isnan(nees(match(samples_of([{0: HERE}], [{7: HERE}]))))
    unmatched = samples_of([{0: HERE}], [{}], [np.empty((0, 2, 2))])
    assert math.isnan(nees(match(unmatched)))
