"""The laboratory: what the figures behind asap are made with; no part of its wheel.

`scenes` are events with exact truth, `score` and `keep_curve` judge an algorithm on them,
`profiles` are event rates over time, `baselines` the published schedulers beside ours.

The study puts every scheme and rival to profiles and cost models, beside the oracle:
``asap-study`` on the command line, `study` here. A study is made of cases (a stream, a cost and the
contenders that go through it) and probes; they run through any executor, each finished one is kept,
and what they show is judged by goals and written as tables beside the reference's. `accuracy_study`
scores the algorithms instead, over scenes and the kept fraction; `rivals_study` puts the cluster
tracker beside its rivals; `ladder_study` puts every consumer of the library to one stream that
overloads the slow ones; `real_study` shows the tracker on recordings with boxes.
"""

from asap_laboratory import profiles, scenes
from asap_laboratory.accuracy.conduct import AccuracyStudy, accuracy_study
from asap_laboratory.cases import FORMS, Case
from asap_laboratory.conduct import Study, study
from asap_laboratory.contenders import baselines
from asap_laboratory.goals import Goal
from asap_laboratory.ladder.conduct import LadderStudy, ladder_study
from asap_laboratory.real.conduct import RealStudy, real_study
from asap_laboratory.results import Results
from asap_laboratory.rivals.conduct import RivalsStudy, rivals_study
from asap_laboratory.scoring import KeepCurve, keep_curve, score

__all__ = [
    "FORMS",
    "AccuracyStudy",
    "Case",
    "Goal",
    "KeepCurve",
    "LadderStudy",
    "RealStudy",
    "Results",
    "RivalsStudy",
    "Study",
    "accuracy_study",
    "baselines",
    "keep_curve",
    "ladder_study",
    "profiles",
    "real_study",
    "rivals_study",
    "scenes",
    "score",
    "study",
]
