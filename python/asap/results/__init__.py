"""What runs and comparisons found.

Each of the two is a class with its table; its figure, verdict, page and file are made by a module
of their own when they are asked for. Figures and pages need the extra `report`.
"""

from asap.results.comparison import Comparison, Row
from asap.results.result import Named, table
from asap.results.run import Ledger, Run
from asap.results.saved import load_run

__all__ = ["Comparison", "Ledger", "Named", "Row", "Run", "load_run", "table"]
