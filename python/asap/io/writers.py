"""Writers of event files: chunk by chunk, in flat memory.

A writer takes a binary file that can seek, chunks in ``EVENT_DTYPE`` whose stamps never go back,
and the sensor's width and height in px, 0 where they are not known; it returns how many events it
wrote. Packets, as a driver sends them, end where a period of the events' time ends.
"""

from __future__ import annotations

import errno
import io
import os
import shutil
import struct
import zipfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO, Any

import numpy as np
import numpy.typing as npt
from numpy.lib import format as npy

from asap import _core
from asap._checks import named
from asap.events import EVENT_DTYPE, Events
from asap.io.aedat4 import EVENT, MAGIC, MAX_PIXELS
from asap.io.errors import library
from asap.io.reader import CHUNK

Writer = Callable[..., int]

_PIECE = 1 << 18
_NPY_HEADER = 192  # bytes: enough for any count, so that it can be written again at the end
_COLUMNS = {"t": "<i8", "x": "<u2", "y": "<u2", "p": "u1"}
_PADDING = 3  # the 16-bit word of an event that holds nothing
_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


@contextmanager
def replacing(path: Path) -> Iterator[IO[bytes]]:
    """Write beside the path, and take its place only when all is written; a device as it is."""
    target = path.resolve()
    if target.exists() and not target.is_file():
        with target.open("wb") as file:
            yield file
        return
    part = target.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with part.open("w+b") as file:
            yield file
        part.replace(target)
    except OSError as error:
        is_nameless = error.filename is None and error.errno in _FULL
        if not is_nameless and error.filename != str(part):
            raise
        raise OSError(error.errno, error.strerror, str(path)) from error
    finally:
        part.unlink(missing_ok=True)


class Growing(io.FileIO):
    """A new file without a buffer: what was written is there, and a failed write is over."""

    def __init__(self, path: Path) -> None:
        super().__init__(path, "x+")

    def write(self, data: Any) -> int:
        """Write all, in as many steps as the system makes of it."""
        rest = memoryview(data).cast("B")
        size = len(rest)
        while rest:
            rest = rest[super().write(rest) :]
        return size


def write_npy(file: IO[bytes], chunks: Iterable[Events], width: int, height: int) -> int:
    """Write one array of EVENT_DTYPE; the header has its length after each chunk."""
    file.write(_npy_header(EVENT_DTYPE, 0))
    count = 0
    for chunk in chunks:
        words = np.array(chunk.view(np.uint16)).reshape(-1, EVENT_DTYPE.itemsize // 2)
        words[:, _PADDING] = 0  # else whatever the memory held
        file.write(words.data)
        count += len(chunk)
        file.seek(0)
        file.write(_npy_header(EVENT_DTYPE, count))
        file.seek(0, os.SEEK_END)
    return count


def write_npz(file: IO[bytes], chunks: Iterable[Events], width: int, height: int) -> int:
    """Write the columns, their unit and, where it is known, the sensor's size; compressed."""
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
        for name, value in (("time_unit", "us"), ("width", width), ("height", height)):
            if value:
                with _member(archive, name) as member:
                    npy.write_array(member, np.array(value), allow_pickle=False)
    return count


def _member(archive: zipfile.ZipFile, name: str) -> IO[bytes]:
    info = zipfile.ZipInfo(f"{name}.npy")  # dated 1980: the same events give the same bytes
    info.compress_type = zipfile.ZIP_DEFLATED
    return archive.open(info, "w", force_zip64=True)


def _npy_header(dtype: np.dtype[Any], count: int) -> bytes:
    """Return the header of an array of shape (count,), always of the same size."""
    fields = {"descr": npy.dtype_to_descr(dtype), "fortran_order": False, "shape": (count,)}
    front = npy.magic(1, 0) + (_NPY_HEADER - npy.MAGIC_LEN - 2).to_bytes(2, "little")
    return front + repr(fields).encode().ljust(_NPY_HEADER - len(front) - 1) + b"\n"


class Encoded:
    """The bytes of a stream of events: a header, then one call of `pieces` after the other."""

    def __init__(self, encoding: str, width: int, height: int) -> None:
        self._encoder = _core.Encoder(encoding, width=width, height=height)
        self._buffer = memoryview(bytearray(_PIECE))
        self.header = self._encoder.header()

    def pieces(self, events: Events) -> Iterator[memoryview]:
        """Encode the next events; a piece is good until the next one."""
        while len(events):
            taken, written = self._encoder.encode_into(events, self._buffer)
            yield self._buffer[:written]
            events = events[taken:]


def write_encoded(
    encoding: str, file: IO[bytes], chunks: Iterable[Events], width: int, height: int
) -> int:
    """Write a file that is one stream of words, records or lines."""
    encoded = Encoded(encoding, width, height)
    file.write(encoded.header)
    count = 0
    for chunk in chunks:
        count += len(chunk)
        file.writelines(encoded.pieces(chunk))
    return count


_EXT_TRIGGER = 0xA000
_MAX_ID = 15


def write_evt3(
    file: IO[bytes],
    chunks: Iterable[Events],
    width: int,
    height: int,
    triggers: Callable[[], npt.NDArray[np.void]] = lambda: np.empty(0, _core.TRIGGER_DTYPE),
) -> int:
    """Write EVT3 with its triggers, each before the first event that is not older.

    `triggers` returns those of the source that have been read; none unless given.
    """
    encoded = Encoded("evt3", width, height)
    file.write(encoded.header)
    count = written = 0
    last_us = np.iinfo(np.int64).min

    def edge(trigger: np.void) -> bytes:
        """Encode an event of its time, whose last word becomes the trigger."""
        event = np.zeros(1, EVENT_DTYPE)
        event["t"] = max(int(trigger["t"]), last_us)
        number = int(trigger["id"])
        if number > _MAX_ID:
            raise ValueError(named("id", number, f"EVT3 holds triggers of inputs 0 to {_MAX_ID}"))
        word = _EXT_TRIGGER | number << 8 | int(trigger["value"])
        return b"".join(map(bytes, encoded.pieces(event)))[:-2] + struct.pack("<H", word)

    for chunk in chunks:
        seen = triggers()[written:]
        due = seen[np.maximum.accumulate(seen["t"]) <= chunk["t"][-1]]
        first, *parts = np.split(chunk, np.searchsorted(chunk["t"], due["t"]))
        file.writelines(encoded.pieces(first))
        for part, trigger in zip(parts, due, strict=True):
            file.write(edge(trigger))
            last_us = max(last_us, int(trigger["t"]))
            file.writelines(encoded.pieces(part))
        count, written, last_us = count + len(chunk), written + len(due), int(chunk["t"][-1])
    file.writelines(map(edge, np.sort(triggers()[written:], order="t")))
    return count


_AEDAT4_PERIOD_US = 10_000  # packets of the cameras of iniVation
_ROS_PERIOD_US = 1_000  # messages of the drivers for ROS


def _packets(chunks: Iterable[Events], period_us: int) -> Iterator[Events]:
    for chunk in chunks:
        yield from np.split(chunk, np.flatnonzero(np.diff(chunk["t"] // period_us)) + 1)


# ---- AEDAT 4 ------------------------------------------------------------------------------------
# FileSourceFormat of dv-processing: packets in lz4, without the optional table at the end.

_LZ4 = 1
_OUT_INFO = """<dv version="2.0"><node name="outInfo" path="/mainloop/Recorder/outInfo/">\
<node name="0" path="/mainloop/Recorder/outInfo/0/">\
<attr key="compression" type="string">LZ4</attr>\
<attr key="originalModuleName" type="string">asap</attr>\
<attr key="originalOutputName" type="string">events</attr>\
<attr key="typeDescription" type="string">Array of events (polarity ON/OFF).</attr>\
<attr key="typeIdentifier" type="string">EVTS</attr>\
<node name="info" path="/mainloop/Recorder/outInfo/0/info/">\
<attr key="sizeX" type="int">{width}</attr><attr key="sizeY" type="int">{height}</attr>\
<attr key="source" type="string">asap</attr></node></node></node></dv>"""


def write_aedat4(file: IO[bytes], chunks: Iterable[Events], width: int, height: int) -> int:
    """Write one stream of events."""
    for name, side in (("width", width), ("height", height)):
        if not 0 < side <= MAX_PIXELS:
            remedy = f"AEDAT 4 states its sensor: give its size, 1 to {MAX_PIXELS} px"
            raise ValueError(named(name, side, remedy))
    lz4 = library("lz4.frame", "AEDAT4", "aedat4")
    text = _OUT_INFO.format(width=width, height=height).encode()
    # A flatbuffer: table's place and name; sizes and places of the fields; the table; the text.
    fields = struct.pack("<I4s5H2x", 20, b"IOHE", 10, 12, 4, 0, 8)
    header = fields + struct.pack("<iiII", 12, _LZ4, 4, len(text)) + text + b"\0"
    file.write(MAGIC + struct.pack("<I", len(header)) + header)
    count = 0
    for events in _packets(chunks, _AEDAT4_PERIOD_US):
        rows = np.zeros(len(events), EVENT)
        for role in "txy":
            rows[role] = events[role]
        rows["p"] = events["p"] > 0
        fields = struct.pack("<I4s3H2x", 16, b"EVTS", 6, 8, 4)
        size = len(fields) + 12 + rows.nbytes
        packet = struct.pack("<I", size) + fields + struct.pack("<iII", 8, 4, len(rows))
        content = lz4.compress(packet + rows.tobytes())
        file.write(struct.pack("<ii", 0, len(content)) + content)
        count += len(events)
    return count


# ---- MCAP ---------------------------------------------------------------------------------------
# Messages of event_camera_msgs, one stream in EVT3.

_PACKET = "event_camera_msgs/msg/EventPacket"
_DEFINITION = f"""std_msgs/Header header
uint32 height
uint32 width
uint64 seq
uint64 time_base
string encoding
bool is_bigendian
uint8[] events
{"=" * 80}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{"=" * 80}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
_CDR = struct.Struct("<4siII4xIIQQI5s?2xI")  # up to the events; frame_id is empty


def write_mcap(file: IO[bytes], chunks: Iterable[Events], width: int, height: int) -> int:
    """Write one topic, ``/events``, of ``EventPacket``; a message is stamped by its last event."""
    encoded = Encoded("evt3", width, height)
    writer = library("mcap.writer", "MCAP", "ros").Writer(file)
    writer.start(profile="ros2", library="asap")
    schema = writer.register_schema(_PACKET, "ros2msg", _DEFINITION.encode())
    topic = writer.register_channel("/events", "cdr", schema)
    count = 0
    for sequence, events in enumerate(_packets(chunks, _ROS_PERIOD_US)):
        words = b"".join(map(bytes, encoded.pieces(events)))
        first_s, first_us = divmod(int(events["t"][0]), 1_000_000)
        last_ns = int(events["t"][-1]) * 1000
        packet = _CDR.pack(
            b"\0\1\0\0", first_s, first_us * 1000, 1, height, width, sequence, 0,
            len(b"evt3\0"), b"evt3\0", False, len(words),
        )  # fmt: skip
        writer.add_message(topic, last_ns, packet + words, last_ns, sequence & 0xFFFFFFFF)
        count += len(events)
    writer.finish()
    return count


# ---- HDF5 ---------------------------------------------------------------------------------------
# Packed by gzip, which every HDF5 library unpacks.

_MS_US = 1000


def write_dsec(file: IO[bytes], chunks: Iterable[Events], width: int, height: int) -> int:
    """Write the layout of DSEC: columns, t_offset, and the first event of every ms.

    ``ms_to_idx[k]`` is the first event with t >= 1000 k; it ends with the number of events.
    """
    patient = _Patient(file)
    with library("h5py", "HDF5", "hdf5").File(patient, "w") as hdf5:
        columns = {
            role: _growing(hdf5, f"events/{role}", kind)
            for role, kind in {**_COLUMNS, "t": "<u4"}.items()
        }
        first_ms = _growing(hdf5, "ms_to_idx", "<u8")
        count, t_offset = 0, 0
        for chunk in chunks:
            t_offset = t_offset if count else int(chunk["t"][0])
            t = chunk["t"] - t_offset
            if int(t[-1]) > np.iinfo(np.uint32).max:
                raise ValueError(f"t = {chunk['t'][-1]}: DSEC ends 2^32 us after the first event")
            for role, column in columns.items():
                _append(column, t if role == "t" else chunk[role])
            marks = np.arange(len(first_ms), int(t[-1]) // _MS_US + 1) * _MS_US
            _append(first_ms, count + np.searchsorted(t, marks))
            count += len(chunk)
            patient.raise_error()
        _append(first_ms, np.array([count]))
        hdf5["t_offset"] = t_offset
        for name, side in (("width", width), ("height", height)):
            if side:
                hdf5[f"events/{name}"] = side
    patient.raise_error()
    return count


class _Patient:
    """A file for HDF5, which a failed write makes end the interpreter: its error waits."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        self._error: OSError | None = None

    def __getattr__(self, name: str) -> Any:
        method = getattr(self._file, name)

        def call(*arguments: Any) -> Any:
            try:
                return method(*arguments)
            except OSError as error:
                self._error = self._error or error
                return len(arguments[0]) if name == "write" else 0

        return call

    def raise_error(self) -> None:
        """Raise the first error there was."""
        if self._error is not None:
            raise self._error


def _growing(hdf5: Any, name: str, dtype: npt.DTypeLike) -> Any:
    options = {"chunks": CHUNK, "compression": "gzip", "compression_opts": 1, "shuffle": True}
    return hdf5.create_dataset(name, (0,), dtype, maxshape=(None,), **options)


def _append(dataset: Any, values: npt.NDArray[Any]) -> None:
    size = len(dataset)
    dataset.resize(size + len(values), axis=0)
    dataset[size:] = values
