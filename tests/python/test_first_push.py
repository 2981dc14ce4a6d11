"""The first push of a process takes no longer than the others: it imports nothing."""

from __future__ import annotations

import sys
from types import ModuleType

import numpy as np
import pytest

import asap
from children import run_script

LAYOUTS = {
    "plain": "asap.EVENT_DTYPE",
    "of a driver": "[('t', '<u8'), ('x', '<u2'), ('y', '<u2'), ('on', '?')]",
    "others": "[('ts', '<u4'), ('x', '<i8'), ('y', '<i8'), ('polarity', '<f4')]",
}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_the_first_push_imports_nothing(layout: str) -> None:
    script = """
        events = np.zeros(1000, {})
        pipeline = asap.Pipeline()
        known = set(sys.modules)
        pipeline.push(events)
        print(sorted(set(sys.modules) - known))
        """
    assert run_script(script.format(LAYOUTS[layout])).lines == ["[]"]


def test_a_push_does_not_mind_that_another_thread_imports_numpy_ma(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "numpy.ma", ModuleType("numpy.ma"))  # only begun
    pipeline = asap.Pipeline()
    pipeline.push(np.zeros(5, asap.EVENT_DTYPE))
    pipeline.stop()
    assert pipeline.ledger.received == 5
