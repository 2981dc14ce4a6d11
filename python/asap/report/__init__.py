"""How results are drawn: as figure (``*_figures``) and page (``*_report``); needs matplotlib.

A result imports its own when it is asked: ``run.plot()``, ``run.report(path)``.
"""
