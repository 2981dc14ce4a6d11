"""The fixtures of both doors."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from door import this_door

door = this_door()
make_peer = pytest.fixture(door.peers)


@pytest.fixture(scope="session", autouse=True)
def master() -> Iterator[Any]:
    yield from door.master()


@pytest.fixture
def peer(make_peer: Callable[..., Any]) -> Any:
    return make_peer()
