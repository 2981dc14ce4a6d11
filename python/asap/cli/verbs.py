"""The verbs of ``asap``: each adds its options to the parser, and does what they ask for."""

from __future__ import annotations

import importlib
import os
import textwrap
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import asap
from asap import _progress, _units
from asap.cli.algorithms import (
    ALGORITHMS,
    FILTERS,
    SCHEMES,
    Help,
    chosen,
    run_options,
    scheme_of,
    setting,
    workers_of,
)
from asap.cli.live import add_cameras, add_live, is_live, run_live
from asap.cli.options import (
    add_out,
    add_recording,
    add_report,
    add_simulation,
    add_verb,
    latency_ms,
    open_recording,
    page_file,
    refuse_to_overwrite,
    run_file,
    typed,
    writable,
)
from asap.cli.outcome import (
    BAD_INPUT,
    CHECK_FAILED,
    OK,
    USAGE,
    Failure,
    code_of,
    hand_over,
    need_report,
    need_video,
    print_json,
    print_written,
    reading,
    show,
    tell_doubt,
    usage,
    writing,
)
from asap.io.conversion import WRITERS, format_of
from asap.io.errors import CutFile


def _add_demo(verbs: Any) -> None:
    verb = add_verb(verbs, "demo", _demo, "the paper's two experiments on synthetic scenes")
    add_out(verb, "asap-demo")
    verb.add_argument("--quick", action="store_true", help="shorter scenes")


def _demo(arguments: Any) -> int:
    need_report()
    from asap.cli import demo

    with writing(arguments.out), _progress.on_terminal() as on_progress:
        runs, paths = demo.run(arguments.out, quick=arguments.quick, on_progress=on_progress)
    *experiments, default = runs
    claims = [demo.claims(run) for run in experiments]
    if arguments.json:
        print_json(
            {
                "schema_version": 1,
                "runs": [run.summary() for run in runs],
                "claims": [[asdict(claim) for claim in of_run] for of_run in claims],
                "files": [str(path) for path in paths],
            }
        )
    else:
        for run, of_run in zip(experiments, claims, strict=True):
            print(run, end="\n\n")
            for claim in of_run:
                print(f"  {'holds' if claim.holds else 'FAILS':<7}{claim.sentence}")
                print(textwrap.indent(textwrap.fill(claim.seen, 69), " " * 9))
            print()
        print("The first experiment again, under the default scheme:\n")
        print(demo.side_by_side(experiments[0], default), end="\n\n")
        print_written(*paths)
    return OK if all(claim.holds for of_run in claims for claim in of_run) else CHECK_FAILED


def _add_run(verbs: Any) -> None:
    words = "run an algorithm on a recording or a camera, in closed loop"
    verb = add_verb(verbs, "run", _run, words)
    words = "show the panels of the run as text; FILE is then played as by --software-camera"
    verb.add_argument(
        "--monitor", action="store_const", const="terminal", dest="target", help=words
    )
    _add_run_options(verb)


def _add_view(verbs: Any) -> None:
    words = "watch a run in Rerun: its events, clusters with tracks, and what the loop does"
    verb = add_verb(verbs, "view", _run, words)
    words = "a window, one that listens on port 9876, or a file to write (default: spawn)"
    verb.add_argument("--target", default="spawn", metavar="spawn|connect|OUT.rrd", help=words)
    _add_run_options(verb)


def _add_run_options(verb: Any) -> None:
    words = "show this, or every algorithm with its parameters"
    verb.add_argument("-h", "--help", action=Help, nargs="?", metavar="algorithm", help=words)
    add_recording(verb, nargs="*")
    add_live(verb)
    verb.add_argument(
        "--algorithm",
        type=chosen,
        metavar="NAME[:PARAMETER=VALUE,...]",
        help=f"{', '.join(sorted(ALGORITHMS))}; or your own, as package.module:name, from the "
        "current directory or Python's path: a class is made with (width, height), of an object "
        "process(events) is used, a callable is called (default: clusters)",
    )
    words = "let so many threads share the events of the algorithm, as asap.Tiled does"
    verb.add_argument("--threads", type=int, metavar="N", help=words)
    verb.add_argument(
        "--before",
        type=partial(chosen, known=FILTERS),
        metavar="NAME[:PARAMETER=VALUE,...]",
        help="a filter in front: background, hot_pixels or your own",
    )
    verb.add_argument(
        "--tracks",
        type=writable,
        metavar="OUT.csv",
        help="write the clusters over time: id, t, x, y, vx, vy, size",
    )
    verb.add_argument(
        "--every",
        type=typed(_units.parse_duration_us, "every"),
        metavar="10ms",
        help="with --tracks: time of the events between two rows of a cluster (default: a package)",
    )
    verb.add_argument(
        "--video", type=writable, metavar="OUT.gif", help="write events and clusters, .gif or .mp4"
    )
    add_simulation(
        verb,
        cost="virtual time: an algorithm that takes this per package + per event",
        latency="latency bound (default: the scheme's own, else 10ms)",
    )
    verb.add_argument("--scheme", choices=tuple(SCHEMES), help="default: deadline")
    verb.add_argument(
        "--set",
        type=setting,
        action="append",
        default=[],
        metavar="NAME=VALUE",
        dest="settings",
        help="a parameter of the scheme, for example rate_bound=5e6; repeatable",
    )
    verb.add_argument(
        "--speed", type=float, default=1.0, help="of the recording (default: 1, as recorded)"
    )
    add_report(verb)
    verb.add_argument(
        "--save",
        type=run_file,
        metavar="RUN.npz",
        help="keep the run, for asap report: .npz log and summary, .json the summary alone",
    )


def _run(arguments: Any) -> int:
    if arguments.every and not arguments.tracks:
        raise Failure(USAGE, "--every: needs --tracks, the file that it is for")
    if arguments.report:
        need_report()
    if arguments.video:
        need_video(arguments.video)
    if arguments.target and len(arguments.file) == 1:
        arguments.software_camera, arguments.file = arguments.file[0], []
    if is_live(arguments):
        return run_live(arguments)
    with usage():
        scheme = scheme_of(arguments.scheme, arguments.settings)
        cost = asap.LinearCost(*arguments.cost) if arguments.cost else None
    with reading(arguments):
        recording = open_recording(arguments)
    with usage():
        refuse_to_overwrite(arguments, recording.path)
        simulates = cost is not None and not (arguments.tracks or arguments.video)
        workers = workers_of(arguments, recording, default=None if simulates else "clusters")
    options = run_options(arguments, scheme, workers) | {"speed": arguments.speed}
    last, code = asap.last_run(), OK
    try:
        with reading(arguments), workers.own, _progress.on_terminal() as on_progress:
            if cost is not None:
                options["execution"] = arguments.execution or "anytime"
                asap.simulate(recording, cost=cost, on_progress=on_progress, **options)
            else:
                asap.run(recording, on_progress=on_progress, **options)
        tell_doubt(recording)
    finally:  # as far as it went
        run = asap.last_run()
        if run is not None and run is not last:
            code = hand_over(run, arguments, workers.tracks)
    return code


def _add_monitor(verbs: Any) -> None:
    verb = add_verb(verbs, "monitor", _monitor, "the panels of a run in another process, as text")
    words = "the file that asap.Pipeline(telemetry=PATH) writes"
    verb.add_argument("file", nargs=1, metavar="PATH", help=words)


def _monitor(arguments: Any) -> int:
    from asap.viewer import monitor

    path = Path(arguments.file[0])
    with reading(arguments):
        if arguments.json:
            print_json({"schema_version": 1, "row": monitor.newest(path)})
        else:
            monitor.follow(path)
    return OK


def _add_compare(verbs: Any) -> None:
    verb = add_verb(verbs, "compare", _compare, "every scheme on the same events, and the oracle")
    add_recording(verb)
    add_simulation(
        verb,
        cost="required: what the algorithm takes per package + per event, as asap run estimates it "
        "for yours",
        latency="latency bound of all (default: 10ms)",
        required=True,
    )
    verb.add_argument(
        "--speed",
        type=float,
        default=1.0,
        help="compress time: 10 makes a quiet recording ten times as busy (default: 1)",
    )
    add_report(verb)


def _compare(arguments: Any) -> int:
    if arguments.report:
        need_report()
    with usage():
        cost = asap.LinearCost(*arguments.cost)
    with reading(arguments), _progress.on_terminal() as on_progress:
        comparison = asap.compare(
            open_recording(arguments),
            cost=cost,
            latency_ms=latency_ms(arguments),
            seed=arguments.seed,
            execution=arguments.execution or "anytime",
            speed=arguments.speed,
            on_bad=arguments.on_bad,
            on_progress=on_progress,
        )
    return show(comparison, arguments, (arguments.report, comparison.report)) or code_of(comparison)


def _add_info(verbs: Any) -> None:
    verb = add_verb(verbs, "info", _info, "what a recording holds")
    add_recording(verb)


def _info(arguments: Any) -> int:
    with reading(arguments):
        recording = open_recording(arguments)
        facts = asap.info(recording)
    tell_doubt(recording)
    if arguments.json:
        print_json(facts)
        return OK
    width, height = facts["width"], facts["height"]
    sensor = f"{width or '?'} x {height or '?'} px" if width or height else "unknown"
    if not (width and height):
        reach = f"events reach x = {facts['x_max']}, y = {facts['y_max']}"
        sensor += f": addresses are not checked; {reach}. Give --width and --height"
    rate = {name: _units.rate(value) for name, value in facts["rate_hz"].items()}
    rows = {
        "format": facts["format"],
        "sensor": sensor,
        "events": f"{_units.count(facts['events'])}, {_units.share(facts['on_share'])} ON",
        "duration": _units.duration(facts["duration_s"] * 1e6),
        "rate": f"mean {rate['mean']}, peak {rate['peak_10ms']} in 10 ms, "
        f"{rate['peak_1ms']} in 1 ms",
        "rejected": _units.reasons(facts["rejected"]) or "none",
    }
    if facts["lost_packets"]:
        rows["lost"] = f"{_units.count(facts['lost_packets'])} packets never arrived"
    if facts["clock_resets"]:
        rows["clock"] = (
            f"set back {facts['clock_resets']} x by 1 s or more: the duration leaves that out"
        )
    print(os.path.basename(facts["path"]))
    for name, value in rows.items():
        print(f"  {name:<10}{value}")
    return OK


def _add_check(verbs: Any) -> None:
    verb = add_verb(verbs, "check", _check, "what is wrong with a recording, where, and what helps")
    add_recording(verb, on_bad=False)


def _check(arguments: Any) -> int:
    with reading(arguments), _progress.on_terminal() as on_progress:
        inspection = asap.check(_as_source(arguments), on_progress=on_progress)
    code = show(inspection, arguments)
    if code or inspection.ok:
        return code
    is_lost = inspection.events == 0 and inspection.findings["truncated"].count > 0
    return BAD_INPUT if is_lost else CHECK_FAILED


def _as_source(arguments: Any) -> asap.Recording | Path:
    try:
        return open_recording(arguments)
    except CutFile as cut:
        return cut.path  # nothing can be read; the table says so


def _add_convert(verbs: Any) -> None:
    verb = add_verb(verbs, "convert", _convert, "write a recording in another format")
    add_recording(verb, "IN")
    verb.add_argument("out", type=writable, metavar="OUT", help="the file to write")
    verb.add_argument(
        "--format",
        choices=tuple(WRITERS),
        metavar="NAME",
        help=f"{', '.join(WRITERS)} (default: the suffix of OUT; .raw is evt3)",
    )
    verb.add_argument("--relative", action="store_true", help="count the time from the first event")


def _convert(arguments: Any) -> int:
    out = arguments.out
    with usage():
        to = format_of(out, arguments.format)
    with reading(arguments):
        recording = open_recording(arguments)
        with writing(out):
            count = asap.convert(recording, out, to=to, relative=arguments.relative)
    tell_doubt(recording)
    if arguments.json:
        print_json({"schema_version": 1, "path": str(out), "format": to, "events": count})
    else:
        print(f"wrote {out}: {_units.count(count)} events")
    return OK


def _add_report_verb(verbs: Any) -> None:
    verb = add_verb(verbs, "report", _report, "one HTML page about saved runs")
    verb.add_argument(
        "runs", nargs="+", type=Path, metavar="RUN.npz", help="of asap run --save; .json: no curves"
    )
    verb.add_argument(
        "-o",
        "--out",
        type=page_file,
        metavar="OUT.html",
        help="default: the first run's name with .html",
    )


def _report(arguments: Any) -> int:
    need_report()
    from asap.results.page import write_runs

    with reading(arguments):
        runs = [asap.load_run(path) for path in arguments.runs]
    out = arguments.out or arguments.runs[0].with_suffix(".html")
    with writing(out):
        write_runs(runs, out)
    if arguments.json:
        print_json({"schema_version": 1, "runs": len(runs), "file": str(out)})
    else:
        print_written(out)
    return OK


_FILES = ("file", "out", "record", "report", "runs", "save", "software_camera", "tracks", "video")


def _add_completion(verbs: Any) -> None:
    verb = add_verb(verbs, "completion", _completion, "a script that completes asap in a shell")
    verb.add_argument("shell", choices=("bash", "zsh"), help="of bash or of zsh")
    verb.set_defaults(verbs=verbs)


def _completion(arguments: Any) -> int:
    try:
        shtab = importlib.import_module("shtab")
    except ImportError as error:
        words = "asap completion needs shtab: install asap-events[completion]"
        raise Failure(USAGE, words) from error
    for parser in arguments.verbs.choices.values():
        for action in parser._actions:
            if action.dest in _FILES:
                action.complete = shtab.FILE
    script = shtab.complete(arguments.parser, arguments.shell)
    if arguments.json:
        print_json({"schema_version": 1, "shell": arguments.shell, "script": script})
    else:
        print(script)
    return OK


VERBS = (
    _add_demo,
    _add_run,
    _add_view,
    _add_monitor,
    add_cameras,
    _add_compare,
    _add_info,
    _add_check,
    _add_convert,
    _add_report_verb,
    _add_completion,
)
