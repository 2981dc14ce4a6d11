"""Values that fit no field of their kind, and the calls that refuse them."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

NO_NUMBERS = (
    None,
    "x",
    [],
    object(),
    1j,
    np.ones(1),
    np.ones(2),
    np.ones((2, 2)),
    np.empty(0),
    len,
)
NO_REALS = (None, "x", [], 1j, len, math.nan, -1, 10**400)
NO_SHARES = (*NO_NUMBERS, math.nan, -1, 10**5000)
NO_WHOLES = (*NO_SHARES, 1.5)
NO_PATHS = (None, [], object(), 1.5, np.ones(2))
NO_SEQUENCES = (None, "x", [], object(), 1.5, np.ones((2, 2)), np.empty(0), len)
NO_TABLES = (None, "x", object(), 1.5, np.ones(2), np.zeros((2, 2)), np.zeros(2, [("a", int)]))
NO_FLAGS = ("x", [], object(), np.ones(2), np.empty(0), len)
NO_CALLBACKS = ("x", [], object(), math.nan, 1, np.ones(2))
NO_NAMES = (None, "x", [], object(), 1.5, np.ones(2), np.empty(0), np.zeros(2, [("a", int)]))


def assert_refused(call: Callable[..., Any], field: str, values: tuple[Any, ...]) -> None:
    """Assert that each value is refused by its field, and nothing written where the test runs."""
    for value in values:
        with pytest.raises((TypeError, ValueError), match=rf"^{field} = .+: "):
            call(**{field: value})
    assert not list(Path.cwd().iterdir())
