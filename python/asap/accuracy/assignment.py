"""The assignment problem: which row goes with which column, at the least total cost."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def assign(cost: ArrayLike) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Assign rows to columns one to one at the least sum of costs.

    Parameters
    ----------
    cost : array_like of float, shape (n, m)
        Finite.

    Returns
    -------
    rows, columns : ndarray of int64, shape (min(n, m),)
        Rows ascending.

    Notes
    -----
    Shortest augmenting paths with potentials: Jonker, Volgenant: A Shortest Augmenting Path
    Algorithm for Dense and Sparse Linear Assignment Problems, Computing 38, 1987. Of n^2 m steps at
    most (n <= m), in vectors of m.
    """
    table = np.asarray(cost, np.float64)
    if table.ndim != 2 or not np.all(np.isfinite(table)):
        raise ValueError(f"cost of shape {table.shape}: must be a matrix of finite numbers")
    if table.shape[0] > table.shape[1]:
        columns, rows = assign(table.T)
        order = np.argsort(rows)
        return rows[order], columns[order]
    n, m = table.shape
    row_price, column_price = np.zeros(n), np.zeros(m)
    row_of = np.full(m, -1, np.int64)
    for start in range(n):
        distance, previous = np.full(m, np.inf), np.full(m, start, np.int64)
        open_columns, closed = np.ones(m, bool), []
        row, reached = start, 0.0
        while True:
            through = reached + table[row] - row_price[row] - column_price
            shorter = open_columns & (through < distance)
            distance[shorter], previous[shorter] = through[shorter], row
            column = int(np.argmin(np.where(open_columns, distance, np.inf)))
            reached = distance[column]
            if row_of[column] < 0:
                break
            open_columns[column] = False
            closed.append(column)
            row = int(row_of[column])
        row_price[start] += reached
        slack = reached - distance[closed]
        row_price[row_of[closed]] += slack
        column_price[closed] -= slack
        while column >= 0:  # along the path, back to the row that was free
            row = int(previous[column])
            after = np.flatnonzero(row_of == row)
            row_of[column] = row
            column = int(after[0]) if row != start else -1
    columns = np.flatnonzero(row_of >= 0)
    order = np.argsort(row_of[columns])
    return row_of[columns][order], columns[order]
