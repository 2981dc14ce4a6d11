"""The laboratory's metrics on slots made by hand."""

import numpy as np
import pytest

import asap
from asap_laboratory import metrics


def slots(*rows):
    """Rows of slot, received, delivered and, if wanted, the largest latency in us."""
    made = np.zeros(len(rows), asap._core.SLOT_DTYPE)
    for row, values in zip(made, rows, strict=True):
        row["slot"], row["received"], row["delivered"] = values[:3]
        row["latency_max_us"] = values[3] if len(values) == 4 else 0.0
    return made


def silent(numbers, *, until):
    """Slots 0..until with ten events each; none is delivered in those of `numbers`."""
    return slots(*((number, 10, 0 if number in numbers else 10) for number in range(until + 1)))


@pytest.mark.parametrize(
    ("numbers", "gap"),
    [
        ([], 0),
        ([7], 1),
        ([3, 4, 5, 9, 10], 3),
        ([3, 4, 6, 7, 8, 9], 4),
        ([0, 1], 2),
        ([38, 39, 40, 41, 42], 3),  # only up to 100 - 60
        (range(41, 101), 0),
    ],
)
def test_gap_is_the_longest_run_without_a_result(numbers, gap):
    assert metrics.gap_ms(silent(numbers, until=100)) == gap


def test_a_slot_without_events_ends_a_gap():
    made = slots((1, 5, 0), (2, 5, 0), (4, 5, 0), (5, 5, 5))
    assert metrics.gap_ms(made, ignore_last=0) == 2


def test_the_last_of_the_time_is_ignored_not_of_the_slots():
    # Slot 990 is 10 ms before the last one: only that time is ignored, not the rows in it.
    made = slots((0, 5, 5), (988, 5, 0), (989, 5, 0), (990, 5, 0), (1000, 5, 5))
    assert metrics.gap_ms(made, ignore_last=10) == 3
    assert metrics.gap_ms(made, ignore_last=11) == 2
    assert metrics.gap_ms(made, ignore_last=60) == 0


def test_gap_of_nothing_is_0():
    assert metrics.gap_ms(slots()) == 0


LATE, GOOD = 1101.0, 1100.0  # us: above 1.1 L, and just not, at L = 1 ms


def phase(disturbed, latency_us=LATE, delivered=10):
    """2 s of slots; those of `disturbed` are late, or lack results."""
    return slots(
        *(
            (number, 10, delivered, latency_us) if number in disturbed else (number, 10, 10, 200.0)
            for number in range(2000)
        )
    )


@pytest.mark.parametrize("name", ["settle_ms", "recovery_ms"])
def test_a_disturbance_lasts_to_the_end_of_its_last_slot(name):
    time_ms = getattr(metrics, name)
    assert time_ms(phase([]), [500], 500, 1000) == 0
    assert time_ms(phase([500]), [500], 500, 1000) == 1
    assert time_ms(phase([499, 500, 507]), [500], 500, 1000) == 8
    assert time_ms(phase([499, 1000]), [500], 500, 1000) == 0  # before and after the phase
    assert time_ms(phase([0, 1, 2]), [1500], 500, 1000) == 0
    assert time_ms(phase([1999]), [0], 2000, 1000) == 1996  # never
    assert time_ms(phase([990, 999]), [500], 500, 1000) == 496  # never
    assert time_ms(phase([503], latency_us=GOOD), [500], 500, 1000) == 0


def test_the_mean_is_over_all_steps():
    assert metrics.settle_ms(phase([503, 1509]), [500, 1500], 500, 1000) == (4 + 10) / 2
    assert metrics.settle_ms(phase([503, 1509]), [], 500, 1000) == 0


def test_to_settle_takes_what_is_in_time_and_to_recover_takes_nearly_all():
    nothing = phase([504], latency_us=0.0, delivered=0)
    some = phase([504], latency_us=0.0, delivered=9)
    assert metrics.settle_ms(nothing, [500], 500, 1000) == 0  # a gap has a measure of its own
    assert metrics.settle_ms(some, [500], 500, 1000) == 0
    assert metrics.recovery_ms(some, [500], 500, 1000) == 5
    enough = slots((500, 100, 98, 0.0), (501, 100, 98, 0.0))
    assert metrics.recovery_ms(enough, [500], 500, 1000) == 0
    few = slots((500, 1000, 980, 0.0), (501, 1000, 979, 0.0))
    assert metrics.recovery_ms(few, [500], 500, 1000) == 2


def test_load_relates_processing_to_the_interval():
    packages = np.zeros(4, asap._core.PACKAGE_DTYPE)
    packages["start_us"] = [0, 100, 300, 350]
    packages["processing_us"] = [1e9, 50, 400, 50]  # the first has no interval
    found = metrics.load(packages)
    assert found == ((0.5 + 2.0 + 1.0) / 3, pytest.approx(2 / 3))
    assert found.mean == found[0] and found.within == found[1]
    assert metrics.load(packages[:1]) == (0.0, 1.0)
    packages["start_us"][:2], packages["processing_us"][:2] = (0, 0.5), (0, 0.25)
    assert metrics.load(packages[:2]) == (0.5, 1.0)  # intervals may be below 1 us
