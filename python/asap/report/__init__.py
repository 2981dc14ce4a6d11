"""How results are drawn: as figure (``*_figures``) and page (``*_report``); needs matplotlib.

A result imports its own when it is asked: ``run.plot()``, ``run.report(path)``.
"""

__all__ = [
    "accuracy_figures",
    "accuracy_report",
    "comparison_figures",
    "comparison_report",
    "inspection_figures",
    "inspection_report",
    "page",
    "run_report",
    "scene_figures",
]
