"""The planar S that turns in place, as a boundary value problem on half a rod.

The equations of ``steady_u.py``, but the rod turns about its middle at a rate ω, which is unknown: u⊥' = ω − u0 κ,
u0' = κ u⊥. κ, u0, u⊥, f are odd in s and λ is even.
"""

import numpy as np
from scipy.integrate import solve_bvp

from reference.steady_u import DRAG_RATIO, TOLERANCE, slopes


def conditions(start, end, turning):
    """Symmetry at the middle, and the free end."""
    return np.array([start[0], start[2], start[3], start[5], end[0], end[1], end[4], end[6]])


def solved(bend: float, turning: float = -2.0):
    """The solution at this stiffness, from a guess of ω."""
    s = np.linspace(0, 0.5, 201)
    k = 8 * np.sin(2 * np.pi * s)
    angle = 8 / (2 * np.pi) * (1 - np.cos(2 * np.pi * s))
    cells = np.diff(s)
    x, z = (np.append(0, np.cumsum((a[1:] + a[:-1]) / 2 * cells)) for a in (np.cos(angle), np.sin(angle)))
    along, across = turning * (x * np.sin(angle) - z * np.cos(angle)), turning * (x * np.cos(angle) + z * np.sin(angle))
    f = -np.tanh(10 * s)
    y = np.stack([k, np.gradient(k, s), across, along, -0.1 * np.cos(np.pi * s), f, np.gradient(f, s)])

    def turned(s, y, p):
        return slopes(s, y, bend) + np.array([[0.0], [0.0], [1.0], [0.0], [0.0], [0.0], [0.0]]) * p[0]

    found = solve_bvp(turned, conditions, s, y, p=[turning], tol=TOLERANCE, max_nodes=100_000)
    assert found.success, found.message
    return found


def turning_rate(bend: float) -> float:
    """|ω| of the S."""
    return abs(float(solved(bend).p[0]))


def rigid_body_rate(curvature: np.ndarray, activity: np.ndarray) -> float:
    """|ω| of a rigid planar rod with these values [node], on which no moment acts: by the trapezoid rule.

    ∫ (r × t) f ds = ω ∫ [(t·v)² + η (n·v)²] ds, where v is the velocity of a rotation about the middle at the rate 1.
    """
    spacing = 1 / (len(curvature) - 1)

    def integral(values):
        return np.append(0, np.cumsum((values[1:] + values[:-1]) / 2)) * spacing

    angle = integral(curvature)
    along, across = (np.stack(pair) for pair in ((np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle))))
    place = np.stack([integral(part) for part in along])
    place -= place[:, [len(curvature) // 2]]
    moved = np.stack([-place[1], place[0]])
    forward, sideways = np.sum(moved * along, axis=0), np.sum(moved * across, axis=0)
    moment = integral(forward * activity)[-1]
    return abs(float(moment / integral(forward**2 + DRAG_RATIO * sideways**2)[-1]))
