"""Writhe, link and twist of curves, by Gauss integrals that are exact for polygons: Lk = Wr + Tw (Călugăreanu)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from warp_rods import arguments
from warp_rods.errors import SceneError
from warp_rods.frames import checks

_CURVES_AT_ONCE = 32
"""Limits the memory: a curve of 65 nodes has 1953 pairs of segments."""
_PAIRS_AT_ONCE = 1 << 17


def writhe(position: ArrayLike, closed: bool = False) -> np.ndarray:
    """(1/4π) ∬ (r₁−r₂)·dr₁×dr₂/|r₁−r₂|³ of curves [..., node, 3] taken as polygons; returns [...].

    closed: with the segment from the last node to the first. Positive for right-handed coils; zero to round-off for
    planar curves. A pair of segments contributes the solid angle of directions from which they appear to cross
    (Banchoff 1976; Klenin and Langowski 2000, method 1a). Curves that are not finite have NaN.
    """
    position = arguments.reals("position", position)
    if position.ndim < 2 or position.shape[-1] != 3:
        raise SceneError(f"position: must be vectors [..., 3] of nodes; has shape {position.shape}")
    curves = position.reshape(-1, *position.shape[-2:])
    parts = range(0, len(curves), _CURVES_AT_ONCE)
    sums = [_crossings(curves[first : first + _CURVES_AT_ONCE], closed) for first in parts]
    return np.concatenate([np.zeros(0), *sums]).reshape(position.shape[:-2]) / (2 * np.pi)


def link(first: ArrayLike, second: ArrayLike) -> np.ndarray:
    """The linking number of two closed curves [..., node, 3], taken as polygons; returns [...].

    Gauss' integral, a whole number to round-off where the curves do not meet; positive where the second winds about the
    first as a right-handed screw. The number of nodes may differ. Of a ribbon: ``link(r, r + w * R[..., 1])`` with the
    closed frames R and a small width w. Raises SceneError for fewer than three nodes.
    """
    a, b = checks.nodal_vectors("first", first, 3), checks.nodal_vectors("second", second, 3)
    leading = np.broadcast_shapes(a.shape[:-2], b.shape[:-2])
    a, b = (np.broadcast_to(c, (*leading, *c.shape[-2:])).reshape(-1, *c.shape[-2:]) for c in (a, b))
    i, j = (x.ravel() for x in np.indices((a.shape[1], b.shape[1])))
    a, b = (np.concatenate([c, c[:, :1]], axis=1) for c in (a, b))
    return np.array([_solid_angles(p[None], q[None], i, j)[0] for p, q in zip(a, b, strict=True)]).reshape(leading) / (
        4 * np.pi
    )


def twist(R: ArrayLike, closed: bool = False) -> np.ndarray:
    """Turns [...] of frames [..., node, 3, 3] about their tangents, against parallel transport from node to node.

    closed: with the turn from the last frame to the first. A Bishop frame has none. Each turn must be below π: of a
    tightly wound rod take ``twist_of_strain``. With frames on the segments of a closed polygon, Lk = Wr + Tw holds to
    round-off; with frames at the nodes of a smooth curve, to second order in the spacing.
    """
    read = checks.nodal_rotations("R", R, 2)
    if closed:
        read = np.concatenate([read, read[..., :1, :, :]], axis=-3)
    before, after = read[..., :-1, :, :], read[..., 1:, :, :]
    cosine = 1 + np.sum(before[..., 0] * after[..., 0], axis=-1, keepdims=True)
    if (cosine <= 0).any():
        at = checks.first(cosine[..., 0] <= 0)
        raise SceneError(f"R{checks.place(at)}: the tangent of the next frame must not be opposite")
    along = np.sum(before[..., 1] * after[..., 0], axis=-1, keepdims=True) / cosine
    carried = before[..., 1] - along * (before[..., 0] + after[..., 0])
    sine, cosine = (np.sum(carried * after[..., i], axis=-1) for i in (2, 1))
    return np.arctan2(-sine, cosine).sum(axis=-1) / (2 * np.pi)


def twist_of_strain(strain: ArrayLike, spacing: ArrayLike) -> np.ndarray:
    """∫ Ω[0] ds/2π [...] of strains [..., node, 3]: turns from end to end; trapezoid rule. spacing: Δs."""
    read = checks.nodal_vectors("strain", strain, 2)
    ds = checks.spacings(spacing, read.shape[:-2])
    return np.trapezoid(read[..., 0], axis=-1) * ds[..., 0] / (2 * np.pi)


def _crossings(curves: np.ndarray, closed: bool) -> np.ndarray:
    """Sum over pairs of segments, each once [curve]; neighbours lie in a plane and contribute nothing."""
    if closed:
        curves = np.concatenate([curves, curves[:, :1]], axis=1)
    segments = curves.shape[1] - 1
    first, second = np.triu_indices(segments, k=2)
    if closed:
        apart = second - first < segments - 1
        first, second = first[apart], second[apart]
    return _solid_angles(curves, curves, first, second)


def _solid_angles(a: np.ndarray, b: np.ndarray, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Sum of the solid angles of pairs of segments, ``first`` of a [curve, node, 3] and ``second`` of b [curve]."""
    parts = range(0, max(len(first), 1), _PAIRS_AT_ONCE)
    pairs = [(first[k : k + _PAIRS_AT_ONCE], second[k : k + _PAIRS_AT_ONCE]) for k in parts]
    return np.sum([_some_solid_angles(a, b, i, j) for i, j in pairs], axis=0)


def _some_solid_angles(a: np.ndarray, b: np.ndarray, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    def between(i: np.ndarray, j: np.ndarray) -> np.ndarray:
        chord = b[:, j] - a[:, i]
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
