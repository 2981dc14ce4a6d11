"""repr of what the laboratory makes: how to make it anew, or what was found."""

from __future__ import annotations

import re
from pathlib import Path

import asap
from asap_laboratory import keep_curve, profiles, scenes
from labelled_folders import folder


def test_a_profile_says_how_to_make_it_anew() -> None:
    made = profiles.Profile("quiet", duration_s=0.1)
    assert eval(repr(made), vars(profiles)).parameters == made.parameters


def test_what_was_found_stands_in_angle_brackets(tmp_path: Path) -> None:
    for one in (
        keep_curve(asap.EFast, scenes.corners(duration_s=0.2), gammas=[1], seeds=[0]),
        scenes.A(),
        scenes.A().thin(0.5),
        scenes.labelled(folder(tmp_path)),
    ):
        assert re.fullmatch(rf"<{type(one).__name__}: [^\n]+>", repr(one)), repr(one)
