"""Where labelled recordings lie, and which of them can be opened."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from asap_laboratory.scenes import LabelledScene, labelled

_FILES = ("events.npz", "truth.csv", "ignore.csv", "sensor.json")
_NOWHERE = (
    "no labelled recording here: give their folders, or set ASAP_TEST_DATA to the folder whose "
    "sub-folder labelled holds them"
)


class Opened(NamedTuple):
    """Recordings, and why others were left out."""

    scenes: dict[Path, LabelledScene]
    left_out: list[str]


def opened(folders: Sequence[Path] = ()) -> Opened:
    """Open labelled recordings.

    Parameters
    ----------
    folders : sequence of path
        Each a labelled recording, or a folder of such; by default ``labelled`` in the folder that
        ASAP_TEST_DATA names, or in ``../shared/data``.

    Returns
    -------
    Opened
        A recording that is found in a folder of such and refused is left out, with the reason.

    Raises
    ------
    ValueError, OSError
        A recording that was given is refused, or there is none.
    """
    scenes: dict[Path, LabelledScene] = {}
    left_out: list[str] = []
    for folder in folders or _usual():
        inside = [] if _holds_any(folder, _FILES) else _sets_inside(folder)
        if not inside:
            scenes[folder] = labelled(folder)
        for path in inside:
            try:
                scenes[path] = labelled(path)
            except (ValueError, OSError) as error:
                left_out.append(str(error).replace(f"{folder}{os.sep}", ""))
    if not scenes:
        raise ValueError("; ".join(left_out))
    return Opened(scenes, left_out)


def at_hand() -> list[Path]:
    """Return the recordings where `opened` looks by default; none where there are none."""
    try:
        return list(opened().scenes)
    except ValueError:
        return []


def _usual() -> list[Path]:
    data = Path(os.environ.get("ASAP_TEST_DATA") or Path.cwd().parent / "shared" / "data")
    if not _sets_inside(data / "labelled"):
        raise ValueError(_NOWHERE)
    return [data / "labelled"]


def _sets_inside(folder: Path) -> list[Path]:
    if not folder.is_dir():
        return []
    return sorted(path for path in folder.iterdir() if _holds_any(path, ("truth.csv",)))


def _holds_any(folder: Path, names: Sequence[str]) -> bool:
    return any((folder / name).is_file() for name in names)
