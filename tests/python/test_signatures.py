"""inspect.signature of every public class: the names and defaults of its constructor."""

from __future__ import annotations

import inspect

import pytest

import asap

PUBLIC = [name for name in asap.__all__ if isinstance(getattr(asap, name), type)]
CLASSES = [name for name in PUBLIC if not issubclass(getattr(asap, name), Exception)]


@pytest.mark.parametrize("name", CLASSES)
def test_every_public_class_has_one(name: str) -> None:
    arguments = inspect.signature(getattr(asap, name)).parameters
    unnamed = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)
    assert name == "Scheme" or not [one for one in arguments.values() if one.kind in unnamed]
