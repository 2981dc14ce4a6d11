"""What runs, comparisons, inspections and keep curves found: plain objects, tables beside them.

Figures and pages are above them, in `asap.plots` and `asap.report`, and imported when asked for.
"""

__all__ = [
    "accuracy_table",
    "comparison",
    "comparison_table",
    "cost",
    "diagnosis",
    "inspection",
    "inspection_table",
    "keep_curve",
    "notebook",
    "result",
    "run",
    "run_archive",
    "run_table",
]
