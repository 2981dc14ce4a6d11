"""Cameras on the command line: ``asap cameras``, and ``asap run`` of one instead of a file."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any

import asap
from asap import _progress, _units
from asap.cli.algorithms import run_options, scheme_of, workers_of
from asap.cli.options import (
    add_verb,
    open_recording,
    refuse_to_overwrite,
    typed,
    writable,
)
from asap.cli.outcome import (
    BAD_INPUT,
    OK,
    USAGE,
    Failure,
    hand_over,
    print_json,
    reading,
    say,
    usage,
)

_WINDOWS = ("spawn", "connect", "terminal")


def add_cameras(verbs: Any) -> None:
    """Add ``asap cameras``."""
    add_verb(verbs, "cameras", _cameras, "the cameras that are attached; exit code 3 if none")


def _cameras(arguments: Any) -> int:
    with reading(arguments):
        found = asap.cameras()
    if arguments.json:
        print_json({"schema_version": 1, "cameras": [one._asdict() for one in found]})
    elif not found:
        print("no camera is attached")
    for one in () if arguments.json else found:
        print(f"{one.name}  {one.serial or '-'}  {one.connection}  {one.error or ''}".rstrip())
    return OK if found else BAD_INPUT


def add_live(parser: argparse.ArgumentParser) -> None:
    """Add the cameras that ``asap run`` takes instead of a file."""
    camera = parser.add_mutually_exclusive_group()
    words = "run a live camera instead of FILE: the one with this serial number, or the first"
    camera.add_argument("--camera", nargs="?", const="", metavar="SERIAL", help=words)
    words = "play FILE as a camera would, from a process of its own, on the live path"
    camera.add_argument("--software-camera", metavar="FILE", help=words)
    duration = typed(_units.parse_duration_us, "duration")
    words = "how long a camera runs (default: until it ends, or Ctrl-C)"
    parser.add_argument("--duration", type=duration, metavar="60s", help=words)
    words = "write the events of a camera, as asap convert does"
    parser.add_argument("--record", type=writable, metavar="OUT", help=words)


def is_live(arguments: Any) -> bool:
    """Whether a camera is asked for; refuse what does not go together."""
    live = arguments.camera is not None or arguments.software_camera is not None
    if live == bool(arguments.file):
        raise Failure(USAGE, "give one of FILE, --camera [SERIAL] and --software-camera FILE")
    if live and arguments.cost:
        raise Failure(USAGE, "--cost: simulates with a recording; a camera runs in real time")
    if arguments.camera is not None and arguments.speed != 1.0:
        raise Failure(USAGE, "--speed: not with --camera, which has its own pace")
    if arguments.camera is not None and (arguments.start, arguments.stop) != (None, None):
        raise Failure(USAGE, "--from, --to: only of a file; --duration says how long a camera runs")
    if not live and (arguments.record or arguments.duration):
        raise Failure(USAGE, "--record, --duration: only with a camera")
    return live


def _open(arguments: Any, recording: asap.Recording | None) -> asap.Camera:
    if recording is None:
        return asap.open_camera(arguments.camera or None)
    return asap.SoftwareCamera(recording, speed=arguments.speed)


def _recording(arguments: Any) -> asap.Recording | None:
    if arguments.camera is not None:
        return None
    arguments.file = [arguments.software_camera]
    return open_recording(arguments)


@contextmanager
def _shown(arguments: Any) -> Iterator[Any]:
    """Begin to show, and give what makes the callback of a camera's run."""
    if arguments.target:
        from asap import viewer

        with viewer.View(arguments.target) as view:
            yield lambda camera: lambda *_: view.attach(camera.pipeline)
    else:
        with _progress.on_terminal() as on_progress:
            yield lambda _: on_progress


def _tell_failure(camera: asap.Camera) -> None:
    """Tell what its recording ended with, where the run ended with something else."""
    try:
        camera._raise_error()
    except asap.CameraError as error:
        say(f"error: {error}")


def run_live(arguments: Any) -> int:
    """Run an algorithm on a camera; show and save the run, however it ended."""
    with usage():
        refuse_to_overwrite(arguments, arguments.software_camera)
        scheme = scheme_of(arguments.scheme, arguments.settings)
    before, camera, tracks, code = asap.last_run(), None, None, OK
    try:
        with (
            reading(arguments),
            nullcontext(_recording(arguments)) as recording,
            _shown(arguments) as show,  # what it starts takes its time, as opening does
            _open(arguments, recording) as camera,
        ):
            with usage():
                workers = workers_of(arguments, camera, default="clusters")
                tracks = workers.tracks
                if arguments.record:
                    camera.record(arguments.record)
            with workers.own:
                asap.run(
                    camera,
                    duration_s=arguments.duration and arguments.duration / 1e6,
                    on_progress=show(camera),
                    **run_options(arguments, scheme, workers),
                )
    finally:
        if camera is not None:
            _tell_failure(camera)
        run = asap.last_run()
        if run is not None and run is not before:
            shown = None if arguments.target in (None, *_WINDOWS) else Path(arguments.target)
            written = shown if shown and shown.exists() else None
            code = hand_over(run, arguments, tracks, written, camera.recorded if camera else None)
    return code
