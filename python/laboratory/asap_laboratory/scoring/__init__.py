"""Accuracy: what an algorithm gets right where the truth is known, and what discarding costs.

`score` judges one run, `keep_curve` one algorithm over the kept fraction gamma. All figures read
the `Trace` of a tracker or the matches of its samples.
"""

from asap_laboratory.scoring.curve import KeepCurve, keep_curve
from asap_laboratory.scoring.scene import Scene
from asap_laboratory.scoring.scoring import score

__all__ = ["KeepCurve", "Scene", "keep_curve", "score"]
