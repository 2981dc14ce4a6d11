"""Measures with a literature: by hand, and beside libraries that are well kept."""

import itertools
import math
from types import SimpleNamespace

import numpy as np
import pytest

from asap_laboratory.scoring.matching import assign, distances, match
from asap_laboratory.scoring.measures import (
    SETTLED_US,
    hota,
    idf1,
    mean_chi_square_interval,
    nees,
    noise_leak,
)
from asap_laboratory.scoring.partition import compare_partitions
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


def wild(seed, length=60):
    """Objects that wander, clusters that are born, err, swap and vanish."""
    rng = np.random.default_rng(seed)
    places = rng.uniform(20, 80, (5, 2))
    names = list(range(100, 105))
    objects, clusters = [], []
    for number in range(length):
        places += rng.normal(0, 2, places.shape)
        if number % 10 == 9:
            names[rng.integers(5)] = 200 + number
            i, j = rng.integers(5, size=2)
            names[i], names[j] = names[j], names[i]
        there = [k for k in range(5) if rng.random() < 0.9]
        found = [k for k in range(5) if rng.random() < 0.8]
        objects.append({k: places[k].copy() for k in there})
        clusters.append({names[k]: places[k] + rng.normal(0, 4, 2) for k in found})
        if rng.random() < 0.3:
            clusters[-1][999] = rng.uniform(20, 80, 2)
    return samples_of(objects, clusters)


HERE, NEAR, THERE = (50.0, 50.0), (50.0, 56.0), (150.0, 50.0)


# ---- assignment -----------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(4, 4), (3, 5), (5, 3), (1, 1), (0, 3), (3, 0)])
def test_assignment_is_the_best_of_all(shape):
    rng = np.random.default_rng(sum(shape))
    for _ in range(20):
        cost = rng.integers(-9, 9, shape).astype(float)
        rows, columns = assign(cost)
        assert rows.size == columns.size == min(shape)
        assert np.all(np.diff(rows) > 0) and np.unique(columns).size == columns.size
        wide = cost if shape[0] <= shape[1] else cost.T
        ways = itertools.permutations(range(wide.shape[1]), wide.shape[0])
        best = min(sum(wide[i, j] for i, j in enumerate(way)) for way in ways)
        assert cost[rows, columns].sum() == best


def test_assignment_costs_what_scipys_does():
    scipy_optimize = pytest.importorskip("scipy.optimize")
    rng = np.random.default_rng(0)
    for number in range(40):
        n, m = rng.integers(1, 60, 2)
        cost = rng.normal(size=(n, m)) if number % 2 else rng.integers(0, 4, (n, m)) * 1.0
        expected = cost[scipy_optimize.linear_sum_assignment(cost)].sum()
        assert cost[assign(cost)].sum() == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("cost", [[1.0, 2.0], [[1.0, math.nan]], [[math.inf]]])
def test_assignment_refuses_what_has_no_answer(cost):
    with pytest.raises(ValueError, match="must be a matrix of finite numbers"):
        assign(cost)


# ---- IDF1 and HOTA --------------------------------------------------------------------------


def test_idf1_gives_an_object_the_id_that_it_had_longest():
    # 6 samples under 7, then 4 under 8, and 2 false ones of 9.
    clusters = [{7: HERE}] * 6 + [{8: HERE}] * 2 + [{8: HERE, 9: THERE}] * 2
    found = match(samples_of([{0: HERE}] * 10, clusters))
    assert idf1(found) == 2 * 6 / (10 + 12)
    twins = match(samples_of([{0: HERE, 1: NEAR}] * 3, [{7: HERE, 8: NEAR}] * 3))
    assert idf1(twins) == 1  # both ids are near both objects


def test_idf1_assigns_all_tracks_together():
    # 7 fits object 0 best, but then nobody is left for object 1.
    objects = [{0: HERE}] * 5 + [{1: HERE}] * 4 + [{0: HERE}] * 3
    clusters = [{7: HERE}] * 5 + [{7: HERE}] * 4 + [{8: HERE}] * 3
    assert idf1(match(samples_of(objects, clusters))) == 2 * (4 + 3) / 24


def test_clusters_that_are_excused_do_not_count():
    excused = samples_of([{0: HERE, 1: THERE}], [{7: HERE, 8: THERE}])[0]
    excused = excused._replace(active=np.array([True, False]))
    assert idf1(match([excused])) == 1
    assert hota(match([excused])) == (1, 1, 1)


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


def test_hota_halves_the_association_where_the_id_changes_halfway():
    found = hota(match(samples_of([{0: HERE}] * 8, [{7: HERE}] * 4 + [{8: HERE}] * 4)))
    assert found == pytest.approx((0.5**0.5, 1, 0.5))


def test_hota_falls_with_the_distance():
    # 6 of 24 px: similarity .75, enough for 15 of the 19 thresholds.
    found = hota(match(samples_of([{0: HERE}] * 3, [{7: NEAR}] * 3)))
    assert found == pytest.approx((15 / 19, 15 / 19, 15 / 19))
    gate = hota(match(samples_of([{0: HERE}] * 3, [{7: (62, 50)}] * 3)))  # .5 holds for ten
    assert gate.detection == pytest.approx(10 / 19)


def test_noise_that_leaks_counts_once_it_is_settled():
    trace = SimpleNamespace(
        labels=np.array([-1, -1]),
        ids=np.array([-1, 5]),
        t_us=np.array([SETTLED_US - 1, SETTLED_US]),
    )
    assert noise_leak(trace) == 1.0


def trackeval_data(matches):
    """Data as TrackEval's metrics take them."""
    objects = sorted({int(one) for m in matches for one in m.sample.objects})
    ids = sorted({int(one) for m in matches for one in m.sample.clusters.ids[m.counted]})
    truth = [np.searchsorted(objects, m.sample.objects[m.sample.active]) for m in matches]
    seen = [np.searchsorted(ids, m.sample.clusters.ids[m.counted]) for m in matches]
    similar = [
        np.maximum(0, 1 - distances(m.sample) / 24)[np.ix_(m.sample.active, m.counted)]
        for m in matches
    ]
    return {
        "num_gt_ids": len(objects),
        "num_tracker_ids": len(ids),
        "num_gt_dets": sum(map(len, truth)),
        "num_tracker_dets": sum(map(len, seen)),
        "num_timesteps": len(matches),
        "gt_ids": truth,
        "tracker_ids": seen,
        "similarity_scores": similar,
    }


@pytest.mark.parametrize("seed", range(4))
def test_idf1_and_hota_are_trackevals(seed):
    trackeval = pytest.importorskip("trackeval")
    matches = match(wild(seed))
    data = trackeval_data(matches)
    identity = trackeval.metrics.Identity({"THRESHOLD": 0.5 + 1e-9, "PRINT_CONFIG": False})
    assert idf1(matches) == pytest.approx(identity.eval_sequence(data)["IDF1"])
    theirs = trackeval.metrics.HOTA().eval_sequence(data)
    found = hota(matches)
    assert found.hota == pytest.approx(theirs["HOTA"].mean())
    assert found.detection == pytest.approx(theirs["DetA"].mean())
    assert found.association == pytest.approx(theirs["AssA"].mean())
    assert 0.2 < found.hota < 0.7 and 0.2 < idf1(matches) < 0.8


# ---- partitions -----------------------------------------------------------------------------


def test_partitions_by_hand():
    same = compare_partitions([1, 1, 2, 2, -1], [8, 8, 9, 9, -1])
    assert same == pytest.approx((1, 1, 1, 1, 1))
    merged = compare_partitions([1, 1, 2, 2], [8, 8, 8, 8])
    assert merged == pytest.approx((0, 1, 0, 0, 2 / 3))
    split = compare_partitions([1, 1, 1, 1], [8, 8, 8, 9])
    assert split == pytest.approx((1, 0, 0, 0, 6 / 7))
    crossed = compare_partitions([1, 1, 2, 2], [8, 9, 8, 9])
    assert crossed == pytest.approx((0, 0, 0, -0.5, 0.5), abs=1e-12)
    mixed = compare_partitions([1, 1, 1, 2], [8, 8, 9, 9])
    assert mixed.f_measure == pytest.approx((3 * 4 / 5 + 2 / 3) / 4)
    assert all(map(math.isnan, compare_partitions([], [])))


@pytest.mark.parametrize("seed", range(4))
def test_partitions_are_scikit_learns(seed):
    sklearn = pytest.importorskip("sklearn.metrics")
    rng = np.random.default_rng(seed)
    labels = rng.integers(-1, 4, 500)
    ids = np.where(rng.random(500) < 0.7, labels * 3 + rng.integers(0, 2, 500), -1)
    found = compare_partitions(labels, ids)
    h, c, v = sklearn.homogeneity_completeness_v_measure(labels, ids)
    assert found[:3] == pytest.approx((h, c, v))
    assert found.ari == pytest.approx(sklearn.adjusted_rand_score(labels, ids))
    assert 0.1 < found.v_measure < 0.9 and 0.1 < found.ari < 0.9


# ---- NEES -----------------------------------------------------------------------------------


def test_nees_weighs_the_error_with_the_covariance():
    covariances = [[[[4.0, 0.0], [0.0, 1.0]]], [[[2.0, 1.0], [1.0, 2.0]]]]
    found = nees(match(samples_of([{0: HERE}] * 2, [{7: (52, 51)}, {7: (51, 50)}], covariances)))
    assert found.nees == pytest.approx((2**2 / 4 + 1 + 2 / 3) / 2)
    assert (found.nees_low, found.nees_high) == mean_chi_square_interval(2)


def test_nees_needs_a_covariance_and_a_match():
    assert all(map(math.isnan, nees(match(samples_of([{0: HERE}], [{7: HERE}])))))
    nobody = samples_of([{0: HERE}], [{}], [np.empty((0, 2, 2))])
    assert all(map(math.isnan, nees(match(nobody))))


def test_nees_of_a_consistent_tracker_lies_in_the_interval():
    rng = np.random.default_rng(3)
    covariance = np.array([[1.0, 0.3], [0.3, 0.5]])
    errors = rng.multivariate_normal([0, 0], covariance, 500)
    clusters = [{7: (50 + dx, 50 + dy)} for dx, dy in errors]
    found = nees(match(samples_of([{0: HERE}] * 500, clusters, [[covariance]] * 500)))
    assert found.nees_low < found.nees < found.nees_high
    bold = nees(match(samples_of([{0: HERE}] * 500, clusters, [[covariance / 2]] * 500)))
    assert bold.nees > bold.nees_high


@pytest.mark.parametrize("count", [1, 2, 17, 500, 5600])
def test_interval_is_the_chi_squares(count):
    stats = pytest.importorskip("scipy.stats")
    expected = stats.chi2.ppf([0.025, 0.975], 2 * count) / count
    assert mean_chi_square_interval(count) == pytest.approx(expected, rel=1e-9)
    outer = stats.chi2.ppf([0.005, 0.995], 2 * count) / count
    assert mean_chi_square_interval(count, 0.99) == pytest.approx(outer, rel=1e-9)


def test_interval_of_one_error_in_closed_form():
    expected = (-2 * math.log(0.975), -2 * math.log(0.025))
    assert mean_chi_square_interval(1) == pytest.approx(expected, rel=1e-9)
