"""No test of these is timed: a busy machine is no defect."""

from hypothesis import settings

settings.register_profile("untimed", deadline=None)  # the rest as Hypothesis has chosen
settings.load_profile("untimed")
