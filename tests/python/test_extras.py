"""What needs a library says in which extra it comes."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import asap
import streams
from aedat4_files import write_aedat4
from asap import viewer
from asap.viewer import monitor

# Modules that import their library when they are loaded.
LOADED = ("asap.io.hdf5", "asap.io.matlab", "asap.viewer.animation")


def load(content: bytes) -> Callable[[Path], object]:
    def call(folder: Path) -> object:
        (folder / "events").write_bytes(content)
        return asap.load(folder / "events")

    return call


def load_packets(compression: int) -> Callable[[Path], object]:
    def call(folder: Path) -> object:
        write_aedat4(folder / "events", [], compression=compression)
        return asap.load(folder / "events")

    return call


def load_folder(folder: Path) -> object:
    (folder / "metadata.yaml").touch()
    return asap.load(folder)


@pytest.mark.parametrize(
    ("library", "extra", "call"),
    [
        ("h5py", "hdf5", load(b"\x89HDF\r\n\x1a\n")),
        ("scipy.io", "matlab", load(b"MATLAB 5.0")),
        ("lz4.frame", "aedat4", load_packets(1)),
        ("zstandard", "aedat4", load_packets(3)),
        ("rosbags.rosbag1", "ros", load(b"#ROSBAG V2.0\n")),
        ("rosbags.rosbag2", "ros", load_folder),
        ("mcap.reader", "ros", load(b"\x89MCAP0\r\n")),
        ("neuromorphic_drivers", "camera", lambda _: asap.cameras()),
        ("neuromorphic_drivers", "camera", lambda _: asap.open_camera()),
        ("rich", "monitor", lambda _: monitor.need_terminal()),
        ("rerun", "view", lambda folder: viewer.View(folder / "run.rrd")),
        ("pebble", "map", lambda _: asap.map(len, [streams.make([1, 2])])),
        ("PIL", "report", lambda _: importlib.import_module("asap.viewer.animation")),
    ],
)
def test_a_missing_library_is_named_with_its_extra(
    library: str,
    extra: str,
    call: Callable[[Path], object],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name in LOADED:
        monkeypatch.delitem(sys.modules, name, raising=False)
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises((RuntimeError, ImportError), match=rf"asap-events\[{extra}\]"):
        call(tmp_path)
