"""Tables of the study as Markdown."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence

from asap_laboratory import reference
from asap_laboratory.contenders import PRIORS
from asap_laboratory.goals import Goal
from asap_laboratory.probes import Few
from asap_laboratory.results import MODELS, Results

DEVIATION = 0.02  #: of a score, from which on a cell is named

_STEP_COLUMNS = (
    ("p50_ms", "p50"),
    ("p99_ms", "p99"),
    ("max_ms", "max"),
    ("kept", "kept"),
    ("score", "score"),
    ("overflow", "overflow"),
    ("packages_per_s", "pkg/s"),
    ("cpu", "CPU"),
    ("gap_ms", "gap"),
    ("settle_ms", "settle"),
)
_SHARES = ("score", "kept", "overflow", "cpu", "in_time", "opaque_score")


def markdown(header: Sequence[str], rows: Iterable[Sequence[str]], *, numbers: bool = True) -> str:
    """Write a table; numbers stand to the right, but for the first column."""
    ruler = ["---", *["---:" if numbers else "---"] * (len(header) - 1)]
    lines = [header, ruler, *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def number(value: float | None, quantity: str) -> str:
    """Write a quantity as the tables do; nothing for None."""
    if value is None:
        return ""
    if quantity in _SHARES:
        return f"{value:.3f}".removeprefix("0")
    return f"{value:.0f}" if value >= 99.5 else f"{value:.3g}"


def goal_table(goals: Iterable[Goal]) -> str:
    """One row per goal."""
    words = {True: "pass", False: "**FAIL**", None: "-"}
    return markdown(
        ("goal", "test", "target", "measured", "runs", ""),
        [
            (one.id, one.test, one.target, one.measured, str(one.seen_on or ""), words[one.holds])
            for one in goals
        ],
        numbers=False,
    )


def aggregate(results: Results, *, further: bool = False) -> str:
    """Mean score / least score / worst p99 over L / mean CPU, over the profiles of a cost model."""
    rows = []
    for contender in _rows(results):
        cells = [contender]
        for model in MODELS:
            found = results.findings(contender, models=(model,), further=further)
            if not found:
                cells.append("")
                continue
            scores = _seed_means([(one.case.profile, one.figures.score) for one in found])
            p99 = [(one.case.profile, one.figures.p99_ms / one.latency_ms) for one in found]
            cpu = [one.figures.cpu for one in found]
            ours = {
                "mean": sum(scores) / len(scores),
                "least": min(scores),
                "p99_of_bound": max(_seed_means(p99)),
                "cpu": sum(cpu) / len(cpu),
            }
            cells.append(_quantities(ours))
        rows.append(cells)
    return markdown(("", *MODELS), rows)


def _quantities(values: dict[str, float]) -> str:
    def write(quantity: str, value: float) -> str:
        share = "cpu" if quantity == "cpu" else "score"
        return number(value, "p99_ms" if quantity == "p99_of_bound" else share)

    return " / ".join(write(quantity, value) for quantity, value in values.items())


def by_profile(
    results: Results,
    quantity: str,
    model: str,
    *,
    contenders: Iterable[str] | None = None,
) -> str:
    """One quantity with one cost model: contenders by profiles."""
    profiles = results.profiles(model)
    rows = list(_oracle_rows(results, model)) if quantity == "score" else []
    for contender in contenders if contenders is not None else _rows(results):
        cells = [
            _cell(results.mean(quantity, model, profile, contender), quantity)
            for profile in profiles
        ]
        if any(cells):
            rows.append([contender, *cells])
    return markdown(("", *profiles), rows)


def _oracle_rows(results: Results, model: str) -> Iterator[list[str]]:
    profiles = results.profiles(model)
    possible = [_mean(results.possible(model, profile)) for profile in profiles]
    yield ["OB(L)/input", *(_cell(share, "score") for share in possible)]
    exact = [_mean(results.exact(model, profile)) for profile in profiles]
    if any(share is not None for share in exact):
        yield ["EC(L)/input", *(number(share, "score") for share in exact)]


def few(results: Results) -> str:
    """Events in time / EC(L), mean and least over the arrivals, by bound in fixed costs."""
    found = results.few()
    bounds = sorted({probe.bound for probe, _ in found}, reverse=True)

    def row(name: str, share: Callable[[Few], float]) -> list[str]:
        cells = [name]
        for bound in bounds:
            shares = _seed_means(
                [(probe.arrivals, share(one)) for probe, one in found if probe.bound == bound]
            )
            mean = sum(shares) / len(shares)
            cells.append(f"{number(mean, 'score')} / {number(min(shares), 'score')}")
        return cells

    def reached(label: str) -> list[str]:
        return row(label, lambda one: one.finished[label] / one.exact)

    labels = dict.fromkeys(label for _, one in found for label in one.finished)
    possible = row("EC(L)/OB(L)", lambda one: one.exact / one.oracle)
    return markdown(
        ("", *(f"L = {bound} alpha" for bound in bounds)), [possible, *map(reached, labels)]
    )


def steps(results: Results, model: str) -> str:
    """Write the abrupt step in detail; times in ms."""
    rows = []
    for contender in _rows(results):
        cells = [
            _cell(results.mean(quantity, model, "steps", contender), quantity)
            for quantity, _ in _STEP_COLUMNS
        ]
        if any(cells):
            rows.append([contender, *cells])
    return markdown(("", *(words for _, words in _STEP_COLUMNS)), rows)


def deviations(results: Results, threshold: float = DEVIATION) -> list[tuple[str, float, float]]:
    """Scores that are farther from the reference's: cell, ours, the reference's."""
    found = []
    for contender in _rows(results):
        for model in MODELS:
            for profile in results.profiles(model):
                ours = results.mean("score", model, profile, contender)
                theirs = reference.per_profile("score", model, contender, profile)
                if ours is not None and theirs is not None and abs(ours - theirs) > threshold:
                    found.append((f"{contender}, {model}/{profile}", ours, theirs))
    return found


def _rows(results: Results) -> list[str]:
    return [label for label in results.contenders() if label not in PRIORS]


def _cell(value: float | None, quantity: str) -> str:
    return "" if value is None else number(value, quantity)


def _mean(values: Sequence[float]) -> float | None:
    return sum(values) / len(values) if values else None


def _seed_means(values: Iterable[tuple[str, float]]) -> list[float]:
    """Mean over the seeds of each profile."""
    by_profile: dict[str, list[float]] = {}
    for profile, value in values:
        by_profile.setdefault(profile, []).append(value)
    return [sum(seeds) / len(seeds) for seeds in by_profile.values()]
