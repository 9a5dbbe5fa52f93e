"""Strains along a curve in a frame without twist, and the rod that has them."""

from __future__ import annotations

import numpy as np

from warp_rods.centrelines.curve import Curve

__all__ = ["bishop_strains", "distances", "laid_out", "minimal_rotation"]

FINE = 1024
"""Steps along a curve in which a frame is transported, about."""
PARTS = 8
"""Parts of a cell between which a rod is taken as straight, for distances."""


def bishop_strains(curve: Curve, nodes: int) -> tuple[np.ndarray, np.ndarray]:
    """Strains [node, 3] in a frame without twist, 1/length of the curve, and the frame of the middle node [3, 3].

    That frame is turned by the smallest angle from (x, y, z) to the tangent, so that a line in the plane of x and y has
    Ω₁ = 0: ∂s t = Ω₂ d₁ − Ω₁ d₂ (2.48).
    """
    cells = nodes - 1
    parts = 2 * max(2, -(-FINE // (2 * cells)))
    middle = parts * (nodes // 2)
    s = np.linspace(0.0, curve.length, cells * parts + 1)
    tangent, bend = curve.tangent_and_bend(s)
    d1 = _transported(curve.place(s), tangent, minimal_rotation(tangent[0])[:, 1])
    d2 = np.cross(tangent, d1)
    frame = minimal_rotation(tangent[middle])
    c, sine = frame[:, 1] @ d1[middle], frame[:, 1] @ d2[middle]
    d1, d2 = c * d1 + sine * d2, c * d2 - sine * d1
    strain = np.stack([0.0 * s, -np.sum(bend * d2, axis=1), np.sum(bend * d1, axis=1)], axis=1)
    return means(strain, parts) * curve.length, frame


def means(values: np.ndarray, parts: int) -> np.ndarray:
    """Means [node, …] of values [(node − 1) parts + 1, …] over a cell about each node, over half a cell at both ends.

    The tangent of a rod that has them is that of the curve between any two nodes, however fine the bends of the curve.
    """
    total = np.concatenate([0.0 * values[:1], np.cumsum((values[1:] + values[:-1]) / 2, axis=0)])
    last = len(values) - 1
    at = np.arange(0, last + 1, parts)
    low, high = np.maximum(at - parts // 2, 0), np.minimum(at + parts // 2, last)
    return (total[high] - total[low]) / (high - low).reshape(-1, *[1] * (values.ndim - 1))


def minimal_rotation(tangent: np.ndarray) -> np.ndarray:
    """The rotation [3, 3] by the smallest angle from (1, 0, 0) to a unit vector; about z where they are opposite."""
    x, y, z = tangent
    if x < -1 + 1e-14:
        return np.diag([-1.0, -1.0, 1.0])
    k = 1 / (1 + x)
    return np.array([[x, -y, -z], [y, 1 - k * y * y, -k * y * z], [z, -k * y * z, 1 - k * z * z]])


def _transported(place: np.ndarray, tangent: np.ndarray, start: np.ndarray) -> np.ndarray:
    """A unit vector carried along without turning about the tangent, by double reflection, of fourth order."""
    d = np.empty_like(place)
    d[0] = start
    steps = np.diff(place, axis=0)
    for i, v in enumerate(steps):
        c = 2 / (v @ v)
        reflected, turned = d[i] - c * (v @ d[i]) * v, tangent[i] - c * (v @ tangent[i]) * v
        w = tangent[i + 1] - turned
        size = w @ w
        d[i + 1] = reflected - (2 / size * (w @ reflected) * w if size > 0 else 0.0)
        d[i + 1] /= np.linalg.norm(d[i + 1])
    return d


def laid_out(strain: np.ndarray, position: np.ndarray, rotation: np.ndarray, parts: int = 1) -> np.ndarray:
    """The centre line [(node − 1) parts + 1, 3] of a free rod of length 1 without twist (2.48), (D.77).

    strain: [node, 3] in the Bishop frame. position, rotation: of the middle node. Each cell bends uniformly.
    """
    cells = len(strain) - 1
    middle = len(strain) // 2
    theta = (strain[1:] + strain[:-1]) / (2 * cells)
    whole, ends = _cells(theta, 1.0 / cells)
    R, r = np.empty((cells + 1, 3, 3)), np.empty((cells + 1, 3))
    R[middle], r[middle] = rotation, position
    for i in range(middle, cells):
        R[i + 1], r[i + 1] = R[i] @ whole[i], r[i] + R[i] @ ends[i]
    for i in range(middle - 1, -1, -1):
        R[i] = R[i + 1] @ whole[i].T
        r[i] = r[i + 1] - R[i] @ ends[i]
    within = [r[:-1] + np.einsum("nij,nj->ni", R[:-1], _cells(theta * p / parts, p / parts / cells)[1])
              for p in range(parts)]  # fmt: skip
    return np.concatenate([np.stack(within, axis=1).reshape(-1, 3), r[-1:]])


def _cells(theta: np.ndarray, ds: float) -> tuple[np.ndarray, np.ndarray]:
    """exp(θ̂) [n, 3, 3] and the end of an arc of length ds [n, 3], in the frame at its start (B.15), (B.16)."""
    angle = np.linalg.norm(theta, axis=1)
    small = angle < 1e-4
    a = np.where(small, 1.0, angle)
    first = np.where(small, 1 - angle**2 / 6, np.sin(a) / a)
    second = np.where(small, 0.5 - angle**2 / 24, (1 - np.cos(a)) / a**2)
    third = np.where(small, 1 / 6 - angle**2 / 120, (a - np.sin(a)) / a**3)
    hat = np.zeros((len(theta), 3, 3))
    hat[:, [2, 0, 1], [1, 2, 0]] = theta
    hat[:, [1, 2, 0], [2, 0, 1]] = -theta
    square = hat @ hat
    R = np.eye(3) + first[:, None, None] * hat + second[:, None, None] * square
    J = np.eye(3) + second[:, None, None] * hat + third[:, None, None] * square
    return R, ds * J[:, :, 0]


def distances(points: np.ndarray, line: np.ndarray) -> np.ndarray:
    """Distances [point] of points [point, 3] from a polygon [n, 3] whose corners are close together."""
    from scipy.spatial import cKDTree

    _, nearest = cKDTree(line).query(points)
    found = np.linalg.norm(points - line[nearest], axis=1)
    for other in (-1, 1):
        end = np.clip(nearest + other, 0, len(line) - 1)
        side, arm = line[end] - line[nearest], points - line[nearest]
        size = np.maximum(np.sum(side * side, axis=1), np.finfo(float).tiny)
        along = np.clip(np.sum(arm * side, axis=1) / size, 0.0, 1.0)
        found = np.minimum(found, np.linalg.norm(arm - along[:, None] * side, axis=1))
    return found
