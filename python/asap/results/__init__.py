"""What runs, comparisons and inspections found.

Each of the three is a class; its text, figure, page and file are made by a module of their own when
they are asked for. Figures and pages need the extra `report`.
"""

from asap.results.comparison import Comparison, Row
from asap.results.inspection import Finding, Inspection
from asap.results.result import Named, table
from asap.results.run import Ledger, Run
from asap.results.saved import load_run

__all__ = [
    "Comparison",
    "Finding",
    "Inspection",
    "Ledger",
    "Named",
    "Row",
    "Run",
    "load_run",
    "table",
]
