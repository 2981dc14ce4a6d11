"""The matching protocol, and what is counted from it: every case by hand."""

import numpy as np
import pytest

from asap_laboratory.scoring.matching import match
from asap_laboratory.scoring.measures import mota
from asap_laboratory.scoring.trace import Sample, Snapshot, follow
from fake_scene import FakeScene, perfect


def sample(objects, clusters, *, active=None, t_us=100_000, speeds=None, velocities=None):
    """Objects {label: (x, y)}, clusters {id: (x, y)}; all objects are active unless given."""
    labels = np.array(list(objects), np.int64)
    return Sample(
        t_us,
        labels,
        np.array(list(objects.values()), float).reshape(-1, 2),
        np.array(speeds if speeds is not None else [[0, 0]] * len(objects), float),
        np.isin(labels, list(objects) if active is None else active),
        Snapshot(
            np.array(list(clusters), np.int64),
            np.array(list(clusters.values()), float).reshape(-1, 2),
            None if velocities is None else np.array(velocities, float),
        ),
    )


def counts(*samples):
    found = mota(match(samples))
    return found.true_positives, found.false_negatives, found.false_positives, found.id_switches


def ids_of(matched):
    """Object: id."""
    ids = matched.sample.clusters.ids
    return {int(matched.sample.objects[row]): int(ids[column]) for row, column in matched.pairs}


# ---- matching -------------------------------------------------------------------------------


def test_a_cluster_counts_if_it_is_less_than_12_px_away():
    assert counts(sample({0: (50, 50)}, {7: (50, 61.99)})) == (1, 0, 0, 0)
    assert counts(sample({0: (50, 50)}, {7: (50, 62)})) == (0, 1, 1, 0)
    assert counts(sample({0: (50, 50)}, {7: (58.5, 58.5)})) == (0, 1, 1, 0)  # 12.02 px


def test_a_large_object_has_a_wider_gate():
    one = sample({0: (50, 50), 1: (150, 50)}, {7: (50, 69.99), 8: (150, 62)})
    wide = one._replace(gates_px=np.array([20.0, 12.0]))
    assert counts(one) == (0, 2, 2, 0)
    assert counts(wide) == (1, 1, 1, 0)
    idle = wide._replace(active=np.array([False, True]))
    assert counts(idle) == (0, 1, 1, 0)  # excused


def test_the_nearest_pair_goes_first_one_to_one():
    # An optimal assignment would match both objects.
    one = sample({0: (50, 50), 1: (60, 50)}, {7: (59, 50), 8: (71, 50)})
    assert [ids_of(matched) for matched in match([one])] == [{1: 7}]
    assert counts(one) == (1, 1, 1, 0)
    far = sample({0: (50, 50), 1: (60, 50)}, {7: (59, 50), 8: (41, 50)})
    assert [ids_of(matched) for matched in match([far])] == [{1: 7, 0: 8}]


def test_an_object_keeps_its_id_although_another_is_nearer():
    first = sample({0: (50, 50)}, {7: (50, 50)})
    then = sample({0: (50, 50)}, {7: (58, 50), 8: (51, 50)})
    assert [ids_of(matched) for matched in match([first, then])] == [{0: 7}, {0: 7}]
    assert counts(first, then) == (2, 0, 1, 0)
    gone = sample({0: (50, 50)}, {7: (62, 50), 8: (51, 50)})
    assert counts(first, gone) == (2, 0, 1, 1)  # out of the gate: the memory does not help


def test_a_switch_is_another_id_than_before_and_the_memory_survives_misses():
    seen, missed = sample({0: (50, 50)}, {7: (50, 50)}), sample({0: (50, 50)}, {})
    other = sample({0: (50, 50)}, {8: (50, 50)})
    assert counts(seen, missed, seen) == (2, 1, 0, 0)
    assert counts(seen, missed, other) == (2, 1, 0, 1)
    assert counts(seen, other, seen) == (3, 0, 0, 2)
    quiet = sample({0: (50, 50)}, {}, active=[])
    assert counts(seen, quiet, other) == (2, 0, 0, 1)


def test_an_inactive_object_is_neither_missed_nor_matched_but_excuses_a_cluster():
    assert counts(sample({0: (50, 50)}, {}, active=[])) == (0, 0, 0, 0)
    assert counts(sample({0: (50, 50)}, {7: (61.9, 50)}, active=[])) == (0, 0, 0, 0)
    assert counts(sample({0: (50, 50)}, {7: (62, 50)}, active=[])) == (0, 0, 1, 0)
    both = sample({0: (50, 50), 1: (60, 50)}, {7: (55, 50), 8: (56, 50)}, active=[1])
    assert counts(both) == (1, 0, 0, 0)
    assert match([both])[0].counted.tolist() == [False, True]


# ---- sums -----------------------------------------------------------------------------------


def test_mota_recall_and_precision():
    samples = [
        sample({0: (50, 50), 1: (90, 50)}, {7: (53, 54), 9: (200, 200)}),
        sample({0: (50, 50), 1: (90, 50)}, {8: (50, 50), 4: (90, 50)}),
    ]
    found = mota(match(samples))  # TP 3, FN 1, FP 1, switches 1
    assert found.mota == 1 - 3 / 4
    assert (found.recall, found.precision) == (3 / 4, 3 / 4)
    assert found.position_rms == pytest.approx((25 / 3) ** 0.5)
    worse = [sample({0: (50, 50)}, {7: (0, 0), 8: (200, 0), 9: (0, 200)})]
    assert mota(match(worse)).mota == -3


def test_velocity_error_is_relative_to_the_rms_speed():
    one = sample({0: (50, 50)}, {7: (50, 50)}, speeds=[(30, 40)], velocities=[(30, 30)])
    assert mota(match([one])).velocity_rms == pytest.approx(10 / 50)
    fast = sample({0: (50, 50)}, {7: (50, 50)}, speeds=[(300, 400)], velocities=[(300, 400)])
    assert mota(match([one, fast])).velocity_rms == pytest.approx((100 / 252_500) ** 0.5)
    assert np.isnan(mota(match([sample({0: (50, 50)}, {7: (50, 50)})])).velocity_rms)


# ---- samples --------------------------------------------------------------------------------


def test_a_tracker_has_seen_the_events_before_a_sample_and_no_other():
    scene = FakeScene([(50, 50, 0, 0)], end_us=110_002)
    tracker = perfect(scene)
    trace = follow(tracker, scene)
    assert [package["t"][-1] for package in tracker.packages] == [99_000, 104_000, 109_000, 110_000]
    assert np.concatenate(tracker.packages).tolist() == scene.events.tolist()
    assert [one.t_us for one in trace.samples] == [100_000, 105_000, 110_000]


def test_five_events_since_the_sample_before_make_an_object_active():
    scene = FakeScene([(50, 50, 0, 0)] * 2, end_us=110_001, silent={1: (100_000, 101_000)})
    actives = [one.active.tolist() for one in follow(perfect(scene), scene).samples]
    assert actives == [[True, True], [True, False], [True, True]]
