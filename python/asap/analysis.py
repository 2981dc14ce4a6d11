"""Numbers from events and from runs, in plain NumPy.

Times are seconds from the first event; rates are events per second; windows are half-open.
"""

from asap.results.cost import Cost
from asap.results.numbers import (
    Description,
    Diagnosis,
    Pauses,
    PeakCount,
    decimate,
    describe,
    diagnose,
    fit_cost,
    median_in_windows,
    rate,
    time_s,
)

__all__ = [
    "Cost",
    "Description",
    "Diagnosis",
    "Pauses",
    "PeakCount",
    "decimate",
    "describe",
    "diagnose",
    "fit_cost",
    "median_in_windows",
    "rate",
    "time_s",
]
