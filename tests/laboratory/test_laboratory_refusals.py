"""The laboratory refuses a value that does not fit by its field, before anything is done."""

from __future__ import annotations

import decimal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
from asap_laboratory import (
    accuracy_study,
    keep_curve,
    ladder_study,
    metrics,
    profiles,
    rivals_study,
    scenes,
    score,
    study,
)
from fake_scene import FakeScene
from unfit import (
    NO_CALLBACKS,
    NO_FLAGS,
    NO_NAMES,
    NO_PATHS,
    NO_SEQUENCES,
    NO_SHARES,
    NO_TABLES,
    NO_WHOLES,
    assert_refused,
)

RUN = asap.simulate(np.zeros(5, asap.EVENT_DTYPE), cost=asap.LinearCost(1, 1))
SCENE = FakeScene([(50, 50, 0, 0)], end_us=120_001)
THIN = scenes.timing(1, 64, 48, 50.0, (4.0, 8.0), duration_s=0.02)


class NeverCalled:
    def submit(self, *_: object) -> None:
        raise AssertionError("the study has begun")


def studies(field: str, values: tuple[Any, ...]) -> list[tuple[Any, ...]]:
    def call(made: Callable[..., Any]) -> Callable[..., Any]:
        return lambda **named: made(**{"out": "never", "executor": NeverCalled(), **named})

    made = (study, accuracy_study, ladder_study, rivals_study)
    return [(call(one), field, values) for one in made]


DOORS: list[tuple[Callable[..., Any], str, tuple[Any, ...]]] = [
    (lambda **named: score(asap.EFast(346, 260), SCENE, **named), "gamma", NO_SHARES),
    (lambda **named: score(asap.EFast(346, 260), SCENE, **named), "told", NO_FLAGS),
    (lambda **named: score(asap.EFast(346, 260), SCENE, **named), "active", NO_NAMES),
    (lambda **named: score(asap.EFast(346, 260), SCENE, **named), "before", (1, "x", len)),
    (lambda **named: score(scene=SCENE, **named), "tracker", (None, 1, "x", len)),
    (lambda **named: keep_curve(asap.EFast, SCENE, **named), "gammas", (*NO_SEQUENCES, [2])),
    (lambda **named: keep_curve(asap.EFast, SCENE, **named), "seeds", (*NO_SEQUENCES, [1.5])),
    (lambda **named: keep_curve(scene=SCENE, **named), "algorithm", (None, 1, "x")),
    *studies("out", NO_PATHS),
    *studies("form", NO_NAMES),
    *studies("executor", ("x", [], object(), 1.5, np.ones(2))),
    *studies("workers", (*NO_WHOLES[1:], 0)),
    *studies("fresh", NO_FLAGS),
    *studies("figures", NO_FLAGS),
    *studies("on_progress", NO_CALLBACKS),
    (lambda n: scenes.timing(n, 64, 48, 50.0), "n", NO_WHOLES),
    (lambda width: scenes.timing(1, width, 48, 50.0), "width", (*NO_WHOLES, 15)),
    (lambda height: scenes.timing(1, 64, height, 50.0), "height", (*NO_WHOLES, 15)),
    (lambda speed: scenes.timing(1, 64, 48, speed), "speed", NO_SHARES),
    (
        lambda radius: scenes.timing(1, 64, 48, 50.0, radius),
        "radius",
        (*NO_SEQUENCES, (1,), (2, 1)),
    ),
    (lambda **named: scenes.timing(1, 64, 48, 50.0, **named), "duration_s", NO_SHARES),
    (scenes.corners, "kind", NO_NAMES),
    (scenes.corners, "duration_s", NO_SHARES),
    (scenes.stop_and_go, "gap_ms", NO_SHARES),
    (scenes.stop_and_go, "speed", NO_SHARES),
    (scenes.stop_and_go, "radius", NO_SHARES),
    (scenes.occlusion, "gap_ms", NO_SHARES),
    (scenes.occlusion, "speed", NO_SHARES),
    (scenes.occlusion, "radius", NO_SHARES),
    (THIN.truth, "t_us", NO_SHARES),
    (THIN.vertices, "t_us", NO_SHARES),
    (THIN.thin, "gamma", NO_SHARES),
    (lambda **named: profiles.Profile("low", **named), "duration_s", NO_SHARES),
    (lambda **named: profiles.Profile("low", **named), "seed", NO_WHOLES),
    (lambda **named: profiles.Profile("low", **named), "scale", NO_SHARES),
    (lambda **named: profiles.Profile("low", **named), "name", NO_NAMES[2:]),
    (profiles.RandomRate, "pieces", (None, *NO_CALLBACKS)),
    (profiles.cost, "name", NO_NAMES),
    (lambda seed: profiles.cost("slow", seed=seed), "seed", NO_WHOLES),
    (profiles.drift, "duration_s", NO_SHARES),
    (lambda seed: profiles.outages_ms(0.1, seed=seed), "seed", NO_WHOLES),
    (lambda profile: profiles.scenario(profile, "slow"), "profile", NO_NAMES),
    (lambda cost_model: profiles.scenario("low", cost_model), "cost_model", NO_NAMES),
    (metrics.gap_ms, "slots", (*NO_TABLES, RUN.slots.reshape(1, -1))),
    (lambda ignore_last: metrics.gap_ms(RUN.slots, ignore_last), "ignore_last", NO_WHOLES),
    (lambda slots: metrics.settle_ms(slots, [1], 9, 1), "slots", NO_TABLES),
    (lambda slots: metrics.recovery_ms(slots, [1], 9, 1), "slots", NO_TABLES),
    (
        lambda steps_ms: metrics.settle_ms(RUN.slots, steps_ms, 9, 1),
        "steps_ms",
        ([1.5], *NO_TABLES[:4]),
    ),
    (lambda phase_ms: metrics.recovery_ms(RUN.slots, [1], phase_ms, 1), "phase_ms", NO_WHOLES),
    (lambda bound_us: metrics.settle_ms(RUN.slots, [1], 9, bound_us), "bound_us", NO_SHARES),
    (metrics.load, "packages", NO_TABLES),
]


@pytest.mark.parametrize(("call", "field", "values"), DOORS)
def test_argument_of_any_kind_is_named(
    call: Callable[..., Any],
    field: str,
    values: tuple[Any, ...],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert_refused(call, field, values)


HALF = decimal.Decimal("0.5")


@pytest.mark.parametrize(
    ("call", "plain"),
    [
        (lambda half: profiles.drift(half).size, 500),
        (lambda half: profiles.cost("slow_ht", duration_s=half).name, "linear_cost"),
        (lambda half: profiles.Profile("low", duration_s=half, scale=half).duration_s, 0.5),
        (lambda half: scenes.timing(1, 64, 48, half, duration_s=half).duration_us, 500_000),
        (lambda half: score(asap.EFast(64, 48), THIN, gamma=half)["events"], None),
        (lambda half: keep_curve(asap.EFast, THIN, gammas=[half]).rows[0].gamma, 0.5),
        (lambda half: metrics.settle_ms(RUN.slots, [], 9, half), 0),
    ],
)
def test_number_of_any_kind_is_taken_as_a_float(call: Callable[[Any], Any], plain: Any) -> None:
    found = call(HALF)
    assert found == call(0.5)
    assert plain in (found, None)
    for bad in ("nan", "snan"):
        with pytest.raises((TypeError, ValueError), match=r"^\w+ = .*: "):
            call(decimal.Decimal(bad))


def test_masked_packages_are_refused() -> None:
    with pytest.raises(ValueError, match=r"^packages = masked array: .{10,}"):
        metrics.load(np.ma.masked_array(RUN.packages, True))
