"""Results: what has been measured, looked up by cost model, profile and contender."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple, TypeAlias, TypeVar

from asap_laboratory.accuracy.cases import Accuracy, AccuracyCase
from asap_laboratory.cases import NAMED, Case
from asap_laboratory.contenders import HINDSIGHT
from asap_laboratory.ladder.cases import LadderCase, LadderReplay, Outcomes
from asap_laboratory.ladder.cost import CostCase, Costs
from asap_laboratory.measure import Figures, Measured
from asap_laboratory.probes import Few, FewProbe, Probe, Steady, Window
from asap_laboratory.profiles import LATENCY_MS
from asap_laboratory.rivals.cases import RecordingCase, Rivalry, RivalsCase

Task: TypeAlias = (
    Case | Probe | AccuracyCase | RivalsCase | RecordingCase | CostCase | LadderCase | LadderReplay
)
Outcome: TypeAlias = Measured | Steady | Window | Few | Accuracy | Rivalry | Costs | Outcomes

MODELS = tuple(LATENCY_MS)
_LONG_SILENCE_MS = 60.0

T = TypeVar("T")


class Finding(NamedTuple):
    """One contender in one case."""

    case: Case
    measured: Measured
    figures: Figures

    @property
    def latency_ms(self) -> float:
        """The bound of the case."""
        return LATENCY_MS[self.case.cost_model]


class Results:
    """All that a study has measured.

    Parameters
    ----------
    pairs : iterable of (task, outcome)
        In any order.
    """

    def __init__(self, pairs: Iterable[tuple[Task, Outcome]]) -> None:
        self.pairs = list(pairs)

    def of(self, kind: type[T]) -> list[Any]:
        """Outcomes of the tasks of one kind."""
        return [outcome for task, outcome in self.pairs if isinstance(task, kind)]

    def findings(
        self,
        contender: str,
        *,
        models: Iterable[str] = MODELS,
        profiles: Iterable[str] | None = None,
        further: bool | None = None,
    ) -> list[Finding]:
        """Every run of a contender; of a row with hindsight, the best setting of each case.

        Parameters
        ----------
        contender : str
            A label of the tables.
        models, profiles : iterables of str
            Cost models, profiles; all unless given.
        further : bool, optional
            True: the further profiles only; False: the nine of the reference only.
        """
        models = tuple(models)
        profiles = None if profiles is None else tuple(profiles)
        found = []
        for case, measured in self.cases():
            if case.cost_model not in models or (profiles and case.profile not in profiles):
                continue
            if further is not None and case.is_further != further:
                continue
            figures = _figures_of(measured, contender)
            if figures is not None:
                found.append(Finding(case, measured, figures))
        return found

    def mean(self, quantity: str, model: str, profile: str, contender: str) -> float | None:
        """Mean of a quantity over the seeds; None where it was not measured."""
        found = self.findings(contender, models=(model,), profiles=(profile,))
        values = [getattr(one.figures, quantity) for one in found]
        return sum(values) / len(values) if values and None not in values else None

    def possible(self, model: str, profile: str) -> list[float]:
        """OB(L) as a share of the input, of every seed."""
        return [measured.oracle / max(measured.events, 1) for measured in self._of(model, profile)]

    def exact(self, model: str, profile: str) -> list[float]:
        """EC(L) as a share of the input, of every seed for which it was computed."""
        return [
            measured.exact / max(measured.events, 1)
            for measured in self._of(model, profile)
            if measured.exact is not None
        ]

    def few(self) -> list[tuple[FewProbe, Few]]:
        """Probes where few packages fit into the bound, with what they found."""
        return [
            (task, outcome)
            for task, outcome in self.pairs
            if isinstance(task, FewProbe) and isinstance(outcome, Few)
        ]

    def profiles(self, model: str) -> list[str]:
        """Profiles that were measured with a cost model: the nine in their order, then others."""
        seen = dict.fromkeys(case.profile for case, _ in self.cases() if case.cost_model == model)
        return sorted(seen, key=lambda name: NAMED.index(name) if name in NAMED else len(NAMED))

    def contenders(self) -> list[str]:
        """Labels of the rows that were measured, those with hindsight last."""
        seen = dict.fromkeys(label for _, one in self.cases() for label in one.figures)
        settings = {label for group in HINDSIGHT.values() for label in group}
        best = [label for label, group in HINDSIGHT.items() if set(group) <= set(seen)]
        return [label for label in seen if label not in settings] + best

    def _of(self, model: str, profile: str) -> Iterator[Measured]:
        for case, measured in self.cases():
            if (case.cost_model, case.profile) == (model, profile):
                yield measured

    def cases(self) -> Iterator[tuple[Case, Measured]]:
        """Yield every scenario with what was measured in it."""
        for task, outcome in self.pairs:
            if isinstance(task, Case) and isinstance(outcome, Measured):
                yield task, outcome


def _figures_of(measured: Measured, contender: str) -> Figures | None:
    if contender not in HINDSIGHT:
        return measured.figures.get(contender)
    settings = [measured.figures[one] for one in HINDSIGHT[contender] if one in measured.figures]
    # The reference's rule: a long silence is worth as much as the whole score.
    return max(
        settings,
        key=lambda one: one.score - (one.silence_ms >= _LONG_SILENCE_MS),
        default=None,
    )
