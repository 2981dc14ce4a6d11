"""asap_laboratory.score: what it hands to whom, and what comes back."""

import math

import numpy as np
import pytest

import asap
import streams
from asap_laboratory import scenes, score
from asap_laboratory.scoring.trace import passed
from fake_scene import CLUSTER_DTYPE, FakeScene, FakeTracker, perfect

TWO = [(50, 50, 100, 0), (150, 100, 0, -50)]


def by_truth(scene):
    """The id of each event as a perfect tracker would return it."""
    table = {tuple(row): label for row, label in zip(scene.events.tolist(), scene.labels)}  # noqa: B905
    return lambda events: [
        10 + table[tuple(e)] if table[tuple(e)] >= 0 else -1 for e in events.tolist()
    ]


def noisy(**others):
    return FakeScene(TWO, end_us=300_001, noise=range(500, 300_000, 3000), **others)


class Odd:
    """A filter that lets the events of odd stamps pass."""

    def __init__(self, as_mask=False):
        self.as_mask = as_mask

    def process(self, events):
        odd = events["t"] // 1000 % 2 == 1
        return odd if self.as_mask else events[odd]


# ---- the whole ------------------------------------------------------------------------------


def test_a_perfect_tracker_scores_ones():
    scene = noisy()
    found = score(perfect(scene, ids=by_truth(scene)), scene)
    for name in ("mota", "recall", "precision", "idf1", "hota", "det_a", "ass_a", "v_measure"):
        assert found[name] == pytest.approx(1)
    for name in ("id_switches", "false_negatives", "false_positives"):
        assert found[name] == 0
    assert found["position_rms"] == found["velocity_rms"] == 0
    assert found["true_positives"] == 2 * 41  # 100, 105 ... 300 ms
    assert math.isnan(found["nees"])
    assert found["events"] == found["processed"] == scene.events.size
    assert 0 < found["ns_per_event_p50"] <= found["ns_per_event_p999"]


def test_nees_reads_the_covariance_of_the_error():
    scene = FakeScene([(50, 50, 0, 0)])

    class Sure(FakeTracker):
        def clusters_at(self, t_us):
            fields = [("id", int), *((name, float) for name in ("x", "y", "pxx", "pxy", "pyy"))]
            return np.array([(1, 52, 51, 4, 0, 0.5)], fields)

    found = score(Sure(None), scene)
    assert found["nees"] == pytest.approx(4 / 4 + 1 / 0.5)
    assert math.isnan(found["velocity_rms"])


def test_clusters_are_extrapolated_where_the_tracker_does_not():
    scene = FakeScene([(50, 50, 200, 0)])

    class Late(FakeTracker):
        """Knows where the object was at the last event."""

        clusters_at = property()  # AttributeError: it has none

        @property
        def clusters(self):
            t_us = int(self.packages[-1]["t"][-1]) if self.packages else 0
            return np.array([(1, 50 + 200 * t_us * 1e-6, 50, 200, 0, t_us)], CLUSTER_DTYPE)

    assert score(Late(None), scene)["position_rms"] == pytest.approx(0, abs=1e-9)

    class Slow(Late):
        @property
        def clusters(self):
            return Late.clusters.fget(self)[["id", "x", "y"]]

    assert score(Slow(None), scene)["position_rms"] == pytest.approx(0.2)  # 1 ms at 200 px/s


def test_objects_are_judged_where_a_tracker_has_them():
    scene = FakeScene([(50, 50, 200, 0)])

    class Grouping(FakeTracker):
        """Clusters 1 and 2 are object 7, cluster 3 is noise."""

        def clusters_at(self, t_us):
            x = 50 + 200 * t_us * 1e-6
            rows = [
                (2, 8, x + 5, 50, 9, 0, 9),
                (1, 9, x, 50, 4, 0, 0.5),
                (3, 99, 200, 200, 9, 0, 9),
            ]
            names = ("x", "y", "pxx", "pxy", "pyy")
            fields = [("id", int), ("size", int), *((name, float) for name in names)]
            return np.array(rows, fields)

        @property
        def objects(self):
            return self.objects_at(self.packages[-1]["t"][-1])

        def objects_at(self, t_us):
            fields = [("id", int), ("x", float), ("y", float)]
            return np.array([(7, 52 + 200 * t_us * 1e-6, 50)], fields)

        def to_objects(self, labels):
            return np.where(np.isin(labels, [1, 2]), 7, -1)

    tracker = Grouping(None, ids=lambda events: 1 + np.arange(events.size) % 3)
    found = score(tracker, scene)
    assert found["mota"] == 1 and found["position_rms"] == pytest.approx(2)
    assert found["nees"] == pytest.approx(1)  # of the heaviest
    noisy = FakeScene([(50, 50, 200, 0)], end_us=300_001, noise=range(500, 300_000, 3000))
    truth = by_truth(noisy)
    tracker = Grouping(None, ids=lambda events: np.where(np.equal(truth(events), 10), 2, 3))
    assert score(tracker, noisy)["v_measure"] > 0.95


# ---- filter, thinning, telling --------------------------------------------------------------


@pytest.mark.parametrize("as_mask", [False, True])
def test_labels_follow_the_events_that_pass(as_mask):
    scene = noisy(step_us=400)
    tracker = perfect(scene, ids=by_truth(scene))
    found = score(tracker, scene, before=Odd(as_mask))
    events = np.concatenate(tracker.packages)
    assert np.all(events["t"] // 1000 % 2 == 1)
    assert found["processed"] == events.size < found["events"] == scene.events.size
    assert found["v_measure"] == pytest.approx(1)


def test_behind_a_filter_active_objects_are_those_of_the_events_that_pass():
    scene = FakeScene([(50, 50, 0, 0)])
    assert score(perfect(scene), scene)["true_positives"] == 7
    assert score(perfect(scene), scene, before=Odd())["true_positives"] == 0  # 2 or 3 in 5 ms


def test_thinning_changes_neither_what_is_active_nor_what_the_filter_sees():
    scene = FakeScene([(50, 50, 0, 0)])

    class Counting(Odd):
        seen = 0

        def process(self, events):
            self.seen += events.size
            return events

    tracker, before = perfect(scene), Counting()
    found = score(tracker, scene, before=before, gamma=0.3)
    assert before.seen == scene.events.size
    assert found["true_positives"] == 7
    kept = asap.GammaFilter(seed=0).apply(scene.events, 0.3)
    assert np.concatenate(tracker.packages).tolist() == kept.tolist()
    assert found["processed"] == kept.size < 0.6 * scene.events.size
    other = perfect(scene)
    score(other, scene, gamma=0.3, seed=1)
    assert np.concatenate(other.packages).tolist() != kept.tolist()


def test_the_algorithm_is_told_unless_it_should_not_or_cannot_be():
    scene = FakeScene([(50, 50, 0, 0)])
    told, not_told, whole = perfect(scene), perfect(scene), perfect(scene)
    score(told, scene, gamma=0.25)
    score(not_told, scene, gamma=0.25, told=False)
    score(whole, scene, gamma=1)
    assert (told.gammas, not_told.gammas, whole.gammas) == ([0.25], [], [])

    class Knows(FakeTracker):
        def set_gamma(self, gamma, filter_upstream=False):
            self.gammas.append((gamma, filter_upstream))

    for before, upstream in ((None, False), (Odd(), True)):
        one = Knows(lambda t_us: [])
        score(one, scene, gamma=0.5, before=before)
        assert one.gammas == [(0.5, upstream)]


def test_alike_events_pass_in_their_order():
    events = streams.make([5, 5, 5, 7, 7, 9], [1, 1, 2, 1, 1, 3], 4, 1)
    assert passed(events[[0, 2, 3]], events).tolist() == [0, 2, 3]
    assert passed(events[[0, 1, 3, 4, 5]], events).tolist() == [0, 1, 3, 4, 5]
    assert passed(events[[4, 5]], events).tolist() == [3, 5]
    assert passed(events[:0], events).tolist() == []
    assert passed(np.array([0, 1, 0, 0, 0, 1], bool), events).tolist() == [1, 5]


def test_of_alike_events_the_one_in_order_passed():
    events = streams.make([5, 5, 5], [1, 2, 1], [4, 4, 4], 1)
    assert passed(events[[1, 2]], events).tolist() == [1, 2]


@pytest.mark.parametrize("field", ["t", "x", "y", "p"])
def test_events_that_did_not_go_in_are_refused(field):
    events = streams.make([5, 6, 7], [1, 2, 3], [4, 5, 6], 1)
    for index in range(3):
        changed = events.copy()
        changed[field][index] -= 1
        with pytest.raises(ValueError, match="were not handed to it"):
            passed(changed, events)
    for more in ([0, 0], [0, 0, 0, 0, 1]):
        with pytest.raises(ValueError, match="were not handed to it"):
            passed(events[more], events)
    with pytest.raises(ValueError, match="in another order"):
        passed(events[[1, 0]], events)
    with pytest.raises(ValueError, match="must be the events that pass, or a bool"):
        passed(np.array([1, 2]), events)


# ---- corner detectors -----------------------------------------------------------------------


class Triangle(FakeScene):
    """One object with three vertices, the first of which moves with it."""

    def vertices(self, t_us):
        x = 50 + 100 * t_us * 1e-6
        rows = [(0, x, 50.0), (0, x + 30, 50.0), (1, x + 3, 50.0)]
        return np.array(rows, [("id", "<i4"), ("x", "<f8"), ("y", "<f8")])


class Detector:
    def __init__(self, choose):
        self.process = choose


def test_a_detector_is_scored_against_the_vertices():
    scene = Triangle([(50, 50, 100, 0), (100, 200, 0, 0)], noise=[20_500])
    scene.events["x"][scene.labels < 0] = 50  # noise on a vertex is no corner
    scene.events["y"][scene.labels < 0] = 50
    first = score(Detector(lambda events: events["y"] == 50), scene)
    assert first["true_corners"] == 131
    assert first["corner_events"] == 132
    assert first["precision"] == 131 / 132 and first["recall"] == 1
    assert first["false_positive_rate"] == 1 / 132
    assert first["f_measure"] == pytest.approx(2 * 131 / (131 + 132))
    assert first["processed"] == first["events"] == 263
    late = score(Detector(lambda events: (events["y"] == 50) & (events["t"] > 65_000)), scene)
    assert late["recall"] == 65 / 131 and late["precision"] == 1
    wrong = score(Detector(lambda events: events["y"] == 200), scene)
    assert wrong["precision"] == wrong["recall"] == wrong["f_measure"] == 0


@pytest.mark.parametrize(("dx", "dy", "count"), [(3, 1, 131), (3, 2, 0), (4, 1, 0)])
def test_a_corner_is_within_3_and_a_half_px(dx, dy, count):
    scene = Triangle([(50 + dx, 50 + dy, 0, 0)])
    scene.vertices = lambda t_us: Triangle.vertices(scene, 0)[:1]
    assert score(Detector(lambda events: events["y"] > 0), scene)["true_corners"] == count


# ---- errors ---------------------------------------------------------------------------------


def test_what_cannot_be_scored_is_refused():
    scene = FakeScene([(50, 50, 0, 0)])
    for gamma in (0, 1.5, math.nan):
        with pytest.raises(ValueError, match=r"gamma = .*: must be in \(0, 1\]"):
            score(perfect(scene), scene, gamma=gamma)
    with pytest.raises(TypeError, match="a ndarray without events, labels, truth"):
        score(perfect(scene), scene.events)
    with pytest.raises(TypeError, match="neither clusters nor clusters_at"):
        score(Detector(lambda events: None), scene)
    with pytest.raises(TypeError, match=r"without vertices\(t_us\)"):
        score(asap.EFast(346, 260), scene)
    with pytest.raises(ValueError, match="must be one id or one bool for each event"):
        score(perfect(scene, ids=lambda events: [1, 2]), scene)
    scene.labels = scene.labels[1:]
    with pytest.raises(ValueError, match=r"scene.labels of shape"):
        score(perfect(scene), scene)
    scene = FakeScene([(50, 50, 0, 0)])
    scene.events["t"][3] = 0
    with pytest.raises(ValueError, match="not in time order"):
        score(perfect(scene), scene)
    scene.events = np.zeros(3, [("t", "<i8")])
    with pytest.raises(TypeError, match="not in EVENT_DTYPE"):
        score(perfect(scene), scene)


def test_a_scene_without_events_or_samples_has_no_figures():
    for end_us in (0, 50_000):
        scene = FakeScene([(50, 50, 0, 0)], end_us=end_us)
        found = score(perfect(scene, ids=by_truth(scene)), scene)
        assert math.isnan(found["mota"]) and math.isnan(found["v_measure"])
        assert found["processed"] == scene.events.size


def test_an_async_tracker_is_refused():
    class Async:
        async def process(self, events):
            return events

    with pytest.raises(TypeError, match=r"^tracker = .*asyncio\.to_thread"):
        score(Async(), scenes.A())


def test_the_errors_of_the_cluster_tracker_are_as_large_as_stated():
    for scene in (scenes.B(seed=20), scenes.C(seed=20)):
        found = score(asap.ClusterTracker(scene.width, scene.height), scene)
        assert 1 < found["nees"] < 4
