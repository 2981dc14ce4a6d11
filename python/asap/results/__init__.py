"""What runs, comparisons, inspections and keep curves found: plain objects, tables beside them.

Figures and pages are above them, in `asap.plots` and `asap.report`, and imported when asked for.
"""
