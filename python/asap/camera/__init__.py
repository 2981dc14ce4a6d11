"""Cameras: those that neuromorphic-drivers opens, and SoftwareCamera, which plays a recording.

A camera is read by one thread at a time: its own while it feeds a pipeline.
"""

from __future__ import annotations

import math
import sys
import threading
import time
import warnings
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from asap import _checks
from asap.camera.playback import Playback
from asap.camera.recorder import Recorder
from asap.camera.settings import configuration
from asap.events import EVENT_DTYPE
from asap.experiment.live_run import CameraRun
from asap.experiment.pipeline import Pipeline
from asap.io.conversion import in_order, losses
from asap.io.errors import library
from asap.io.source import Source
from asap.results import Run

__all__ = ["Camera", "CameraError", "CameraInfo", "Packet", "SoftwareCamera"]
__all__ += ["cameras", "open_camera", "record"]

_WAIT_S = 0.1  # the longest that a silent camera keeps its thread
_STEP_US = 1000  # events of a packet that came within it are of one age
_MAX_STEPS = 64  # packets that a driver merges
_OLDEST_S = 60.0  # limit on a packet's age, since the wall clock may have been set
_UNPLUGGED = "it was unplugged; plug it in and open it again"
# neuromorphic-drivers raises only RuntimeError; its words tell the cause.
_REMEDIES = {
    "Access denied": f"run 'sudo {sys.executable} -m neuromorphic_drivers.udev', then plug it in",
    "Other error": "this machine shows no USB (/dev/bus/usb), as in a container; pass it in",
    "Input/Output": "this machine shows no USB (/sys/bus/usb), as in a container; pass it in",
    "no device found": "no camera is attached; plug it in, or use asap.SoftwareCamera(recording)",
    "not found": "no camera has this serial number; asap.cameras() lists those attached",
    "already used": "another program has opened it; close that one",
    "NoDevice": _UNPLUGGED,
    "disconnected": _UNPLUGGED,
}


class CameraError(RuntimeError):
    """A camera cannot be opened, or has gone; says which one, why, and what helps."""


class CameraInfo(NamedTuple):
    """An attached camera; `error` says why it cannot be asked for its serial number."""

    name: str
    serial: str | None
    connection: str
    error: str | None = None


class Packet(NamedTuple):
    """Events as a camera hands them over, and what its driver lost since the packet before.

    `arrival_time` is when the first of them reached this machine, s of `time.monotonic()`.
    """

    events: Any
    arrival_time: float
    lost_marks: int
    lost_packets: int


def cameras() -> list[CameraInfo]:
    """List the attached cameras, as name and serial number; [] if there are none.

    Raises
    ------
    CameraError
        USB cannot be read: the message says what helps.
    MissingLibrary
        The driver is not installed: extra ``camera``.

    Examples
    --------
    >>> for camera in asap.cameras():  # doctest: +SKIP
    ...     print(camera.name, camera.serial)
    """
    driver = library("neuromorphic_drivers", "a camera", "camera")
    try:
        found = driver.list_devices()
    except RuntimeError as error:
        raise _explained("cameras", error) from error
    return [CameraInfo(_name(d.name), d.serial, _name(d.connection), d.error) for d in found]


def open_camera(
    serial: str | None = None,
    *,
    region: tuple[int, int, int, int] | None = None,
    rate_bound: float | None = None,
    **driver_options: Any,
) -> Camera:
    """Open the camera of this serial number, or the first one, through neuromorphic-drivers.

    Parameters
    ----------
    serial : str, optional
        As `cameras` lists it.
    region : (left, top, width, height), optional
        Pixels outside send nothing, in px. For cameras of Prophesee, CenturyArks, and the DAVIS.
    rate_bound : float, optional
        The camera itself drops what is more, in events/s, without a count. For cameras of Prophesee
        and CenturyArks.
    **driver_options
        Arguments of ``neuromorphic_drivers.open``, such as ``configuration`` with the biases.

    Returns
    -------
    Camera
        A source for `run` and `Pipeline`, and a context manager that closes it.

    Raises
    ------
    ValueError
        A region or a rate that this camera cannot keep, or beside a ``configuration``.
    CameraError
        None is attached, access is denied, another program has it; the message says what helps.
    MissingLibrary
        The driver is not installed: extra ``camera``.

    Examples
    --------
    >>> with asap.open_camera() as camera:  # doctest: +SKIP
    ...     tracker = asap.ClusterTracker(camera.width, camera.height)
    ...     run = asap.run(camera, algorithm=tracker, latency_ms=10, duration_s=60)
    """
    driver = library("neuromorphic_drivers", "a camera", "camera")
    options = {"iterator_timeout": _WAIT_S} | driver_options
    try:
        if region is not None or rate_bound is not None:
            if "configuration" in options:
                raise ValueError("configuration: has a region and a rate of its own; give one way")
            found = [one for one in driver.list_devices() if serial in (None, one.serial)]
            if found:  # else the driver says so
                options["configuration"] = configuration(driver, found[0], region, rate_bound)
        return Camera(driver.open(serial=serial, **options))
    except RuntimeError as error:
        raise _explained(f"camera {serial or ''}".rstrip(), error) from error


def record(camera: Camera, path: str | Path, *, seconds: float | None = None) -> Path | None:
    """Record an open camera to a file, without an algorithm; the camera stays open.

    Events that waited in the driver before are left out. The file is as `Camera.record` says: its
    part can be read at any moment, and what came is kept however it ends, by Ctrl-C too.

    Parameters
    ----------
    camera : Camera
        One that feeds no pipeline.
    path : path
        Its suffix names the format, as in `convert`.
    seconds : float, optional
        How long. Default: until the camera ends.

    Returns
    -------
    Path or None
        The file; None, and an older file stays, if no event came.

    Raises
    ------
    CameraError
        The camera has gone, or the file could not be written to its end.
    RuntimeError
        The camera is closed, feeds a pipeline or is recorded already.
    ValueError
        A bad time, or a path of no format that is written.

    Examples
    --------
    ::

        with asap.open_camera() as camera:
            asap.record(camera, "flight.raw", seconds=60)
    """
    if not isinstance(camera, Camera):
        remedy = "give a camera from asap.open_camera() or asap.SoftwareCamera(recording)"
        raise TypeError(_checks.named("camera", camera, remedy))
    if seconds is not None:
        _checks.number("seconds", seconds, 1e-3, 1e9, "give the seconds to record")
    return camera._record_alone(path, math.inf if seconds is None else seconds)


class Camera:
    """An open camera: feeds a pipeline from a thread of its own, or is iterated for its packets.

    Leaving the ``with`` block closes it, and raises a CameraError that no loop has raised yet.

    Parameters
    ----------
    device
        An open device of neuromorphic-drivers; it stays the attribute `device`, for its biases.

    Attributes
    ----------
    name, serial : str
    width, height : int
        Sensor, px.
    recorded : Path or None
        Once it is closed: the file that has the events that `record` asked for, its part if it
        could not be finished or would replace another after an error; None without events.
    pipeline : Pipeline or None
        The one that it feeds, or has fed last.

    Examples
    --------
    ::

        with asap.open_camera() as camera, asap.Pipeline(camera=camera, latency_ms=10) as pipeline:
            for package in pipeline:
                my_algorithm(package.events)
    """

    def __init__(self, device: Any) -> None:
        self.device, self.name, self.serial = device, _name(device.name()), str(device.serial())
        self._state = "open"
        self._error: BaseException | None = None
        self._is_cut = False  # by an error of what it is used for
        self.recorded: Path | None = None
        self._recorder: Recorder | None = None
        self._reading, self._leaving, self._stale = threading.Lock(), threading.Event(), False
        self._thread: threading.Thread | None = None
        self.pipeline: Pipeline | None = None
        self._dropped: int | None = 0  # the driver counts from the opening on, a pipeline adds up
        self._packets = self._backlog = self._max_backlog = 0
        self._last_s = time.monotonic()
        try:
            size = device.properties()
            self.width, self.height = int(size.width), int(size.height)
        except (AttributeError, TypeError, ValueError) as error:
            device.close()
            raise CameraError(
                f"{self}: does not tell its size in px; use its driver and asap.Pipeline"
            ) from error

    def __iter__(self) -> Iterator[Packet]:
        """Yield packets until the camera ends or is closed; CameraError if it has gone."""
        while self._state == "open":
            if (packet := self._read()) is not None:
                yield packet

    def _read(self) -> Packet | None:
        """Return the next packet; None: silence, or the end."""
        with self._reading:
            if self._state != "open":
                return None
            try:
                if self._stale and self.device.backlog():
                    self.device.clear_backlog(until=0)
                    self._dropped = None
                self._stale = False
                status, packet = next(self.device)
            except StopIteration:
                self._state = "recording over"
                return None
            except Exception as error:
                found = _explained(str(self), error)
                self._state = "unplugged" if _UNPLUGGED in str(found) else "failed"
                raise found from error
        now, ring = time.monotonic(), status.ring
        if ring is None:
            return None
        age_s = min(max(status.system_time - ring.system_time, 0.0), _OLDEST_S)
        marks, events = packet.polarity_events_overflow_indices, packet.polarity_events
        before = ring.dropped_packets if self._dropped is None else self._dropped
        lost = max(ring.dropped_packets - before, 0)  # a counter that goes back begins again
        self._dropped, self._last_s, self._backlog = ring.dropped_packets, now, ring.backlog
        self._max_backlog = max(self._max_backlog, ring.backlog)
        self._packets += 1
        if events is None:  # something else came: frames, IMU
            events = np.empty(0, EVENT_DTYPE)
        if self._recorder is not None and self._recorder.is_open:
            self._recorder.put(events)
        return Packet(events, now - age_s, 0 if marks is None else len(marks), lost)

    def _feed(self, pipeline: Pipeline, duration_s: float | None = None) -> None:
        """Push from a thread until the camera ends or `duration_s` is over; then stop the pipeline.

        Events that waited before are left out. One camera feeds one pipeline at a time.
        """
        self._check_free("feed")
        self._stale = True
        end_s = math.inf if duration_s is None else time.monotonic() + duration_s
        self.pipeline = pipeline
        self._thread = threading.Thread(target=self._grab, args=(pipeline, end_s), name=str(self))
        self._thread.start()

    def _check_free(self, what: str) -> None:
        if self._thread is not None or self._state != "open":
            state = self._state if self._thread is None else "it feeds a pipeline already"
            raise RuntimeError(f"{what}: {self}: {state}; open it once for each pipeline")

    def _grab(self, pipeline: Pipeline, end_s: float) -> None:
        main = threading.main_thread()
        _count_feeds(1)
        try:
            while not self._leaving.is_set() and main.is_alive() and time.monotonic() < end_s:
                if (packet := self._read()) is not None:
                    pipeline.upstream_lost(packet.lost_marks, packet.lost_packets)
                    for events, arrival_time in _by_arrival(packet):
                        pipeline.push(events, arrival_time)
                elif self._state != "open" or not pipeline.is_open:
                    return
        except BaseException as error:  # a driver's panic is no Exception; push raises if stopped
            if isinstance(error, CameraError) or pipeline.is_open:
                self._error = error
        finally:
            _count_feeds(-1)
            pipeline.stop()  # what waits is delivered, then its loop ends

    def _run(self, on_progress: Any, **options: Any) -> Run:
        """Run for `asap.run`, which says what the arguments are."""
        self._check_free("run")
        return CameraRun(camera=self, **options).run_camera(on_progress)

    def _release(self) -> None:
        """End the feed and wait for its thread; the camera stays open."""
        if self._thread is not None:
            self._leaving.set()
            self._thread.join()  # _WAIT_S at most, and a push
            self._thread = None
            self._leaving.clear()

    def _raise_error(self) -> None:
        """Raise what has ended the feed, once."""
        error, self._error = self._error, None
        if error is not None:
            raise error

    def record(self, path: str | Path) -> None:
        """Write the events that are read from now on to a file, as `convert` does, until `close`.

        A thread writes; what the disk is too slow for, and bad events, count as `not_recorded`.
        Until `close`, the events are in a file beside it, as ``flight.part.raw``, that `load` reads
        at any moment: it stays where the process is killed or the disk is full. An older file stays
        where no event came, or an error ended the ``with`` block.
        """
        if self._recorder is not None and self._recorder.is_open:
            raise RuntimeError(f"record: {self} is recorded already, to {self._recorder.path}")
        self._recorder = Recorder(_checks.new_file("path", path), self.width, self.height)

    def _record_alone(self, path: str | Path, seconds: float) -> Path | None:
        """Read and record for `record`."""
        self._check_free("record")
        self.record(path)
        self.recorded, self._stale = None, True
        end_s, is_cut = time.monotonic() + seconds, True
        try:
            while self._state == "open" and time.monotonic() < end_s:
                self._read()
            is_cut = False
        except KeyboardInterrupt:
            is_cut = False
            raise
        finally:
            self._end_recording(replaces=not is_cut)
        self._raise_error()
        return self.recorded

    def stats(self) -> dict[str, Any]:
        """Sum up as one JSON object; `silent_s` counts from the last packet."""
        return {
            "name": self.name,
            "serial": self.serial,
            "backlog": self._backlog,
            "max_backlog": self._max_backlog,
            "packets": self._packets,
            "silent_s": time.monotonic() - self._last_s,
            "ended": self._state,
            "not_recorded": 0 if self._recorder is None else self._recorder.not_recorded,
        }

    def close(self) -> None:
        """End the feed, close the device and finish the recording."""
        self._release()
        with self._reading:
            self._state = "closed" if self._state == "open" else self._state
            self.device.close()
        self._end_recording(replaces=not self._is_cut)

    def _end_recording(self, *, replaces: bool) -> None:
        if self._recorder is not None and self._recorder.is_open:
            self.recorded, failure = self._recorder.close(replaces=replaces)
            self._error = self._error or (CameraError(failure) if failure else None)

    def __enter__(self) -> Camera:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self._is_cut = kind is not None and issubclass(kind, Exception)
        self.close()
        if kind is None:
            self._raise_error()

    def __str__(self) -> str:
        return f"{self.name} {self.serial}"

    def __repr__(self) -> str:
        return f"<Camera: {self}, {self.width} x {self.height} px, {self._state}>"


class SoftwareCamera(Camera):
    """A camera without hardware: a process that plays a recording in real time.

    It begins when it is first read, and its timestamps with 0. Packets that are not read in time
    are lost and counted, as by a driver; it ends with the recording.

    Parameters
    ----------
    source : path, Recording, array or iterable of arrays
        As in `asap.run`; the process holds all of it in memory.
    speed : float
        2 plays twice as fast: timestamps are divided by it.
    loop : bool
        Begin again at the end; time goes on.
    drop : float
        Probability that a packet is lost.
    packet_us : int
        Time that a packet spans, us.
    width, height : int, optional
        Sensor, px. Default: from the file.

    Raises
    ------
    ValueError
        A bad argument, a sensor of unknown size, no events, an event of an array that is bad.

    Warns
    -----
    UserWarning
        The file holds what is not played, such as bad events: how much, as `convert` says it.

    Examples
    --------
    >>> scene = asap.synthetic.FlightOverChairs(duration_s=0.1)
    >>> with asap.SoftwareCamera(scene) as camera:
    ...     tracker = asap.ClusterTracker(camera.width, camera.height)
    ...     run = asap.run(camera, algorithm=tracker, latency_ms=10)
    >>> run.ledger.balanced
    True
    """

    def __init__(
        self,
        source: Any,
        *,
        speed: float = 1.0,
        loop: bool = False,
        drop: float = 0.0,
        packet_us: int = 1000,
        width: int | None = None,
        height: int | None = None,
    ) -> None:
        _checks.number("speed", speed, 1e-3, 1e3, "must be between 0.001 and 1000")
        _checks.number("drop", drop, 0.0, 1.0, "must be between 0 and 1")
        _checks.whole("packet_us", packet_us, 1, 10**9, "must be between 1 and 10^9 us")
        _checks.flag("loop", loop)
        stream = Source(source, width=width, height=height, on_bad="drop")
        if not (stream.width and stream.height):
            raise ValueError("sensor = unknown: a camera knows its size; give width and height, px")
        size = stream.width, stream.height
        how = float(speed), bool(loop), float(drop), int(packet_us)
        super().__init__(Playback(in_order(stream, relative=True), size, *how))
        for loss in losses(stream):
            warnings.warn(f"{self}: {loss}", stacklevel=2)


def _by_arrival(packet: Packet) -> Iterator[tuple[Any, float]]:
    """Divide a packet that a driver merged: events arrive as far apart as their timestamps."""
    events, begin_s = packet.events, packet.arrival_time
    age_us = round(1e6 * (time.monotonic() - begin_s))
    if len(events) < 2 or age_us < _STEP_US:
        yield events, begin_s
        return
    t = events["t"]
    step_us = max(_STEP_US, age_us // _MAX_STEPS)
    since_us = np.clip((t - t[0]).astype(np.int64), 0, age_us)
    steps = np.maximum.accumulate(since_us // step_us)
    for begin, end in pairwise([0, *(np.flatnonzero(np.diff(steps)) + 1).tolist(), len(t)]):
        yield events[begin:end], begin_s + 1e-6 * int(steps[begin]) * step_us


def _name(value: Any) -> str:
    return str(getattr(value, "value", value))  # an enumeration's


def _explained(what: str, error: Exception) -> CameraError:
    remedy = next((text for key, text in _REMEDIES.items() if key in str(error)), "")
    return CameraError(": ".join(filter(None, (what, str(error) or repr(error), remedy))))


_feeding, _usual_s, _counting = 0, 0.0, threading.Lock()


def _count_feeds(step: int) -> None:
    """Let a grab thread have the interpreter within .5 ms, not 5, while Python works beside it."""
    global _feeding, _usual_s
    with _counting:
        if _feeding == 0:
            _usual_s = sys.getswitchinterval()
        _feeding += step
        sys.setswitchinterval(min(_usual_s, 5e-4) if _feeding else _usual_s)
