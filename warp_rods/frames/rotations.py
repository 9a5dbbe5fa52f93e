"""Rotations: hat map, exp, log, their derivatives, quaternions (dissertation, appendix A); any leading axes."""

from __future__ import annotations

from math import factorial

import numpy as np
from numpy.typing import ArrayLike

from warp_rods.frames import checks

SERIES_BELOW = 1.0
"""The θ² below which power series replace the trigonometric forms, which lose digits for small angles."""
SERIES_C = [(-1) ** j / factorial(2 * j + 3) for j in range(8)]
SERIES_F = [(-1) ** j / factorial(2 * j + 4) for j in range(8)]
"""Eight terms reach round-off at θ² = 1, as in ``kernels/lie.py``."""


def hat(v: ArrayLike) -> np.ndarray:
    """The matrix of ``v ×`` [..., 3, 3] of vectors [..., 3] (A.24)."""
    return cross_matrix(checks.vectors("v", v))


def vee(matrix: ArrayLike) -> np.ndarray:
    """The vector [..., 3] of the antisymmetric part of matrices [..., 3, 3]: the inverse of ``hat`` (A.14)."""
    m = checks.matrices("matrix", matrix)
    m = m - np.swapaxes(m, -1, -2)
    return 0.5 * np.stack([m[..., 2, 1], m[..., 0, 2], m[..., 1, 0]], axis=-1)


def rotation_exp(theta: ArrayLike) -> np.ndarray:
    """The rotation [..., 3, 3] by the angle |θ| about θ [..., 3], in radians (A.28), (B.14)."""
    theta = checks.vectors("theta", theta)
    a, b, _ = coefficients(theta)
    return polynomial(theta, a, b)


def rotation_log(R: ArrayLike) -> np.ndarray:
    """The rotation vector [..., 3] of rotations [..., 3, 3], of length 0 to π.

    Through the quaternion, as (A.34) divides by sin θ: right to round-off up to and including half turns, where both
    signs of the axis are right. Raises SceneError for matrices that are no rotations.
    """
    q = quaternion(R)
    axis, w = q[..., :3], q[..., 3]
    half_sine = np.linalg.norm(axis, axis=-1)
    angle = 2 * np.arctan2(half_sine, w)
    return np.divide(angle, half_sine, out=np.full_like(w, 2.0), where=half_sine > 0)[..., None] * axis


def left_jacobian(theta: ArrayLike) -> np.ndarray:
    """V [..., 3, 3] of (B.14): exp(θ, µ) = (exp θ, V µ), and d exp(θ) = hat(V dθ) exp(θ)."""
    theta = checks.vectors("theta", theta)
    _, b, c = coefficients(theta)
    return polynomial(theta, b, c)


def left_jacobian_inverse(theta: ArrayLike) -> np.ndarray:
    """The inverse of V [..., 3, 3] (B.20), for angles below 2π."""
    theta = checks.vectors("theta", theta)
    return polynomial(theta, np.full(theta.shape[:-1], -0.5), inverse_coefficient(theta))


def quaternion(R: ArrayLike) -> np.ndarray:
    """Unit quaternions x, y, z, w with w ≥ 0 [..., 4] of rotations [..., 3, 3], as ``orientation`` of a trajectory."""
    R = checks.rotations("R", R)
    t = R[..., 0, 0] + R[..., 1, 1] + R[..., 2, 2]
    products = np.empty((*t.shape, 4, 4))  # 4 q qᵀ
    products[..., :3, :3] = R + np.swapaxes(R, -1, -2) + (1 - t)[..., None, None] * np.eye(3)
    for i, (j, k) in enumerate(((2, 1), (0, 2), (1, 0))):
        products[..., i, 3] = products[..., 3, i] = R[..., j, k] - R[..., k, j]
    products[..., 3, 3] = 1 + t
    largest = np.argmax(np.diagonal(products, axis1=-2, axis2=-1), axis=-1)
    row = np.take_along_axis(products, largest[..., None, None], axis=-2)[..., 0, :]
    q = row / np.linalg.norm(row, axis=-1, keepdims=True)
    return np.where(q[..., 3:] < 0, -q, q)


def from_quaternion(q: ArrayLike) -> np.ndarray:
    """Rotations [..., 3, 3] of quaternions x, y, z, w [..., 4] of any length but zero."""
    read = checks.shaped("q", q, (4,), "quaternions [..., 4]")
    size = np.linalg.norm(read, axis=-1, keepdims=True)
    if (size == 0).any():
        raise checks.SceneError(f"q{checks.place(checks.first(size[..., 0] == 0))} = 0: must not be zero")
    unit = read / size
    v, w = unit[..., :3], unit[..., 3, None, None]
    cross = cross_matrix(v)
    return np.eye(3) + 2 * w * cross + 2 * cross @ cross


def cross_matrix(v: np.ndarray) -> np.ndarray:
    """The matrix of ``v ×``."""
    matrix = np.zeros((*v.shape, 3))
    matrix[..., 2, 1], matrix[..., 0, 2], matrix[..., 1, 0] = v[..., 0], v[..., 1], v[..., 2]
    return matrix - np.swapaxes(matrix, -1, -2)


def polynomial(theta: np.ndarray, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """1 + first θ̂ + second θ̂²."""
    cross = cross_matrix(theta)
    return np.eye(3) + first[..., None, None] * cross + second[..., None, None] * (cross @ cross)


def coefficients(theta: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A, B, C of (B.15), (B.16), each [...]: exp = 1 + A θ̂ + B θ̂², V = 1 + B θ̂ + C θ̂²."""
    t, small, angle = _sizes(theta)
    c, f = _series(SERIES_C, t), _series(SERIES_F, t)
    half_sine = np.sin(angle / 2)
    a = np.where(small, 1 - t * c, 2 * half_sine * np.cos(angle / 2) / angle)
    square = angle * angle
    b = np.where(small, 0.5 - t * f, 2 * half_sine * half_sine / square)
    return a, b, np.where(small, c, (1 - a) / square)


def inverse_coefficient(theta: np.ndarray) -> np.ndarray:
    """(1 − A/2B)/θ² of (B.20) [...]; finite below 2π."""
    t, small, angle = _sizes(theta)
    f = _series(SERIES_F, t)
    near = (_series(SERIES_C, t) - 2 * f) / (1 - 2 * t * f)
    half = angle / 2
    return np.where(small, near, (1 - half / np.tan(half)) / (angle * angle))


def _sizes(theta: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """θ² where it is small and 0 elsewhere, whether it is, and |θ| where it is not and 1 elsewhere."""
    t = np.sum(theta * theta, axis=-1)
    small = t < SERIES_BELOW
    return np.where(small, t, 0.0), small, np.sqrt(np.where(small, 1.0, t))


def _series(terms: list[float], t: np.ndarray) -> np.ndarray:
    """Σ terms[j] tʲ."""
    total = np.full_like(t, terms[-1])
    for term in reversed(terms[:-1]):
        total = term + t * total
    return total
