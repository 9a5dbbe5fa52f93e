"""Writhe of open centre lines: the Gauss integral over a polygon with itself, exact for the polygon."""

import numpy as np
from numpy.typing import ArrayLike

_CURVES_AT_ONCE = 32
"""Limits the memory: a curve of 65 nodes has 1953 pairs of segments."""


def writhe(position: ArrayLike) -> np.ndarray:
    """(1/4π) ∬ (r₁−r₂)·dr₁×dr₂/|r₁−r₂|³ of curves [..., node, 3] taken as polygons; returns [...].

    Positive for right-handed coils; zero to round-off for planar curves. A pair of segments contributes the solid angle
    of directions from which they appear to cross (Banchoff 1976; Klenin and Langowski 2000, method 1a).
    """
    position = np.asarray(position, dtype=np.float64)
    curves = position.reshape(-1, *position.shape[-2:])
    parts = range(0, len(curves), _CURVES_AT_ONCE)
    sums = [_crossings(curves[first : first + _CURVES_AT_ONCE]) for first in parts]
    return np.concatenate([np.zeros(0), *sums]).reshape(position.shape[:-2]) / (2 * np.pi)


def _crossings(curves: np.ndarray) -> np.ndarray:
    """Sum over pairs of segments, each once [curve]; neighbours lie in a plane and contribute nothing."""
    first, second = np.triu_indices(curves.shape[1] - 1, k=2)

    def between(i: np.ndarray, j: np.ndarray) -> np.ndarray:
        chord = curves[:, j] - curves[:, i]
        length = np.linalg.norm(chord, axis=-1, keepdims=True)
        return chord / np.where(length > 0, length, 1.0)

    # The directions from one segment to the other form a spherical quadrilateral with these corners: two triangles.
    corners = [between(first + i, second + j) for i, j in ((0, 0), (0, 1), (1, 1), (1, 0))]
    halves = _triangle(corners[0], corners[2], corners[1]) + _triangle(corners[0], corners[3], corners[2])
    return halves.sum(axis=1)


def _triangle(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Signed solid angle of the triangle of unit vectors a, b, c (van Oosterom and Strackee 1983)."""
    volume = np.sum(a * np.cross(b, c), axis=-1)
    return 2 * np.arctan2(volume, 1 + np.sum(a * b + b * c + c * a, axis=-1))
