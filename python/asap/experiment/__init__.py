"""Experiments: a stream of events through ASAP into an algorithm, in virtual or in real time."""

from asap.experiment.batch import map
from asap.experiment.comparing import compare, oracle
from asap.experiment.pipeline import Pipeline
from asap.experiment.runners import last_run, run, simulate
from asap.experiment.tracks import Tracks
from asap.results import Comparison, Row, Run

__all__ = [
    "Comparison",
    "Pipeline",
    "Row",
    "Run",
    "Tracks",
    "compare",
    "last_run",
    "map",
    "oracle",
    "run",
    "simulate",
]
