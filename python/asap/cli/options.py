"""Options that verbs share: the recording, values with units, files to write."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import asap
from asap import _checks, _units
from asap.events.values import TIME_EXPONENTS
from asap.results import saved

T = TypeVar("T")

EXAMPLES = {
    "demo": "asap demo --out demo",
    "run": "asap run flight.aedat4 --algorithm mine:Detector",
    "view": "asap view flight.aedat4",
    "monitor": "asap monitor flight.csv",
    "cameras": "asap cameras",
    "compare": "asap compare flight.aedat4 --cost 100us+300ns --report flight.html",
    "info": "asap info flight.aedat4",
    "check": "asap check flight.aedat4",
    "convert": "asap convert flight.aedat4 flight.npz",
    "report": "asap report run.npz --out run.html",
    "completion": 'eval "$(asap completion bash)"',
}


def add_verb(verbs: Any, name: str, call: Callable[[Any], int], words: str) -> Any:
    """Add a verb with what every verb has; `call` gets the arguments and returns the exit code."""
    parser = verbs.add_parser(
        name,
        help=words,
        description=words[0].upper() + words[1:] + ".",
        epilog=f"example: {EXAMPLES[name]}",
        add_help=name not in ("run", "view"),  # these have a help of their own
    )
    parser.add_argument("--json", action="store_true", help="one JSON object on stdout")
    parser.set_defaults(verb=call)
    return parser


def add_recording(
    parser: argparse.ArgumentParser,
    metavar: str = "FILE",
    *,
    words: str = "a recording: Prophesee, AEDAT, HDF5, MATLAB, ROS bag, NumPy, text and others",
    on_bad: bool = True,
    nargs: str = "+",
) -> None:
    """Add the recording and how to read it; without `on_bad`, bad events are always counted."""
    words += "; several files or a folder of numbered parts are read one after the other"
    parser.add_argument("file", metavar=metavar, nargs=nargs, help=words)
    for side in ("--width", "--height"):
        parser.add_argument(
            side, type=int, metavar="PX", help="of the sensor, where the file has none"
        )
    parser.add_argument("--order", help="columns of a text file or plain array, such as txyp")
    parser.add_argument(
        "--time-unit",
        choices=tuple(TIME_EXPONENTS),
        help="of the times in the file (default: its header's, else s where they have a decimal "
        "point or are floats, us where not)",
    )
    parser.add_argument("--stream", metavar="NAME", help="which camera, where FILE holds several")
    parser.add_argument(
        "--file-format",
        choices=asap.io.FILE_FORMATS,
        metavar="NAME",
        help=f"where neither content nor file name tells it: {', '.join(asap.io.FILE_FORMATS)}",
    )
    parser.add_argument(
        "--from",
        dest="start",
        type=time,
        metavar="1.5s",
        help="leave out what is earlier than this after the first event",
    )
    parser.add_argument(
        "--to", dest="stop", type=time, metavar="3s", help="leave out what is not earlier"
    )
    parser.add_argument(
        "--reorder-tolerance",
        type=typed(_units.parse_duration_us, "reorder_tolerance"),
        default=0.0,
        metavar="20ms",
        help="sort events that come late by at most this much into their place",
    )
    if not on_bad:
        parser.set_defaults(on_bad="drop")
        return
    parser.add_argument(
        "--on-bad",
        choices=("drop", "clamp", "raise"),
        default="drop",
        help="what happens to bad events (default: dropped and counted)",
    )


def add_report(parser: argparse.ArgumentParser) -> None:
    """Add the page to write."""
    words = "write one HTML page with table and figure"
    parser.add_argument("--report", type=page_file, metavar="OUT.html", help=words)


def add_simulation(
    parser: argparse.ArgumentParser, *, cost: str, latency: str, required: bool = False
) -> None:
    """Add the simulated algorithm, the bound and the seed, with these words."""
    parser.add_argument(
        "--cost",
        type=typed(_units.parse_cost, "cost"),
        metavar="100us+300ns",
        required=required,
        help=cost,
    )
    parser.add_argument(
        "--execution",
        choices=("whole", "anytime"),
        help="how the algorithm takes a package: in parts, so that it ends on time, or as a whole "
        "(default: anytime; whole for an algorithm in Python)",
    )
    parser.add_argument(
        "--latency", type=typed(_units.parse_duration_us, "latency"), metavar="10ms", help=latency
    )
    parser.add_argument("--seed", type=int, default=0, help="of the gamma filter (default: 0)")


def latency_ms(arguments: Any) -> float | None:
    """Return the bound that was asked for, if any."""
    return None if arguments.latency is None else arguments.latency / 1e3


def add_out(parser: argparse.ArgumentParser, default: str) -> None:
    """Add the folder to write to."""
    words = f"folder of what is written (default: {default})"
    parser.add_argument("--out", type=Path, default=Path(default), metavar="DIR", help=words)


def open_recording(arguments: Any) -> asap.Recording:
    """Open what `add_recording` asked for."""
    start, stop = (None if t is None else t / 1e6 for t in (arguments.start, arguments.stop))
    return asap.read(
        arguments.file if len(arguments.file) > 1 else arguments.file[0],
        width=arguments.width,
        height=arguments.height,
        order=arguments.order,
        time_unit=arguments.time_unit,
        on_bad=arguments.on_bad,
        stream=arguments.stream,
        file_format=arguments.file_format,
        reorder_tolerance_us=round(arguments.reorder_tolerance),
        start=start,
        stop=stop,
    )


def refuse_to_overwrite(arguments: Any, source: str | Path | None) -> None:
    """Refuse results that would take the place of the recording."""
    for option in ("save", "tracks", "video", "record"):
        if file := getattr(arguments, option):
            _checks.other_file(f"--{option}", file, source)


def typed(parse: Callable[..., T], field: str) -> Callable[[str], T]:
    """Let argparse show what a parser, called as parse(text, field=field), says of a text."""

    def parse_argument(text: str) -> T:
        try:
            return parse(text, field=field)
        except ValueError as error:
            words = str(error).removeprefix("path = ")
        except OSError as error:
            words = f"{text}: {error.strerror}"
        raise argparse.ArgumentTypeError(words)

    return parse_argument


time = typed(_units.parse_duration_us, "time")


def _run_file(text: str, *, field: str) -> Path:
    path = _checks.new_file(field, text)
    saved.check_name(path)
    return path


# Files that cannot be written are refused before the run, not after it.
run_file = typed(_run_file, "path")
page_file = typed(lambda text, field: _checks.page_file(field, text), "path")
writable = typed(lambda text, field: _checks.new_file(field, text), "path")
