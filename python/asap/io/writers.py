"""Writers of event files: chunk by chunk, in flat memory.

A writer takes a binary file that can seek, chunks in ``EVENT_DTYPE`` whose stamps never go back,
and the sensor's width and height in px, 0 where they are not known; it returns how many events it
wrote.
"""

from __future__ import annotations

import shutil
import zipfile
from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO, Any

import numpy as np
import numpy.typing as npt
from numpy.lib import format as npy

from asap.events import EVENT_DTYPE, Events

Writer = Callable[[IO[bytes], Iterable[Events], int, int], int]

_PIECE = 1 << 18
_HEADER = 192  # bytes: enough for any count, so that it can be written again at the end
_COLUMNS = {"t": "<i8", "x": "<u2", "y": "<u2", "p": "u1"}
_PADDING = 3  # of the 16-bit words of an event


def write_npy(file: IO[bytes], chunks: Iterable[Events], width: int, height: int) -> int:
    """Write one array of EVENT_DTYPE; its length goes into the header at the end."""
    file.write(_npy_header(EVENT_DTYPE, 0))
    count = 0
    for chunk in chunks:
        words = np.array(chunk.view(np.uint16)).reshape(-1, EVENT_DTYPE.itemsize // 2)
        words[:, _PADDING] = 0  # else whatever the memory held
        file.write(words.data)
        count += len(chunk)
    file.seek(0)
    file.write(_npy_header(EVENT_DTYPE, count))
    return count


def write_npz(file: IO[bytes], chunks: Iterable[Events], width: int, height: int) -> int:
    """Write the columns and, where it is known, the size of the sensor; compressed."""
    count = 0
    with ExitStack() as stack:  # the columns wait in files until their length is known
        folder = Path(file.name).parent
        columns = {role: stack.enter_context(TemporaryFile(dir=folder)) for role in _COLUMNS}
        for chunk in chunks:
            for role, column in columns.items():
                column.write(np.ascontiguousarray(chunk[role], _COLUMNS[role]).data)
            count += len(chunk)
        archive = stack.enter_context(zipfile.ZipFile(file, "w"))
        for role, column in columns.items():
            column.seek(0)
            with _member(archive, role) as member:
                member.write(_npy_header(np.dtype(_COLUMNS[role]), count))
                shutil.copyfileobj(column, member, _PIECE)
        for name, side in (("width", width), ("height", height)):
            if side:
                with _member(archive, name) as member:
                    npy.write_array(member, np.array(side), allow_pickle=False)
    return count


def _member(archive: zipfile.ZipFile, name: str) -> IO[bytes]:
    info = zipfile.ZipInfo(f"{name}.npy")  # of 1980, so that the same events are the same bytes
    info.compress_type = zipfile.ZIP_DEFLATED
    return archive.open(info, "w", force_zip64=True)


def write_archive(
    path: Path, members: Mapping[str, bytes | npt.NDArray[Any]], *, stored: Iterable[str] = ()
) -> None:
    """Write bytes and arrays as the members of an ``.npz``, packed unless they are in `stored`."""
    with path.open("wb") as file, zipfile.ZipFile(file, "w") as archive:
        for name, content in members.items():
            if isinstance(content, np.ndarray):
                content = _npy_header(content.dtype, len(content)) + content.tobytes()
            packed = zipfile.ZIP_STORED if name in stored else zipfile.ZIP_DEFLATED
            archive.writestr(zipfile.ZipInfo(name), content, packed, compresslevel=1)


def _npy_header(dtype: np.dtype[Any], count: int) -> bytes:
    """Return the header of an array of shape (count,), always of the same size."""
    fields = {"descr": npy.dtype_to_descr(dtype), "fortran_order": False, "shape": (count,)}
    front = npy.magic(1, 0) + (_HEADER - npy.MAGIC_LEN - 2).to_bytes(2, "little")
    return front + repr(fields).encode().ljust(_HEADER - len(front) - 1) + b"\n"
