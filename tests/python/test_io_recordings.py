"""Real recordings: decoded columns equal the hashes of the manifest."""

from __future__ import annotations

import numpy as np
import pytest

import asap
from event_files import DATA, facts, recording, sha256_txyp

SERVED = [
    ("text/slider_davis240.txt", "text", None),
    ("text/night_davis346.csv", "csv", None),
    ("derived/office.npy", "npy", None),
    ("derived/office.npz", "npz", None),
    ("derived/office.txt", "text", None),
    ("evt/laser_evt2.raw", "evt2", (640, 480)),
    ("evt/drive_hd_evt3.raw", "evt3", (1280, 720)),
    ("derived/office.evt2.raw", "evt2", (346, 260)),
    ("derived/office.evt21.raw", "evt21", (346, 260)),
    ("derived/office.evt21_legacy.raw", "evt21", (346, 260)),
    ("derived/office.evt3.raw", "evt3", (346, 260)),
    ("derived/office.dat", "dat", (346, 260)),
    ("atis/car_ncars.dat", "dat", None),
    ("aedat/office_davis346.aedat4", "aedat4", (346, 260)),
    ("aedat/cars_davis346.aedat4", "aedat4", (346, 260)),
    ("derived/office.dsec.h5", "hdf5", None),
    ("derived/office.psee.h5", "hdf5", (346, 260)),
    ("mat/boat_davis346.mat", "matlab", None),
    ("mat/stripes_dvs128.mat", "matlab", None),
    ("mat/building_dvs128.mat", "matlab", None),
    ("mat/desk_davis240.mat", "matlab", None),
    ("ros/room_person_evt3.bag", "rosbag1", (640, 480)),
    ("ros/room_person_evt3.db3", "rosbag2", (640, 480)),
    ("ros/noise_hd_evt3.db3", "rosbag2", (1280, 720)),
    ("ros/mono_100.db3", "rosbag2", (640, 480)),
]
ORDERS = dict.fromkeys(("mat/stripes_dvs128.mat", "mat/building_dvs128.mat"), "xypt")
LIBRARIES = {"aedat4": "lz4", "hdf5": "h5py", "matlab": "scipy", "rosbag1": "rosbags"}


@pytest.mark.parametrize(("name", "fmt", "sensor"), SERVED, ids=[row[0] for row in SERVED])
def test_equal_to_the_manifest(name: str, fmt: str, sensor: tuple[int, int] | None) -> None:
    if fmt in LIBRARIES:
        pytest.importorskip(LIBRARIES[fmt])
    known, order = facts(name), ORDERS.get(name)
    rec = asap.read(recording(name), order=order)
    chunks = list(rec)
    events = np.concatenate(chunks)
    assert rec.format == fmt
    assert (rec.width, rec.height) == (sensor or (None, None))
    assert len(events) == known["events"]
    assert sha256_txyp(events) == known["sha256_txyp"]
    assert set(rec.rejected.values()) == {0}
    assert sha256_txyp(asap.load(recording(name), order=order)) == known["sha256_txyp"]


def test_hands_with_their_order() -> None:
    files = sorted((DATA / "text/hands").glob("*.csv"))
    if not files:
        recording("text/hands")
    for path in files:
        known = facts(f"text/hands/{path.name}")
        events = asap.load(path, order="yxt", width=1280, height=800)
        assert sha256_txyp(events) == known["sha256_txyp"], path.name


def test_hands_without_order_is_a_question() -> None:
    with pytest.raises(ValueError, match=r"order = None: the lines of .* have 3 columns"):
        asap.read(recording("text/hands/30201.csv"))
