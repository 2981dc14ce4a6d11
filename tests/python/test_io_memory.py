"""Reading takes flat memory, however long the file is."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from aedat4_files import write_aedat4
from asap.events import Events
from children import run_script
from corrupt import clean_events

COUNT = 6_000_000
MAX_MEMORY_KB = 32 << 10
TYPES = {"t": "i8", "x": "u2", "y": "u2", "p": "u1"}


def npy(path: Path, events: Events) -> None:
    packed = np.empty(len(events), list(TYPES.items()))
    for name in TYPES:
        packed[name] = events[name]
    np.save(path, packed)


def npz(path: Path, events: Events) -> None:
    np.savez(path, **{name: events[name].astype(dtype) for name, dtype in TYPES.items()})


def hdf5(path: Path, events: Events, **options: object) -> None:
    with pytest.importorskip("h5py").File(path, "w") as file:
        for name, dtype in TYPES.items():
            file.create_dataset(f"events/{name}", data=events[name].astype(dtype), **options)


def hdf5_in_chunks(path: Path, events: Events) -> None:
    hdf5(path, events, chunks=(50_000,))


def aedat4(path: Path, events: Events) -> None:
    write_aedat4(path, ((0, events[at : at + 10_000]) for at in range(0, len(events), 10_000)))


@pytest.mark.skipif(sys.platform != "linux", reason="ru_maxrss counts kilobytes on Linux")
@pytest.mark.parametrize("write", [npy, npz, hdf5, hdf5_in_chunks, aedat4])
def test_resident_memory_is_flat(tmp_path: Path, write: Callable[[Path, Events], None]) -> None:
    path = tmp_path / f"a.{write.__name__.partition('_')[0]}"
    write(path, clean_events(COUNT))
    assert path.stat().st_size > 2 * 1024 * MAX_MEMORY_KB
    child = run_script(f"""
        import resource
        def resident_kb():
            return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        chunks = iter(asap.read({str(path)!r}))
        count = len(next(chunks))
        before = resident_kb()
        for chunk in chunks:
            count += len(chunk)
        print(count, resident_kb() - before)
    """)
    count, grown_kb = map(int, child.lines[-1].split())
    assert count == COUNT
    assert grown_kb < MAX_MEMORY_KB
