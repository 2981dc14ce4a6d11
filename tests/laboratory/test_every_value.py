"""What the laboratory is handed and hands out: refused by its field, pickled."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import asap
from asap_laboratory import STUDIES, conduct, keep_curve, profiles, scenes, score
from fake_scene import FakeScene
from unfit import (
    NO_CALLBACKS,
    NO_FLAGS,
    NO_NAMES,
    NO_PATHS,
    NO_SEQUENCES,
    NO_SHARES,
    NO_WHOLES,
    assert_refused,
)

SCENE = FakeScene([(50, 50, 0, 0)], end_us=120_001)
THIN = scenes.timing(1, 64, 48, 50.0, (4.0, 8.0), duration_s=0.02)


def study(**named: Any) -> Any:
    return conduct(STUDIES["study"], **{"out": "never", **named})


def scored(**named: Any) -> Any:
    return score(**{"tracker": asap.EFast(346, 260), "scene": SCENE, **named})


def curve(**named: Any) -> Any:
    return keep_curve(**{"algorithm": asap.EFast, "scene": SCENE, **named})


def timing(**named: Any) -> Any:
    return scenes.timing(**{"n": 1, "width": 64, "height": 48, "speed": 50.0, **named})


def low(**named: Any) -> Any:
    return profiles.Profile("low", **named)


ENTRIES: list[tuple[Callable[..., Any], str, tuple[Any, ...]]] = [
    (scored, "gamma", NO_SHARES),
    (scored, "told", NO_FLAGS),
    (scored, "before", (1, "x", len)),
    (scored, "tracker", (None, 1, "x", len)),
    (curve, "gammas", (*NO_SEQUENCES, [2])),
    (curve, "seeds", (*NO_SEQUENCES, [1.5])),
    (curve, "algorithm", (None, 1, "x")),
    (study, "out", NO_PATHS),
    (study, "form", NO_NAMES),
    (study, "workers", (*NO_WHOLES[1:], 0)),
    (study, "fresh", NO_FLAGS),
    (study, "on_progress", NO_CALLBACKS),
    (timing, "n", NO_WHOLES),
    (timing, "width", (*NO_WHOLES, 15)),
    (timing, "height", (*NO_WHOLES, 15)),
    (timing, "speed", NO_SHARES),
    (timing, "radius", (*NO_SEQUENCES, (1,), (2, 1))),
    (timing, "duration_s", NO_SHARES),
    (scenes.corners, "kind", NO_NAMES),
    *(
        (make, field, NO_SHARES)
        for make in (scenes.stop_and_go, scenes.occlusion)
        for field in ("gap_ms", "speed", "radius")
    ),
    (THIN.truth, "t_us", NO_SHARES),
    (low, "duration_s", NO_SHARES),
    (low, "seed", NO_WHOLES),
    (low, "scale", NO_SHARES),
    (low, "name", NO_NAMES[2:]),
    (profiles.RandomRate, "pieces", (None, *NO_CALLBACKS)),
    (profiles.cost, "name", NO_NAMES),
    (lambda seed: profiles.cost("slow", seed=seed), "seed", NO_WHOLES),
    (profiles.drift, "duration_s", NO_SHARES),
    (lambda profile: profiles.scenario(profile, "slow"), "profile", NO_NAMES),
    (lambda cost_model: profiles.scenario("low", cost_model), "cost_model", NO_NAMES),
]


@pytest.mark.parametrize(("call", "field", "values"), ENTRIES)
def test_a_value_that_does_not_fit_is_refused_by_its_field(
    call: Callable[..., Any],
    field: str,
    values: tuple[Any, ...],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert_refused(call, field, values)
