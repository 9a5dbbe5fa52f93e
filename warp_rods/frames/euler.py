"""Euler angles (dissertation, appendix A.2): three rotations in turn, and where they fail.

``axes`` names the three axes, the outermost rotation first: R = e^{α â} e^{β b̂} e^{γ ĉ} (A.36), "zxz" in (A.42). These
are rotations about the axes of the body in the order of the letters, or about those of space in the opposite order.
"""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import ArrayLike

from warp_rods import arguments
from warp_rods.frames import checks
from warp_rods.frames.rotations import rotation_exp

LETTERS = dict(zip("xyz", np.eye(3), strict=True))
LOCK = 1e-7
"""Size of the determinant (A.47) below which ``euler_angles`` warns: α and γ then have lost half of their digits."""


def euler_rotation(angles: ArrayLike, axes: str | ArrayLike = "zxz") -> np.ndarray:
    """R = e^{α â} e^{β b̂} e^{γ ĉ} [..., 3, 3] of angles (α, β, γ) [..., 3] in radians (A.36), (A.42).

    axes: three letters of x, y, z, or three vectors [3, 3], which are made unit vectors. Raises SceneError where
    neighbours are parallel.
    """
    angles, (a, b, c) = checks.vectors("angles", angles), _axes(axes)
    turns = [rotation_exp(angles[..., [i]] * axis) for i, axis in enumerate((a, b, c))]
    return turns[0] @ turns[1] @ turns[2]


def euler_jacobian(angles: ArrayLike, axes: str | ArrayLike = "zxz") -> np.ndarray:
    """The matrix E [..., 3, 3] of ω = E (α̇, β̇, γ̇), the angular velocity in the body (A.45).

    Its determinant (e^{−β b̂} a)·(b × c) (A.47), −sin β for "zxz" (A.46), vanishes at gimbal lock.
    """
    angles, (a, b, c) = checks.vectors("angles", angles), _axes(axes)
    last, middle = rotation_exp(-angles[..., [2]] * c), rotation_exp(-angles[..., [1]] * b)
    columns = [last @ middle @ a, last @ b, np.broadcast_to(c, angles.shape)]
    return np.stack(columns, axis=-1)


def euler_angles(R: ArrayLike, axes: str = "zxz") -> np.ndarray:
    """Angles (α, β, γ) [..., 3] in radians of rotations [..., 3, 3]: R = ``euler_rotation(angles, axes)`` to round-off.

    axes: three letters of x, y, z. α and γ lie in [−π, π]; β in [0, π] where the first and last axis are the same, and
    in [−π/2, π/2] where all three differ. At gimbal lock, where sin β or cos β vanishes, only a sum or difference of α
    and γ is determined: then α = 0, and near it (below 1e-7) both are inaccurate, though not R. Either is told by a
    RuntimeWarning that names the first such rotation. Raises SceneError for other axes and for matrices that are no
    rotations.
    """
    R = checks.rotations("R", R)
    if not isinstance(axes, str):
        raise arguments.wrong("axes", axes, 'three letters of x, y, z, such as "zxz"')
    a, b, c = _axes(axes)
    d = np.cross(a, b)
    shift = np.arctan2(np.cross(a, c) @ b, a @ c)  # c = e^{shift b̂} a
    basis = np.stack([a, b, d], axis=-1)
    P = basis.T @ R @ rotation_exp(shift * b) @ basis  # = Rx(α) Ry(β + shift) Rx(γ)
    sign = -1.0 if shift < 0 else 1.0  # the branch of β + shift that puts β about 0
    sine = np.hypot(P[..., 1, 0], P[..., 2, 0])
    alpha = np.where(sine > 0, np.arctan2(sign * P[..., 1, 0], -sign * P[..., 2, 0]), 0.0)
    beta = np.arctan2(sign * sine, P[..., 0, 0]) - shift
    # γ from what α leaves: their sum is right where each of them is not.
    left = np.swapaxes(rotation_exp(alpha[..., None] * np.eye(3)[0]), -1, -2) @ P
    gamma = np.arctan2(-left[..., 1, 2], left[..., 1, 1])
    _tell_lock(sine, beta)
    return np.stack([alpha, beta, gamma], axis=-1)


def _tell_lock(sine: np.ndarray, beta: np.ndarray) -> None:
    if (sine < LOCK).any():
        at = checks.first(sine < LOCK)
        warnings.warn(
            f"euler_angles: gimbal lock at R{checks.place(at)}, β = {beta[at]:.6g}: only a sum or difference of α and "
            "γ is determined; use another order of axes, rotation vectors or quaternions",
            RuntimeWarning,
            stacklevel=3,
        )


def _axes(axes: str | ArrayLike) -> np.ndarray:
    """The three unit vectors, as rows."""
    if isinstance(axes, str):
        if len(axes) != 3 or not set(axes) <= set(LETTERS):
            raise arguments.wrong("axes", axes, 'three letters of x, y, z, such as "zxz", or three vectors [3, 3]')
        rows = np.array([LETTERS[letter] for letter in axes])
    else:
        rows = arguments.fitted("axes", axes, (3, 3), "three letters of x, y, z, or three vectors [3, 3]")
        length = np.linalg.norm(rows, axis=1, keepdims=True)
        if (length == 0).any():
            raise arguments.wrong("axes", axes, "three vectors that are not zero")
        rows = rows / length
    if np.linalg.norm(np.cross(rows[:2], rows[1:]), axis=1).min() < LOCK:
        raise arguments.wrong("axes", axes, "three axes of which neighbours are not parallel (A.36)")
    return rows
