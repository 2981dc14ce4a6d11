"""The study: every scheme and rival over profiles and cost models, beside the oracle.

``asap study`` on the command line, `study` here. A study is made of cases (a stream, a cost and the
contenders that go through it) and probes; they run through any executor, each finished one is kept,
and what they show is judged by goals and written as tables beside the reference's.
"""

from asap.study.cases import FORMS, Case
from asap.study.conduct import Study, study
from asap.study.goals import Goal
from asap.study.results import Results

__all__ = ["FORMS", "Case", "Goal", "Results", "Study", "study"]
