"""Folders of a labelled recording, written by a test."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

import streams

HEADING = "t_us,id,x,y,w,h,name\n"
ZONES = "x0,x1,y0,y1,from_us,to_us\n"
SENSOR = {"width": 100, "height": 80, "camera": "still", "background": "labelled"}
T0_US = 5_000_000


def folder(path: Path, rows: str = "", *, zones: str = "", **sensor: Any) -> Path:
    """One box around (20, 20) at three times, unless other rows are given."""
    events = streams.make(T0_US + np.arange(0, 100_000, 1000), 20, 20, 1)
    np.savez(path / "events.npz", **{name: events[name] for name in "txyp"})
    rows = rows or "".join(box(ms) for ms in (10, 20, 30))
    (path / "truth.csv").write_text(rows if rows.startswith("#") else HEADING + rows)
    (path / "ignore.csv").write_text(ZONES + zones)
    (path / "sensor.json").write_text(json.dumps({**SENSOR, **sensor}))
    return path


def box(
    ms: int, x: float = 10, y: float = 15, w: float = 20, h: float = 10, id: int | str = 0
) -> str:
    return f"{T0_US + 1000 * ms},{id},{x},{y},{w},{h},thing\n"
