"""The paper's two experiments on synthetic scenes, and the first again under `Deadline`.

Tapia, Gomez Eguiluz, Martinez-de Dios, Ollero: ASAP, ICRA 2020 Workshop on Unconventional Sensors
in Robotics. The paper gives neither epsilon nor a least package size; the values here keep the
packages sensible at both ends: epsilon = 0.1 leaves a tenth of the time as margin, and 20 events
(50 in real time, where waking up costs about as much as 500 events) are the least worth a call.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from asap import _core, _units, analysis
from asap._progress import OnProgress
from asap.experiment import Run, simulate
from asap.experiment import run as run_in_real_time
from asap.synthetic import FlightOverChairs, ShakenPattern

__all__ = ["Claim", "abrupt_motion", "claims", "flight", "run", "side_by_side"]

RATE_BOUND = 5e6  # a of the paper, events/s
LATENCY_MS = 10.0
_WINDOW_MS = 100.0
_START_UP_S = 0.2


@dataclass(frozen=True)
class Claim:
    """A sentence of the paper about an experiment, and whether the log shows it."""

    sentence: str
    holds: bool
    seen: str


def abrupt_motion(
    scheme: _core.Scheme | None = None,
    *,
    duration_s: float = 5.0,
    on_progress: OnProgress | None = None,
) -> Run:
    """Experiment 1: a printed pattern, shaken harder and harder; virtual time.

    The algorithm costs 100 us + 150 ns per event. The scheme is that of the paper unless given.
    """
    return simulate(
        ShakenPattern(duration_s=duration_s),
        cost=_core.LinearCost(alpha_us=100, beta_ns=150),
        scheme=scheme or _core.Asap2020(rate_bound=RATE_BOUND, epsilon=0.1, min_size=20),
        latency_ms=LATENCY_MS,
        on_progress=on_progress,
    )


def flight(
    *, duration_s: float = 4.0, virtual: bool = False, on_progress: OnProgress | None = None
) -> Run:
    """Experiment 2: a flight over a growing number of chairs; the real clusterer, in real time.

    With `virtual`, in virtual time and at the cost of 20 us + 150 ns per event.
    """
    scene = FlightOverChairs(duration_s=duration_s)
    scheme = _core.Asap2020(rate_bound=RATE_BOUND, epsilon=0.1, min_size=50)
    tracker = _core.ClusterTracker(scene.width, scene.height)
    if virtual:
        cost = _core.LinearCost(alpha_us=20, beta_ns=150)
        return simulate(scene, cost=cost, scheme=scheme, algorithm=tracker, on_progress=on_progress)
    return run_in_real_time(scene, algorithm=tracker, scheme=scheme, on_progress=on_progress)


def run(
    out: str | Path, *, quick: bool = False, on_progress: OnProgress | None = None
) -> tuple[list[Run], list[Path]]:
    """Run both experiments, and the first again under `Deadline`; write figures and report.

    Returns the three runs, and the paths of the figures and the report in the folder `out`, which
    is made where it does not exist. `quick`: scenes of 1 s, each over the full range of rates.
    """
    from asap import plots
    from asap.results import page

    out = Path(out)
    out.mkdir(parents=True, exist_ok=True)
    motion_s, flight_s = (1.0, 1.0) if quick else (5.0, 4.0)
    default = _core.Deadline(latency_ms=LATENCY_MS)
    results = {
        "1_abrupt_motion": abrupt_motion(duration_s=motion_s, on_progress=on_progress),
        "2_flight": flight(duration_s=flight_s, on_progress=on_progress),
        "3_deadline": abrupt_motion(default, duration_s=motion_s, on_progress=on_progress),
    }
    for name, result in results.items():
        (out / f"{name}.svg").write_text(plots.svg(result.plot()), encoding="utf-8")
    runs, report = [*results.values()], out / "report.html"
    title = "ASAP: the paper's two experiments, and the first again under Deadline"
    page.write_runs(runs, report, title=title)
    return runs, [*(out / f"{name}.svg" for name in results), report]


def side_by_side(paper: Run, default: Run) -> str:
    """Compare the first experiment under the scheme of the paper and under `Deadline`, as text."""
    bound = _units.duration(default.latency_bound_us)
    lines = [f"{'':<22}{'in time':>9}{'p99':>10}{'largest':>10}{'kept':>9}"]
    for name, one in (("scheme of the paper", paper), ("Deadline, the default", default)):
        p99, largest = (_units.duration(us) for us in (one.latency.quantile(0.99), one.latency.max))
        in_time, kept = _units.share(one.in_time), _units.share(one.kept)
        lines.append(f"{name:<22}{in_time:>9}{p99:>10}{largest:>10}{kept:>9}")
    more = default.in_time / paper.in_time - 1 if paper.in_time else np.inf
    difference = f"{100 * abs(more):.0f} % {'more' if more >= 0 else 'fewer'} events"
    words = (
        f"With the same algorithm, Deadline processes {difference} within {bound} than the scheme "
        "of the paper. That scheme thins to a rate bound, which the user has to know. Deadline "
        "learns what the algorithm costs and uses all of the latency that the user allows."
    )
    return "\n".join([*lines, "", *_units.wrapped(words, 78)])


def claims(result: Run) -> list[Claim]:
    """Hold the paper's sentences against the log of one of the two experiments."""
    if result.source["format"] == ShakenPattern.name:
        return _claims_of_abrupt_motion(result)
    return _claims_of_flight(result)


def _claims_of_abrupt_motion(result: Run) -> list[Claim]:
    rows = result.packages
    time_s = analysis.time_s(result)
    first_thinned = int(np.argmax(rows["gamma"] < 1)) if (rows["gamma"] < 1).any() else rows.size

    windows_s, sizes = analysis.median_in_windows(result, "size", _WINDOW_MS)
    begin = _START_UP_S * result.source["duration_s"] / 5.0
    growing = sizes[(windows_s >= begin) & (windows_s < time_s[min(first_thinned, rows.size - 1)])]
    rising = float(np.mean(np.diff(growing) >= 0)) if growing.size > 1 else 0.0

    # Kept and offered events per window: R and the event rate that the filter had to bring down.
    window = np.floor(time_s / (_WINDOW_MS / 1e3)).astype(np.int64)
    seconds = _WINDOW_MS / 1e3
    rate = np.bincount(window, weights=rows["size"]) / seconds
    entering = np.bincount(window, weights=rows["offered"]) / seconds
    above = np.flatnonzero(entering > 1.1 * RATE_BOUND)
    above = above[above < window[-1]]  # the last window is not whole
    worst = float(np.abs(rate[above] / RATE_BOUND - 1).max()) if above.size else np.inf
    gamma = rate[above] / entering[above]
    return [
        Claim(
            "The package size grows with the motion while gamma = 1.",
            rising >= 0.9 and bool(growing[-1] > 10 * growing[0]),
            f"median size {growing[0]:.0f} to {growing[-1]:.0f}, "
            f"rising in {rising:.0%} of the windows",
        ),
        Claim(
            "Above the bound a, gamma falls.",
            bool(gamma.size and gamma[-1] < 0.6 and (np.diff(gamma) < 0.05).all()),
            f"gamma {gamma[0]:.2f} to {gamma[-1]:.2f}" if gamma.size else "the rate stayed below a",
        ),
        Claim("R settles within 10 % of a.", worst <= 0.1, f"largest distance {worst:.1%} of a"),
    ]


def _claims_of_flight(result: Run) -> list[Claim]:
    windows_s, margins = analysis.median_in_windows(result, "margin_us", _WINDOW_MS)
    margins = margins[windows_s >= _START_UP_S]
    negative = float(np.mean(margins < 0)) if margins.size else 0.0
    needed = 1.0 if result.mode == "virtual" else 0.95
    seen = f"in {negative:.0%} of the windows of 100 ms, median {np.median(margins):.0f} us"
    if result.lateness is not None:
        seen += f"; the machine's own jitter: p99 {result.lateness.quantile(0.99):.0f} us"
    return [
        Claim(
            "gamma = 1 throughout.",
            bool((result.packages["gamma"] == 1).all()),
            f"least gamma {result.packages['gamma'].min():.2f}",
        ),
        Claim("Processing time - span stays below zero.", negative >= needed, seen),
    ]
