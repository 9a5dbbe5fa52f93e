"""Free active rods in an inertial frame (appendix C.3), on Chebyshev points: the centre line r, the twist Ω0 and f.

An independent form of docs/model.md §2: no frame but the tangent, no strains but the twist. Of (C.16) and (C.18) the
right forms are used, with m and m′ for the printed m′ and m″.
"""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev
from scipy.integrate import solve_ivp

from reference.lie import hat

POINTS = 44
"""Derivatives of r up to the fourth lose ten digits where there are twice as many."""


def chebyshev_points() -> tuple[np.ndarray, np.ndarray]:
    """s in [−1/2, 1/2] and the matrix of d/ds."""
    x = np.cos(np.pi * np.arange(POINTS + 1) / POINTS)[::-1]
    values = chebyshev.chebvander(x, POINTS)
    slopes = np.stack([chebyshev.chebval(x, chebyshev.chebder(c)) for c in np.eye(POINTS + 1)], axis=1)
    return x / 2, 2 * slopes @ np.linalg.inv(values)


@dataclass
class Motion:
    """What (C.12) to (C.19) give at the points: λ, ṙ, ω0, ∂tΩ0, and r′·ṙ′, which vanishes (C.13)."""

    s: np.ndarray
    tension: np.ndarray
    velocity: np.ndarray
    roll: np.ndarray
    twist_rate: np.ndarray
    stretching: np.ndarray

    def at(self, s: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Values interpolated to s."""
        return chebyshev.chebval(2 * s, chebyshev.chebfit(2 * self.s, values, POINTS)).T


def tangents(strain, s: np.ndarray) -> np.ndarray:
    """r′ at s of a rod with the strain Ω(s), the frame of whose middle is the identity."""

    def rate(x, y):
        return (y.reshape(3, 3) @ hat(strain(x))).ravel()

    found = np.zeros((len(s), 3))
    for side in (s >= 0, s < 0):
        order = np.argsort(abs(s[side]))
        ends = (0.0, s[side][order][-1])
        solved = solve_ivp(rate, ends, np.eye(3).ravel(), "DOP853", s[side][order], rtol=1e-13, atol=1e-14)
        found[np.flatnonzero(side)[order]] = solved.y.reshape(3, 3, -1)[:, 0].T
    return found


def dot(a, b):
    return np.sum(a * b, axis=-1)


def evaluate(p, T: np.ndarray, twist: np.ndarray, f: np.ndarray) -> Motion:
    """The motion of a rod with tangents T = r′ [point, 3], twist Ω0 and f [point]; parameters as of reference.free."""
    s, D = chebyshev_points()
    b, c, eta, eta_r = p.bend, p.twist, p.drag_ratio, p.rotational_drag
    r2, r3, r4 = D @ T, D @ D @ T, D @ D @ D @ T
    curvature2 = dot(r2, r2)
    couple = c * twist[:, None] * r2 + b * np.cross(T, r3)  # (c Ω0 r′ + b r′×r″)′, its part across (C.14)
    couple_slope = c * ((D @ twist)[:, None] * r2 + twist[:, None] * r3) + b * (np.cross(r2, r3) + np.cross(T, r4))
    across_slope = np.cross(r2, couple) + np.cross(T, couple_slope)  # Λ⊥′ of Λ⊥ = r′ × couple (C.17)

    turning = dot(T, np.cross(r2, r3))  # κ² τ
    bending = dot(r2, r4) + curvature2**2  # κ κ″ − κ² τ², finite where κ = 0
    source = D @ f + b / 2 * (D @ D @ curvature2) + (c * twist * turning + b * bending) / eta
    matrix = D @ D - np.diag(curvature2 / eta)  # (C.19)
    ends = [0, -1]
    matrix[ends], source[ends] = np.eye(len(s))[ends], 0.0
    tension = np.linalg.solve(matrix, -source)

    force = (D @ tension + f)[:, None] * T + tension[:, None] * r2 + across_slope  # Λ′ + f r′ (C.15)
    along = dot(force, T)[:, None] * T
    velocity = along + (force - along) / eta
    turn = D @ velocity
    m = p.moment * f
    roll = (c * (D @ twist) + m) / eta_r
    return Motion(s, tension, velocity, roll, D @ roll + dot(T, np.cross(r2, turn)), dot(T, turn))
