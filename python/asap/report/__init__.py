"""How results are shown: as text (``*_table``), figure (``*_figures``) and page (``*_report``).

A result imports its own when it is asked: ``print(run)``, ``run.plot()``, ``run.report(path)``.
Only the tables do without matplotlib.
"""

__all__ = [
    "accuracy_figures",
    "accuracy_report",
    "accuracy_table",
    "comparison_figures",
    "comparison_report",
    "comparison_table",
    "inspection_figures",
    "inspection_report",
    "inspection_table",
    "notebook",
    "page",
    "run_report",
    "run_table",
    "scene_figures",
]
