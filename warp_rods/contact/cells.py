"""Pairs of points that are close, by a grid of cells, in NumPy alone: SciPy takes more than half a second to import."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

__all__ = ["close_pairs"]

MOST_CELLS = 1e6
"""Cells along each axis, at most, so that their numbers fit in 64 bits."""
AT_ONCE = 100_000
"""Points whose neighbours are listed at once, so that memory does not grow with all pairs."""


def close_pairs(some: np.ndarray, others: np.ndarray, reach: float) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Numbers [pair] of points [n, 3] and of others [m, 3] that are closer than the reach, or a little farther.

    The work is in proportion to the number of points, and of those within about two reaches of them.
    """
    if not len(some) or not len(others):
        return
    low = np.minimum(some.min(axis=0), others.min(axis=0))
    extent = float((np.maximum(some.max(axis=0), others.max(axis=0)) - low).max())
    width = max(reach, extent / MOST_CELLS, np.finfo(float).tiny)
    there, here = (np.floor((points - low) / width).astype(np.int64) + 1 for points in (others, some))
    _, rows, columns = np.maximum(there.max(axis=0), here.max(axis=0)) + 2

    def number(cells: np.ndarray) -> np.ndarray:
        """Cells in order of z, then y, then x, such that the three about a cell along z are consecutive."""
        return (cells[:, 0] * rows + cells[:, 1]) * columns + cells[:, 2]

    order = np.argsort(number(there), kind="stable")
    filled = number(there)[order]
    by_cell = np.argsort(number(here), kind="stable")
    across = [(dx * rows + dy) * columns for dx in (-1, 0, 1) for dy in (-1, 0, 1)]
    for part in np.array_split(by_cell, -(-len(by_cell) // AT_ONCE)):
        cells, which = np.unique(number(here[part]), return_inverse=True)
        for shift in across:
            begin = np.searchsorted(filled, cells + (shift - 1), "left")[which]
            count = np.searchsorted(filled, cells + (shift + 1), "right")[which] - begin
            first = np.repeat(part, count)
            within = np.arange(len(first)) - np.repeat(np.cumsum(count) - count, count)
            second = order[np.repeat(begin, count) + within]
            apart = some[first] - others[second]
            near = np.einsum("ni,ni->n", apart, apart) <= (1 + 1e-9) * reach**2
            yield first[near], second[near]
