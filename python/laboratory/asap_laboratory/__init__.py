"""The laboratory: what the figures behind asap are made with; no part of its wheel.

`scenes` are events with exact truth, `score` and `keep_curve` judge an algorithm on them,
`profiles` are event rates over time, `baselines` the published schedulers beside ours,
`exact_oracle` the best that any scheduler of whole packages can do.

A study is its tasks, its tables and the template of its page; `conduct` runs what is missing and
writes page, data (CSV) and figures: ``asap-study`` on the command line. `STUDIES` holds them:
every scheme and rival over profiles and costs, judged by goals ("study"); `Deadline`
over bounds and disturbed costs ("bounds"); the algorithms' scores
over scenes and the kept fraction ("accuracy"); the cluster tracker beside its rivals ("rivals");
every consumer on one stream that overloads the slow ones ("ladder"); the simulator beside this
machine's clock ("realtime"); processor time over latency ("cpu_share"). `asap_laboratory.real`
makes one of recordings with boxes.
"""

from asap_laboratory import profiles, scenes
from asap_laboratory.accuracy import ACCURACY
from asap_laboratory.bounds import BOUNDS
from asap_laboratory.clairvoyant import exact_oracle
from asap_laboratory.cpu_share import CPU_SHARE
from asap_laboratory.ladder import LADDER
from asap_laboratory.realtime import REALTIME
from asap_laboratory.rivals import RIVALS_STUDY
from asap_laboratory.schemes import SCHEMES
from asap_laboratory.schemes.contenders import baselines
from asap_laboratory.scoring import KeepCurve, keep_curve, score
from asap_laboratory.study import Study, conduct

STUDIES = {
    study.name: study
    for study in (SCHEMES, BOUNDS, ACCURACY, RIVALS_STUDY, LADDER, REALTIME, CPU_SHARE)
}
"""By the name of its page."""

__all__ = [
    "STUDIES",
    "KeepCurve",
    "Study",
    "baselines",
    "conduct",
    "exact_oracle",
    "keep_curve",
    "profiles",
    "scenes",
    "score",
]
