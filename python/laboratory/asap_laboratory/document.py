"""The study as a document: goals, tables and figures, with the machine that has measured them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from asap_laboratory import tables, writer
from asap_laboratory.cases import FORMS
from asap_laboratory.goals import Goal
from asap_laboratory.results import MODELS, Results

_FORM_WORDS = dict(
    zip(
        FORMS,
        (
            "quick: a part of the cases, windows of 1 to 5 s, seed 1",
            "default: profiles of 5 s, 2 s for the further ones, seed 1",
            "full: profiles of 5 s, 2 s for the further ones, seeds 1 to 3, rows in hindsight",
        ),
        strict=True,
    )
)

_OPENING = """\
Which scheme processes the most events within a latency bound L? All schemes get the same events in
virtual time: profiles of event rates (quiet, bursts, ramps, flicker, steps and more) and four
simulated algorithms (fast, slow, one whose cost drifts, one with heavy tails and outages). The
score is the share of the oracle's events that a scheme processes in time; 1 is the maximum. Read it
together with p99 / L, which must not exceed 1: in the figure, up and left is better."""

_HOW_TO_READ = """\
The oracle, OB(L), is the maximum that any scheduler can finish within L without knowing the random
part of the cost. L = 2 ms with fast, 10 ms with the others. "Deadline" and "DeadBeat" are without a
limit on the overhead, "oh.25" with the user's default of a quarter; "DeadBeat L/2" has no knee,
"opaque" takes a package as a whole. Asap2020 has a = 0.9/beta, told to it. After the last event the
queue drains. The ring holds 2**20 events, for the further profiles more where 1.5 L of the highest
rate needs it."""

_DIFFERS = """\
An earlier study of the same schemes simulated a fluid in bins of 2 us, three seeds, with other
random numbers of the same distributions. These scores differ from it by more than .02."""

_FEW = """\
Events in time / EC(L). EC(L), the exact clairvoyant, pays for whole packages of the mean cost;
OB(L) serves single events, so no scheduler can finish more than EC(L) of it. L = 10 ms = 150 beta,
no noise; arrivals of load 1.1, 1.5 and 3, bursts of 5 ms and an overload on and off for 20 ms. Mean
of these / the least."""


def write(
    path: Path,
    results: Results,
    goals: Sequence[Goal],
    *,
    form: str,
    command: str,
    seconds: float,
    figures: Iterable[Path] = (),
) -> list[Path]:
    """Write the document and its data; return their paths.

    Parameters
    ----------
    path, command, seconds
        As in `writer.write`.
    results, goals
        What was measured, and how it was judged.
    form : str
        One of `FORMS`.
    figures : iterable of Path
        Beside the document.
    """
    figures = list(figures)
    lead = [figure for figure in figures if figure.stem == "score_and_latency"]
    sections = [
        _HOW_TO_READ,
        "## Goals",
        tables.goal_table(goals),
        *writer.pictures(figure for figure in figures if figure not in lead),
        "## Aggregate over the named profiles",
        "Mean score / least score / worst p99 over L / mean CPU.",
        tables.aggregate(results),
        "## Aggregate over the further profiles",
        tables.aggregate(results, further=True),
        "## Where few packages fit into the bound",
        _FEW,
        tables.few(results),
        *_per_model(results),
        "## slow: packages per second, CPU, p50 in ms",
        *(tables.by_profile(results, name, "slow") for name in ("packages_per_s", "cpu", "p50_ms")),
        "## The abrupt step in detail",
        "Profile steps, times in ms; 496: never settled.",
        *(
            f"### {model}\n\n{tables.steps(results, model)}"
            for model in ("slow", "slow_ht")
            if "steps" in results.profiles(model)
        ),
        "## Beside an earlier study",
        _DIFFERS,
        _deviations(results),
    ]
    return writer.write(
        path,
        "Study of the schemes",
        _OPENING,
        sections,
        _rows(results),
        command=command,
        seconds=seconds,
        notes=f". Form {_FORM_WORDS[form]}",
        lead=writer.pictures(lead),
    )


def _rows(results: Results) -> Iterable[dict[str, Any]]:
    for case, measured in results.cases():
        for label, figures in measured.figures.items():
            yield {
                **{name: getattr(case, name) for name in ("cost_model", "profile", "seed")},
                "contender": label,
                **asdict(figures),
                **{name: getattr(measured, name) for name in ("events", "oracle", "exact")},
            }


def _per_model(results: Results) -> Iterable[str]:
    for model in MODELS:
        if not results.profiles(model):
            continue
        yield f"## {model}"
        for quantity, words in (
            ("score", "Score."),
            ("p99_ms", "p99 in ms."),
            ("kept", "Share of the input that was processed."),
            ("gap_ms", "Gap in ms."),
        ):
            yield words
            yield tables.by_profile(results, quantity, model)
        if model == "slow_ht":
            yield (
                "Score against the oracle of an algorithm that takes a package as a whole, which "
                "cannot let cheap packages run on."
            )
            opaque = ("opaque DeadBeat", "opaque Deadline")
            yield tables.by_profile(results, "opaque_score", model, contenders=opaque)


def _deviations(results: Results) -> str:
    found = tables.deviations(results)
    if not found:
        return f"No score differs by more than {tables.DEVIATION:g}."
    return tables.markdown(
        ("cell", "ours", "earlier", "difference"),
        [
            (name, f"{ours:.3f}", f"{theirs:.3f}", f"{ours - theirs:+.3f}")
            for name, ours, theirs in found
        ],
    )
