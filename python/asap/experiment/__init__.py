"""Experiments: a stream of events through ASAP into an algorithm, in virtual or in real time."""

from asap.experiment.result import Run, load_run
from asap.experiment.runners import last_run, run, simulate

__all__ = ["Run", "last_run", "load_run", "run", "simulate"]
