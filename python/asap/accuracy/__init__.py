"""Accuracy: what an algorithm gets right where the truth is known, and what discarding costs.

`score` judges one run, `keep_curve` one algorithm over the kept fraction gamma. All figures read
the `Trace` of a tracker or the matches of its samples.
"""

from asap.accuracy.curve import keep_curve
from asap.accuracy.scene import Scene
from asap.accuracy.scoring import score
from asap.results.keep_curve import KeepCurve, KeepRow

__all__ = ["KeepCurve", "KeepRow", "Scene", "keep_curve", "score"]
