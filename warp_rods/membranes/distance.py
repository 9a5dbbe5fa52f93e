"""φ on a grid: the signed distance to closed triangles, smoothed."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from warp_rods.membranes.triangles import Triangles

__all__ = ["Grid3D", "signed_distance", "smoothed"]

COARSE = 4
"""Spacings of the coarse grid from which distances far from the membrane are interpolated."""


class Grid3D:
    """Nodes first + (i, j, k) spacing, ``count`` [3] of them."""

    def __init__(self, first: np.ndarray, spacing: np.ndarray, count: np.ndarray):
        self.first, self.spacing, self.count = first, spacing, count

    def at(self, nodes: np.ndarray) -> np.ndarray:
        """The positions of nodes [n, 3]."""
        return self.first + nodes * self.spacing


def signed_distance(triangles: Triangles, grid: Grid3D, band: float) -> np.ndarray:
    """Distances [x, y, z] to the triangles, negative inside; exact up to ``band``, beyond it interpolated.

    Neighbours farther from the membrane than half their distance are on the same side of it. So the winding number,
    which takes most of the time, is needed close to the membrane, and once for every region beyond.
    """
    size = np.linalg.norm(grid.spacing)
    found = _interpolated(triangles, grid)
    near = np.argwhere(found < band + COARSE * size / 2)
    found[tuple(near.T)] = triangles.distance(grid.at(near))
    beyond = found > grid.spacing.max() / 2
    regions, count = ndimage.label(beyond)
    first = np.unique(regions, return_index=True)[1]
    samples = np.stack(np.unravel_index(first, found.shape), axis=-1)
    close = np.argwhere(~beyond)
    inside = triangles.distance(grid.at(np.concatenate([samples, close])), signed=True) < 0
    inside_region = np.zeros(count + 1, dtype=bool)
    inside_region[regions[tuple(samples.T)]] = inside[: len(samples)]
    negative = inside_region[regions]
    negative[tuple(close.T)] = inside[len(samples) :]
    return np.where(negative, -found, found)


def _interpolated(triangles: Triangles, grid: Grid3D) -> np.ndarray:
    """Distances [x, y, z] without sign, linear between the nodes of a coarser grid."""
    count = (grid.count + COARSE - 2) // COARSE + 1
    nodes = np.indices(tuple(count)).reshape(3, -1).T * COARSE
    coarse = triangles.distance(grid.at(nodes)).reshape(count)
    for axis, n in enumerate(grid.count):
        i, t = np.divmod(np.arange(n), COARSE)
        weight = (t / COARSE).reshape([-1 if a == axis else 1 for a in range(3)])
        after = np.minimum(i + 1, count[axis] - 1)
        coarse = (1 - weight) * np.take(coarse, i, axis) + weight * np.take(coarse, after, axis)
    return coarse


def smoothed(distance: np.ndarray, width: np.ndarray) -> np.ndarray:
    """2Gφ − GGφ with a Gaussian G of ``width`` [3] in grid spacings.

    A single Gaussian would move the membrane inwards by its mean curvature times width².
    """
    once = ndimage.gaussian_filter(distance, width, mode="nearest")
    return 2 * once - ndimage.gaussian_filter(once, width, mode="nearest")
