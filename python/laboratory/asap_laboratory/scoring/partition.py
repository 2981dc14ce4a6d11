"""Events as two partitions, true labels and returned ids: V-measure, adjusted Rand, F-measure."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray


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
    table = _contingency(np.asarray(labels), np.asarray(ids))
    if table.size == 0:
        return Partition(*[float("nan")] * 5)
    of_label, of_id = table.sum(1), table.sum(0)
    total = float(of_label.sum())
    entropy_c, entropy_k = _entropy(of_label), _entropy(of_id)
    both = _entropy(table[table > 0])
    h = 1 - (both - entropy_k) / entropy_c if entropy_c > 0 else 1.0
    c = 1 - (both - entropy_c) / entropy_k if entropy_k > 0 else 1.0
    f = 2 * table / (of_label[:, None] + of_id[None, :])
    return Partition(
        homogeneity=h,
        completeness=c,
        v_measure=2 * h * c / (h + c) if h + c > 0 else 0.0,
        ari=_adjusted_rand(table, of_label, of_id, total),
        f_measure=float(np.sum(of_label * f.max(axis=1)) / total),
    )


def _contingency(labels: NDArray[np.integer], ids: NDArray[np.integer]) -> NDArray[np.float64]:
    if labels.size == 0:
        return np.empty((0, 0))
    rows, row = np.unique(labels, return_inverse=True)
    columns, column = np.unique(ids, return_inverse=True)
    counts = np.bincount(row * columns.size + column, minlength=rows.size * columns.size)
    return counts.reshape(rows.size, columns.size).astype(np.float64)


def _entropy(counts: NDArray[np.float64]) -> float:
    share = counts / counts.sum()
    return float(-np.sum(share * np.log(share)))


def _adjusted_rand(
    table: NDArray[np.float64],
    of_label: NDArray[np.float64],
    of_id: NDArray[np.float64],
    total: float,
) -> float:
    together, in_label, in_id = (_pairs(counts) for counts in (table, of_label, of_id))
    by_chance = in_label * in_id / _pairs(np.array([total])) if total > 1 else 0.0
    most = (in_label + in_id) / 2
    return (together - by_chance) / (most - by_chance) if most != by_chance else 1.0


def _pairs(counts: NDArray[np.float64]) -> float:
    return float(np.sum(counts * (counts - 1)) / 2)
