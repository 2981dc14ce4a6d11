"""Events as two partitions, true labels and returned ids: V-measure, adjusted Rand, F-measure."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from sklearn.metrics import adjusted_rand_score, homogeneity_completeness_v_measure
from sklearn.metrics.cluster import contingency_matrix


class Partition(NamedTuple):
    """How well two partitions agree; 1 = they are the same."""

    homogeneity: float  #: h = 1 - H(C|K) / H(C): an id holds one label only
    completeness: float  #: c = 1 - H(K|C) / H(K): a label has one id only
    v_measure: float  #: 2 h c / (h + c)
    ari: float  #: pairs put together or apart alike, adjusted for chance: 0 = chance
    f_measure: float  #: sum over C of n_C / n times the best 2 n_CK / (n_C + n_K)


def compare_partitions(labels: ArrayLike, ids: ArrayLike) -> Partition:
    """Compare the returned ids K of events with their true labels C; NaN without events.

    Whatever stands there is a class of its own, -1 (noise; no id) too. Rosenberg, Hirschberg:
    V-Measure, EMNLP-CoNLL 2007; Hubert, Arabie: Comparing Partitions, 1985; Larsen, Aone: Fast and
    Effective Text Mining Using Linear-time Document Clustering, KDD 1999 (the F-measure of a
    partition).
    """
    labels, ids = np.asarray(labels), np.asarray(ids)
    if labels.size == 0:
        return Partition(*[float("nan")] * 5)
    table = contingency_matrix(labels, ids)
    of_label, of_id = table.sum(1), table.sum(0)
    f = 2 * table / (of_label[:, None] + of_id[None, :])
    homogeneity, completeness, v_measure = homogeneity_completeness_v_measure(labels, ids)
    return Partition(
        homogeneity=float(homogeneity),
        completeness=float(completeness),
        v_measure=float(v_measure),
        ari=float(adjusted_rand_score(labels, ids)),
        f_measure=float(np.sum(of_label * f.max(axis=1)) / labels.size),
    )
