"""The variational step of a rigid body (docs/model.md §4.2): half turns and momenta. Vectors [..., 3] in the body.

One step takes the frame S to S (H², H y), with H = cay z, z = Δt ω/2 and y = Δt u. The step's p = Jω Δt = 2Jz and
l = Mu Δt are in the frame turned half of the way; ``couple`` is y × l, zero where the mass has no direction.
"""

from __future__ import annotations

import numpy as np

from warp_rods.frames.rotations import cross_matrix

LARGEST_TURN = 1.0
"""Δt |ω| that a step may have: beyond it, errors are of the size of the motion."""
ITERATIONS, CONVERGED = 30, 1e-9
"""Newton steps at most, and the share of Δt ω that the last one may change: what is left is its square."""


def half_turn(J: np.ndarray, M: np.ndarray, moment: np.ndarray, force: np.ndarray, directed: bool) -> np.ndarray | None:
    """z of the step that starts with Δt times this momentum, by Newton's method; None where it turns too far.

    J, M: principal moments and masses; directed: whether M has a direction and moves.
    """
    z = 0.5 * moment / J
    if not (np.linalg.norm(z, axis=-1) <= 0.5 * LARGEST_TURN).all():
        return None
    for _ in range(ITERATIONS):
        found, slope = balance(J, M, z, force, directed)
        change = np.linalg.solve(slope, (found - moment)[..., None])[..., 0]
        z = z - change
        if np.abs(change).max(initial=0.0) <= CONVERGED * np.abs(z).max(initial=0.0):
            return z
    return None


def balance(
    J: np.ndarray, M: np.ndarray, z: np.ndarray, force: np.ndarray, directed: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Δt times the moment at the start of a step with this z and Δt ``force``, and its derivative [..., 3, 3] by z."""
    p, Z = 2 * J * z, cross_matrix(z)
    square, along = 0.25 * np.sum(z * z, axis=-1)[..., None, None], np.sum(z * p, axis=-1)[..., None, None]
    twice_J = 2 * J[..., None] * np.eye(3)
    slope = (1 - square) * twice_J + 0.5 * along * np.eye(3) + Z @ twice_J - cross_matrix(p)
    slope += z[..., :, None] * p[..., None, :] - 0.5 * p[..., :, None] * z[..., None, :]
    if not directed:
        return momentum(z, p, np.zeros(3)), slope
    back = np.swapaxes(cayley(z), -1, -2)
    l = on(back, force)
    y = l / M
    couple, half_way = cross(y, l), np.eye(3) + 0.5 * Z
    by_l = cross_matrix(y) - cross_matrix(l) / M[..., None, :]
    l_by_z = back @ cross_matrix(force) @ half_way / (1 + square)
    return momentum(z, p, couple), slope - 0.25 * cross_matrix(couple) + 0.5 * half_way @ by_l @ l_by_z


def momentum(z: np.ndarray, p: np.ndarray, couple: np.ndarray) -> np.ndarray:
    """(1 + ẑ/2)(p + ½ z × p + ¼ (z·p) z + ½ couple): the moment at the start; with −z, −couple that at the end."""
    square, along = 0.25 * np.sum(z * z, axis=-1, keepdims=True), np.sum(z * p, axis=-1, keepdims=True)
    return (1 - square) * p + 0.5 * along * z + cross(z, p + 0.25 * couple) + 0.5 * couple


def cayley(z: np.ndarray) -> np.ndarray:
    """cay z = (1 − ẑ/2)⁻¹ (1 + ẑ/2), the rotation by 2 arctan(|z|/2)."""
    Z = cross_matrix(z)
    return np.eye(3) + (Z + 0.5 * Z @ Z) / (1 + 0.25 * np.sum(z * z, axis=-1)[..., None, None])


def on(R: np.ndarray, v: np.ndarray) -> np.ndarray:
    """R v."""
    return (R @ v[..., None])[..., 0]


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a × b; three times as fast as NumPy's for a few vectors."""
    return on(cross_matrix(a), b)
