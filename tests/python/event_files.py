"""Writers of small event files, and the way to the test recordings outside the project."""

from __future__ import annotations

import functools
import hashlib
import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asap
from asap.events import Events

DATA = Path(
    os.environ.get("ASAP_TEST_DATA") or Path(__file__).parents[2].parent / "shared" / "data"
)


def recording(name: str) -> Path:
    """Path of a test recording; skips the test where it is absent."""
    path = DATA / name
    if not path.exists():
        pytest.skip(f"test recording {name} is absent; set ASAP_TEST_DATA to its folder")
    return path


@functools.cache
def manifest() -> dict[str, dict[str, Any]]:
    """What the manifest of the recordings says, by path; skips the test where it is absent."""
    content = json.loads(recording("manifest.json").read_text())
    entries = {entry["path"]: entry for entry in content["files"]}
    for group in content["groups"]:
        sides = {"width": group["width"], "height": group["height"]}
        entries.update({entry["path"]: sides | entry for entry in group["files"]})
    return entries


def facts(name: str) -> dict[str, Any]:
    """What a recording holds, by the manifest."""
    entry = manifest()[name]
    decoded: dict[str, Any] = entry.get("decode", entry)
    return decoded


def sha256_txyp(events: Events) -> str:
    """The hash of the manifest."""
    columns = (
        events["t"].astype("<i8"),
        events["x"].astype("<u2"),
        events["y"].astype("<u2"),
        (events["p"] > 0).astype("u1"),
    )
    return hashlib.sha256(b"".join(column.tobytes() for column in columns)).hexdigest()


def write_npy(path: Path, events: Events) -> None:
    np.save(path, events)


def write_npz(path: Path, events: Events) -> None:
    np.savez_compressed(path, **{name: events[name] for name in "txyp"})


def write_txt(path: Path, events: Events) -> None:
    rows = (
        f"{'-' * (t < 0)}{abs(t) // 10**6}.{abs(t) % 10**6:06d} {x} {y} {p}\n"
        for x, y, p, t in events.tolist()
    )
    path.write_text("".join(rows))


def write_csv(path: Path, events: Events) -> None:
    rows = (f"{t},{x},{y},{p}\n" for x, y, p, t in events.tolist())
    path.write_text("t,x,y,p\n" + "".join(rows))


WRITERS = {"npy": write_npy, "npz": write_npz, "txt": write_txt, "csv": write_csv}


def assert_equal_events(actual: Events, expected: Events) -> None:
    """Compare fields, never the padding between them."""
    assert actual.dtype == asap.EVENT_DTYPE
    for name in "txyp":
        np.testing.assert_array_equal(actual[name], expected[name], err_msg=name)
