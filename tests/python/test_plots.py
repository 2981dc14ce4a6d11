import subprocess
import sys

import numpy as np
import pytest

from fake_run import fake_run

matplotlib = pytest.importorskip("matplotlib")

from matplotlib.figure import Figure  # noqa: E402

from asap import plots  # noqa: E402

EVENT_DTYPE = np.dtype([("x", "<u2"), ("y", "<u2"), ("p", "<i2"), ("t", "<i8")], align=True)
CLUSTER_DTYPE = np.dtype(
    [("id", "<i8"), *((name, "<f8") for name in ("x", "y", "vx", "vy", "cxx", "cxy", "cyy"))]
)


def events_of(*rows):
    return np.array(list(rows), EVENT_DTYPE)


def curve(axes, i=0):
    return axes.get_lines()[i].get_data()


def test_the_figure_has_the_papers_curves_on_one_time_axis():
    run = fake_run()
    figure = plots.figure(run)
    assert [axes.get_title(loc="left") for axes in figure.axes] == [
        "package size",
        "rates per 20 ms",
        "events",
        "gamma",
        "margin",
        "latency",
    ]
    first, *others = figure.axes
    assert all(first.get_shared_x_axes().joined(first, other) for other in others)
    size, rates, went, gamma, margin, latency = figure.axes
    for axes, column, scale in (
        (size, "size", 1),
        (gamma, "gamma", 1),
        (margin, "margin_us", 1e-3),
        (latency, "latency_max_us", 1e-3),
    ):
        time_s, values = curve(axes)
        assert values.max() == pytest.approx(run.packages[column].max() * scale)
        assert values.min() == pytest.approx(run.packages[column].min() * scale)
        assert time_s[0] == pytest.approx(0.0005) and time_s[-1] <= 5
        assert len(values) <= 2000 < run.packages.size
    assert size.get_yscale() == "log"
    raw = rates.patches[0].get_data().values
    assert raw.max() == pytest.approx(14, rel=0.05) and raw.min() == pytest.approx(0.1, rel=0.2)
    assert rates.patches[1].get_data().values.max() == pytest.approx(5, rel=0.05)
    assert set(curve(rates)[1]) == {5.0}
    assert [patch.get_label() for patch in went.patches] == ["processed", "thinned"]
    processed, thinned = (patch.get_data() for patch in went.patches)
    assert processed.values[-1] == pytest.approx(5 / 14, rel=0.05)
    assert thinned.values == pytest.approx(np.ones(thinned.values.size))
    assert set(curve(margin, 1)[1]) == {0}
    assert set(curve(latency, 1)[1]) == {10.0}


def test_a_bound_far_above_the_rates_does_not_flatten_them():
    rates = plots.figure(fake_run(rates=(1e4, 1e4))).axes[1]
    assert rates.get_ylim()[1] < 20  # kev/s
    assert rates.get_lines()[0].get_label() == "bound, a = 5 Mev/s, off scale"


def test_the_global_style_stays_as_it_is():
    plots.figure(fake_run(duration_s=0.1))
    plots.rate(events_of((0, 0, 1, 0)))
    changed = {
        name
        for name, value in matplotlib.rcParamsOrig.items()
        if matplotlib.rcParams[name] != value
    }
    assert changed <= {"backend"}


def test_pyplot_is_never_imported():
    code = "import sys, asap.results.page; sys.exit('matplotlib.pyplot' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_phone_of_390_px_can_read_every_letter():
    events = events_of((1, 1, 1, 10), (2, 2, 0, 20_000))
    cluster = np.zeros(1, CLUSTER_DTYPE)
    cluster[["cxx", "cyy"]] = 4.0
    for figure in (
        plots.figure(fake_run()),
        plots.rate(events).figure,
        plots.clusters(events, cluster, 16, 16).figure,
    ):
        letters = [text for text in figure.findobj(matplotlib.text.Text) if text.get_text()]
        smallest_pt = min(text.get_fontsize() for text in letters)
        assert smallest_pt / (72 * figure.get_figwidth()) * 390 >= 9


def test_a_frame_shows_on_red_and_off_blue_with_y_down():
    axes = plots.frame(
        events_of((1, 0, 1, 0), (2, 1, 0, 1), (0, 1, 0, 2), (0, 1, 1, 3), (9, 9, 1, 4)), 3, 2
    )
    image = axes.get_images()[0].get_array()
    assert image.shape == (2, 3, 3)
    assert axes.yaxis_inverted()
    red, blue = image[0, 1], image[1, 2]
    assert red[0] > 2 * red[2] and blue[2] > 2 * blue[0]
    assert (image[1, 0] == red).all()  # a tie: the last event's
    assert (image[0, 0] == 255).all()


def test_clusters_are_ellipses_of_two_standard_deviations():
    cluster = np.array([(7, 30, 20, 100, 0, 9.0, 0.0, 4.0)], CLUSTER_DTYPE)
    axes = plots.clusters(events_of((1, 1, 1, 0)), cluster, 60, 40, lookahead_ms=20)
    (ellipse,) = axes.patches
    assert ellipse.center == (30, 20)
    assert (ellipse.width, ellipse.height) == pytest.approx((12, 8))
    assert abs(ellipse.angle) % 180 == pytest.approx(0)
    assert axes.texts[0].get_text() == "7"
    assert curve(axes)[0].tolist() == [30, 32]


def test_objects_are_their_boxes():
    fields = ("id", "x", "y", "vx", "vy", "left", "top", "width", "height")
    things = np.array([(7, 30, 20, 100, 0, 25, 12, 9, 14)], [(name, float) for name in fields])
    (box,) = plots.clusters(events_of((1, 1, 1, 0)), things, 60, 40).patches
    assert (box.get_xy(), box.get_width(), box.get_height()) == ((25, 12), 9, 14)


@pytest.mark.parametrize("draw", ["frame", "clusters", "rate"])
def test_axes_that_are_given_are_used_and_returned(draw):
    axes = Figure().add_subplot()
    events = events_of((1, 1, 1, 0))
    calls = {
        "frame": lambda: plots.frame(events, 4, 4, ax=axes),
        "clusters": lambda: plots.clusters(events, np.empty(0, CLUSTER_DTYPE), 4, 4, ax=axes),
        "rate": lambda: plots.rate(events, 1000, ax=axes),
    }
    assert calls[draw]() is axes
